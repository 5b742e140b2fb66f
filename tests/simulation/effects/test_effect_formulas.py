"""The simulator's formulas against numbers by hand; what holds for all forms; effects that remember."""

import math
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import EFFECTS, slow_and_events as slow, velocity as laws
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.sensors import TorqueDrift, delayed, torque_drift_nm
from friction_audit.simulation.effects.structure import coupled_mass
from friction_audit.simulation.mechanics.records import pack

CLASSES = {effect.name: effect for effect in EFFECTS}
E1 = math.exp(-1.0)


def made(name: str, form: str = "", **numbers: Any) -> HiddenEffect:
    cls = CLASSES[name]
    return cls(form=cls.forms.index(form) if form else 0, **numbers)


def value(name: str, function: str, form: str, numbers: dict[str, float], *args: float) -> float:
    """Of a law as Python: to compile each by itself takes seconds."""
    law: Callable[..., Any] = getattr(import_module(CLASSES[name].__module__), function).py_func
    return float(law(pack([made(name, form, **numbers)]).view(np.recarray)[0], *args))


S, ST = {"excess_nm": 0.3, "speed_rad_s": 0.1}, {"excess_nm": 0.2, "dwell_s": 0.5}
LOG, NV = {"excess_nm": 0.2, "dwell_s": 1e-3}, {"torque_nm": 0.2}
P = {"share": 0.4, "cycles_per_rev": 2.0, "phase_rad": 0.0}
C = {"stiffness_nm_per_rad": 0.4, "centre_rad": 0.2, "free_rad": 0.3}
W = {"stiffness_nm_per_rad": 20.0, "at_rad": 0.8, "damping_s": 0.02}
SPRING, GAP = {"compliance_rad_per_nm": 1e-3, "damping_ratio": 0.05}, {"gap_rad": 2e-3}
STEP, HEAT = {"change": 0.5, "at_share": 1.0 / 3.0}, {"reduction": 0.5, "time_s": 60.0, "power_w": 0.2}

# Effect, function, form, numbers, arguments, expected; forms that equal a column are in ``test_effect_contract.py``.
BY_HAND: list[tuple[str, str, str, dict[str, float], tuple[float, ...], float]] = [
    ("stribeck", "stribeck_nm", "lorentzian", S, (0.1,), 0.15),
    ("stribeck", "stribeck_nm", "piecewise", S, (0.1,), 0.0),
    ("stribeck", "stribeck_nm", "piecewise", S, (0.0,), 0.3),
    ("stiction", "stiction_nm", "saturating", ST, (0.5,), 0.2 * (1 - E1)),
    ("stiction", "stiction_nm", "saturating", ST, (0.0,), 0.0),
    ("stiction", "stiction_nm", "logarithmic", LOG, (10.0,), 0.2),
    ("stiction", "stiction_nm", "logarithmic", LOG, (1000.0,), 0.2 * math.log1p(1e6) / math.log1p(1e4)),
    ("stiction", "stiction_nm", "immediate", ST, (0.0,), 0.2),
    ("nonlinear_viscous", "nonlinear_viscous_nm", "cubic", NV, (2.0,), 1.6),
    ("nonlinear_viscous", "nonlinear_viscous_nm", "eyring", NV, (1.0,), 0.2),
    ("nonlinear_viscous", "nonlinear_viscous_nm", "arctan", NV, (1e9,), 0.1 * math.pi / math.atan(10.0)),
    ("load_dependent_friction", "load_friction_nm", "backdrive", {"share": 0.1}, (-5.0, 1.0), 0.75),
    ("load_dependent_friction", "load_friction_nm", "backdrive", {"share": 0.1}, (-5.0, -1.0), 0.25),
    ("load_dependent_friction", "load_friction_nm", "backdrive", {"share": 0.1}, (-5.0, 0.0), 0.5),
    ("position_dependent_friction", "position_factor", "patch", P, (math.pi,), 1.4),
    ("position_dependent_friction", "position_factor", "patch", P, (math.acos(1 - math.log(2) / 8) / 2,), 1.2),
    (
        "position_dependent_friction", "position_factor", "harmonics", P, (math.pi / 4,),
        1.2 + 0.12 * math.sin(math.sqrt(3) * math.pi / 2) + 0.08 * math.sin(math.sqrt(7) * math.pi / 2),
    ),
    ("torque_ripple", "cogging_nm", "cogging", {"torque_nm": 0.1, "second_share": 0.3}, (math.pi / 400,), 0.07),
    ("torque_ripple", "cogging_nm", "reading", {"torque_nm": 0.1}, (0.3,), 0.0),
    ("cable_spring", "cable_spring_nm", "hardening", C, (1.2,), -0.8),
    ("cable_spring", "cable_spring_nm", "tether", C, (0.7,), -0.08),
    ("cable_spring", "cable_spring_nm", "tether", C, (-0.9,), 0.0),
    ("joint_limit_stop", "limit_stop_nm", "spring_damper", W, (0.7, 1.0), 0.0),
    ("joint_limit_stop", "limit_stop_nm", "spring_damper", W, (0.9, 1.0), -2.4),
    ("joint_limit_stop", "limit_stop_nm", "spring_damper", W, (0.81, -1.0), 0.0),
    ("joint_limit_stop", "limit_stop_nm", "quadratic", W, (0.85, 0.0), -0.5),
    ("joint_limit_stop", "limit_stop_nm", "quadratic", W, (-0.85, -1.0), 0.6),
    ("joint_limit_stop", "limit_stop_nm", "exponential", W, (0.85, 0.0), -math.e),
    ("joint_limit_stop", "limit_stop_nm", "exponential", W, (100.0, 0.0), -math.exp(20.0)),  # it stays finite
    ("joint_elasticity", "elastic_torque_nm", "linear", SPRING, (-2e-3,), -2.0),
    ("joint_elasticity", "elastic_torque_nm", "hardening", SPRING, (2e-3,), 2.0 - math.tanh(1.0)),
    ("backlash", "engaged", "", GAP, (-0.9e-3,), 0.0),
    ("backlash", "engaged", "", GAP, (1.5e-3,), 0.5e-3),
    ("backlash", "engaged", "", {}, (0.3,), 0.3),
    ("warm_up", "warm_up_advance", "ambient", HEAT, (0.0, 5.0, 60.0), 1 - E1),
    ("warm_up", "warm_up_advance", "self_heating", HEAT, (0.0, 0.1, 1e6), 0.5),
    ("warm_up", "warm_up_advance", "self_heating", HEAT, (1.0, 0.0, 60.0), E1),
    ("warm_up", "warm_up_viscous_factor", "ambient", {"reduction": 0.4}, (0.5,), math.sqrt(0.6)),
    ("warm_up", "warm_up_coulomb_factor", "ambient", {"reduction": 0.4}, (1.0,), 0.8),
    ("friction_step", "friction_step_factor", "settling", STEP, (1.0, 22.0, 60.0), 1.5 - 0.5 * math.exp(-0.4)),
    ("friction_step", "friction_step_factor", "settling", STEP, (1.0, 19.999, 60.0), 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "function", "form", "numbers", "args", "expected"), BY_HAND)
def test_by_hand(
    name: str, function: str, form: str, numbers: dict[str, float], args: tuple[float, ...], expected: float
) -> None:
    assert value(name, function, form, numbers, *args) == pytest.approx(expected, rel=1e-9, abs=1e-12)


# Monotonic and passive laws: effect, function, strength, direction of growth over speed, rest or warmth.
LAWS = [
    ("stribeck", "stribeck_nm", S, -1),
    ("stiction", "stiction_nm", ST, 1),
    ("nonlinear_viscous", "nonlinear_viscous_nm", NV, 1),
]
LAWS += [("warm_up", "warm_up_coulomb_factor", HEAT, -1), ("warm_up", "warm_up_viscous_factor", HEAT, -1)]


@pytest.mark.parametrize(
    ("name", "function", "numbers", "sign", "form"),
    [(name, function, numbers, sign, form) for name, function, numbers, sign in LAWS for form in CLASSES[name].forms],
)
@given(one=st.floats(0.0, 5.0), other=st.floats(0.0, 5.0))
def test_friction_grows_or_falls_and_never_drives(
    name: str, function: str, numbers: dict[str, float], sign: int, form: str, one: float, other: float
) -> None:
    low, high = (value(name, function, form, numbers, at) for at in sorted((one, other)))
    assert sign * (high - low) >= 0.0
    assert min(low, high) >= 0.0


@given(warmth=st.floats(0.0, 10.0), power=st.floats(0.0, 2.0), h=st.floats(0.0, 100.0))
def test_two_half_steps_of_warming_make_a_step(warmth: float, power: float, h: float) -> None:
    for form in slow.WarmUp.forms:
        half = value("warm_up", "warm_up_advance", form, HEAT, warmth, power, 0.5 * h)
        whole = value("warm_up", "warm_up_advance", form, HEAT, warmth, power, h)
        assert value("warm_up", "warm_up_advance", form, HEAT, half, power, 0.5 * h) == pytest.approx(whole, abs=1e-12)


# Errors of sensors


def drift(form: str, seed: int = 0, torque_nm: float = 0.3) -> Float:
    group = TorqueDrift(torque_nm=torque_nm, form=TorqueDrift.forms.index(form))
    return torque_drift_nm(group, np.linspace(5.0, 65.0, 601), np.random.default_rng(seed))


def test_drifts_by_hand_and_the_scatter_of_random_walks() -> None:
    assert_allclose(drift("ramp", torque_nm=-0.3)[[0, 200, 600]], [0.0, -0.1, -0.3])
    assert_allclose(drift("thermal")[[0, 200, 600]], [0.0, 0.3 / (1 - math.exp(-3)) * (1 - E1), 0.3])
    walks = np.array([drift("random_walk", seed) for seed in range(2000)])
    assert_allclose(walks[:, [0, 150, 600]].std(axis=0), [0.0, 0.15, 0.3], rtol=0.06)
    assert not drift("random_walk", torque_nm=0.0).any()


@pytest.mark.parametrize("steps", [0.0, 1.0, 2.25, 7.0, 80.0])
def test_a_delay_line_shifts_samples_and_reads_between_them(steps: float) -> None:
    ramp = np.arange(50.0)
    assert_allclose(delayed(steps * 1e-4, ramp, 1e-4), np.maximum(ramp - steps, 0.0), atol=1e-9)
    assert_array_equal(delayed(0.0, ramp**2, 1e-4), ramp**2)


@given(
    inertias=st.lists(st.floats(0.0, 2.0), min_size=7, max_size=7).map(np.array),
    ratios=st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array),
    speeds=st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array),
)
def test_kinetic_energy_is_that_of_the_rotors(inertias: Float, ratios: Float, speeds: Float) -> None:
    mass = coupled_mass(inertias, ratios)
    turning = speeds + np.concatenate(([0.0], ratios[1:] * speeds[:-1]))
    assert_array_equal(mass, mass.T)
    assert_allclose(speeds @ mass @ speeds, inertias @ turning**2, atol=1e-12)
    assert_allclose(coupled_mass(np.array([0.5, 0.3]), np.array([9.0, 0.2])), [[0.512, 0.06], [0.06, 0.3]])


# Effects that remember: bristles the path, a frictional lag the speed, contacts when they began.

unhurried = settings(deadline=None)  # the first call compiles
EACH_FORM = pytest.mark.parametrize("form", range(3))
COULOMB_NM, DISPLACEMENT_RAD = 0.3, 0.005
SIGMA0 = COULOMB_NM / DISPLACEMENT_RAD
YIELDS = DISPLACEMENT_RAD * laws.FIRST_YIELD * np.arange(1, laws.BRISTLES + 1)
PATHS = st.floats(-0.02, 0.02).filter(lambda path: abs(path) > 1e-9)


class Bristles:
    """laws.Presliding of one joint that moves along pieces of path."""

    def __init__(self, form: int, damping_s: float = 0.0) -> None:
        self.group = pack([laws.Presliding(displacement_rad=DISPLACEMENT_RAD, damping_s=damping_s, form=form)])[0]
        self.form = form
        self.deflection: Float = np.zeros(laws.BRISTLES)

    def move(self, path: float, *, level: float = COULOMB_NM, velocity: float = 0.1, steps: int = 1) -> float:
        signed = math.copysign(velocity, path)
        for _ in range(steps):
            laws.presliding_advance(self.group, self.deflection, COULOMB_NM, level, signed, path / signed / steps)
        return laws.presliding_force_nm(self.group, self.deflection, COULOMB_NM, level, signed)

    @property
    def stored_j(self) -> float:
        if self.form == laws.MAXWELL_SLIP:
            return float(0.5 * np.sum(COULOMB_NM / (laws.BRISTLES * YIELDS) * self.deflection**2))
        return float(0.5 * SIGMA0 * self.deflection[0] ** 2)


@EACH_FORM
def test_steady_motion_meets_the_level_and_a_short_path_a_spring(form: int) -> None:
    for level, sign in ((0.2, 1.0), (0.3, -1.0), (0.5, 1.0)):
        friction = Bristles(form, damping_s=0.005).move(100.0 * sign, level=level, steps=100)
        assert friction == pytest.approx(level * sign, rel=1e-4)
    assert Bristles(form).move(1e-7) == pytest.approx(SIGMA0 * 1e-7, rel=1e-4)
    assert Bristles(form).move(1.0, level=0.0, steps=10) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("exponent", "share"), [(0.5, 0.75), (1.0, 1.0 - math.exp(-1.0)), (1.5, 1.0 - 1.5**-2), (2.0, 0.5)]
)
def test_dahl_after_its_displacement(exponent: float, share: float) -> None:
    """Brittle: 1 - (1 - x/2)^2, as LuGre: 1 - exp(-x), then 1 - (1 + x/2)^-2, ductile: 1 - 1/(1 + x)."""
    z = laws.dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, DISPLACEMENT_RAD / 0.1, exponent)
    assert z * SIGMA0 == pytest.approx(COULOMB_NM * share)
    if exponent == 1.0:
        assert Bristles(laws.LUGRE).move(DISPLACEMENT_RAD) == pytest.approx(z * SIGMA0)
    if exponent < 1.0:
        assert SIGMA0 * laws.dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, 5.0, exponent) == pytest.approx(COULOMB_NM)


@EACH_FORM
@unhurried
@given(path=PATHS, start=st.floats(-0.01, 0.01), level=st.floats(0.1, 1.0))
def test_many_steps_go_where_one_goes(form: int, path: float, start: float, level: float) -> None:
    one, many = Bristles(form), Bristles(form)
    one.deflection[:] = many.deflection[:] = start
    assert many.move(path, level=level, steps=20) == pytest.approx(one.move(path, level=level), abs=1e-9)


@EACH_FORM
@unhurried
@given(
    pieces=st.lists(st.tuples(PATHS, st.floats(0.05, 1.0), st.floats(1e-3, 3.0)), min_size=1, max_size=20),
    damping=st.floats(0.0, 0.1),
)
def test_no_path_takes_energy_from_friction(
    form: int, pieces: list[tuple[float, float, float]], damping: float
) -> None:
    # also while the level changes; the force at the end of a step is that which makes the steps passive too
    bristles = Bristles(form, damping_s=damping)
    taken = 0.0
    for path, level, velocity in pieces:
        taken += bristles.move(path, level=level, velocity=velocity) * path
        assert taken >= bristles.stored_j - 1e-12


# Frictional lag

H = 1e-4


def seen(speeds: Any, steps: Any, **numbers: float) -> list[float]:
    group = pack([laws.FrictionalLag(**numbers)])[0]  # type: ignore[arg-type]
    memory = np.zeros(laws.LAG_MEMORY)
    return [laws.frictional_lag_speed(group, memory, value, h) for value, h in zip(speeds, steps, strict=True)]


def test_relaxing_has_63_percent_of_a_jump_after_the_lag_and_delayed_all_of_it() -> None:
    assert seen([1.0] * 100, [H] * 100, lag_s=0.01, form=laws.RELAXING)[-1] == pytest.approx(1.0 - math.exp(-1.0))
    late = seen([1.0] * 400, [H] * 400, lag_s=0.03, form=laws.DELAYED)
    assert max(late[:294]) == 0.0
    assert min(late[305:]) == 1.0


@unhurried
@given(steps=st.lists(st.floats(0.0, 3e-3), min_size=1, max_size=200), lag=st.floats(1e-4, 0.05))
def test_delayed_is_exact_on_a_ramp_with_any_steps(steps: list[float], lag: float) -> None:
    t = np.cumsum(steps)
    # the corner of the ramp at t = 0 is a sample, so that only times before the start differ from a line
    late = seen(3.0 * t, steps, lag_s=lag, form=laws.DELAYED)
    np.testing.assert_allclose(late, 3.0 * np.maximum(0.0, t - lag), atol=1e-9)


@pytest.mark.parametrize("form", [laws.RELAXING, laws.DELAYED])
@unhurried
@given(speeds=st.lists(st.floats(0.0, 3.0), min_size=1, max_size=100), h=st.floats(0.0, 0.01))
def test_friction_sees_no_speed_that_never_was_and_without_a_lag_the_speed_itself(
    form: int, speeds: list[float], h: float
) -> None:
    late = seen(speeds, [h] * len(speeds), lag_s=0.01, form=form)
    assert -1e-12 <= min(late) <= max(late) <= max(speeds) + 1e-12
    assert seen(speeds, [h] * len(speeds), form=form) == speeds


# Contacts

EVENTS = np.array([[1.0, 0.2, 2.0], [5.0, 0.4, -3.0], [5.1, 0.1, 1.0]])


def contact(t: float, velocity: float, form: int, events: Float = EVENTS) -> float:
    return slow.contact_event_nm(pack([slow.ContactEvent(torque_nm=1.0, form=form)])[0], events, t, velocity)


def test_a_knock_is_half_a_sine_a_step_is_there_and_gone_and_steps_add_up() -> None:
    found = [contact(t, 0.0, slow.KNOCK) for t in (1.0, 1.05, 1.1, 1.3)]
    assert found == pytest.approx([0.0, 2.0 * math.sqrt(0.5), 2.0, 0.0])
    assert [contact(t, 0.0, slow.STEP) for t in (0.99, 1.0, 1.19, 1.21)] == [0.0, 2.0, 2.0, 0.0]
    assert [contact(t, 0.0, slow.STEP) for t in (5.05, 5.15, 5.25, 5.45)] == [-3.0, -2.0, -3.0, 0.0]


@unhurried
@given(seed=st.integers(0, 2**31), duration=st.floats(0.04, 300.0), per_minute=st.floats(0.1, 60.0))
def test_events_are_ordered_short_and_over_before_the_end(seed: int, duration: float, per_minute: float) -> None:
    group = slow.ContactEvent(torque_nm=0.5, per_minute=per_minute)
    start, length, size = slow.draw_events(group, duration, np.random.default_rng(seed)).T
    assert len(start) >= 1
    assert np.all(np.diff(start, prepend=0.0) >= 0.0)
    assert np.all(start + length <= duration + 1e-9)
    assert np.all((length >= min(0.05, duration)) & (length <= 0.5))
    assert np.all((np.abs(size) > 0.0) & (np.abs(size) <= 5.0 * 0.5))
