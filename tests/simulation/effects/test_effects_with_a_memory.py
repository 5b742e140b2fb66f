"""Effects that remember: bristles the path, a frictional lag the speed, contacts when they began."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import velocity as laws
from friction_audit.simulation.effects.slow_and_events import KNOCK, STEP, ContactEvent, contact_event_nm, draw_events
from friction_audit.simulation.mechanics.records import pack

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
def test_delayed_is_exact_on_a_ramp_whatever_the_steps(steps: list[float], lag: float) -> None:
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
    return contact_event_nm(pack([ContactEvent(torque_nm=1.0, form=form)])[0], events, t, velocity)


def test_a_knock_is_half_a_sine_a_step_is_there_and_gone_and_steps_add_up() -> None:
    found = [contact(t, 0.0, KNOCK) for t in (1.0, 1.05, 1.1, 1.3)]
    assert found == pytest.approx([0.0, 2.0 * math.sqrt(0.5), 2.0, 0.0])
    assert [contact(t, 0.0, STEP) for t in (0.99, 1.0, 1.19, 1.21)] == [0.0, 2.0, 2.0, 0.0]
    assert [contact(t, 0.0, STEP) for t in (5.05, 5.15, 5.25, 5.45)] == [-3.0, -2.0, -3.0, 0.0]


@unhurried
@given(seed=st.integers(0, 2**31), duration=st.floats(0.04, 300.0), per_minute=st.floats(0.1, 60.0))
def test_events_are_ordered_short_and_over_before_the_end(seed: int, duration: float, per_minute: float) -> None:
    group = ContactEvent(torque_nm=0.5, per_minute=per_minute)
    start, length, size = draw_events(group, duration, np.random.default_rng(seed)).T
    assert len(start) >= 1
    assert np.all(np.diff(start, prepend=0.0) >= 0.0)
    assert np.all(start + length <= duration + 1e-9)
    assert np.all((length >= min(0.05, duration)) & (length <= 0.5))
    assert np.all((np.abs(size) > 0.0) & (np.abs(size) <= 5.0 * 0.5))
