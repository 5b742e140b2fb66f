"""What holds of every effect: nothing at zero strength, finite and visible as usual, alone and in company."""

from collections.abc import Iterator
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import EFFECTS, Hidden, HiddenEffect
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.sensors import quantise
from friction_audit.simulation.settings import IDEAL_SENSORS, Simulation, TrueMotion

SEED = 4
PLAIN = BenchSettings(duration_s=20.0)
FINE = replace(PLAIN, sensors=(IDEAL_SENSORS,))
ALONE = [effect for effect in EFFECTS if not effect.needs_neighbours]
CASES = [(effect, form) for effect in ALONE for form in effect.forms or ("",)]
NAMES = [f"{effect.name}-{form}" for effect, form in CASES]

# Effects that change friction and nothing else; what it has taken never comes back. Bristles are springs.
FRICTION = (
    "stribeck", "stiction", "nonlinear_viscous", "asymmetric_coulomb", "asymmetric_viscous", "frictional_lag",
    "load_dependent_friction", "position_dependent_friction", "warm_up", "friction_step",
)  # fmt: skip
READING = ("gravity_error", "torque_bias", "torque_drift", "time_delay")  # change what is read and nothing else
ELSEWHERE = ("cable_spring", "joint_limit_stop", "contact_event", "torque_ripple")  # torques that are no friction


def hide(effect: type[HiddenEffect], form: str, **numbers: float) -> Hidden:
    group = effect.make({"form": form} if form else {})
    return Hidden().holding(replace(group, **numbers))


once = cache(simulate)


def usual(effect: type[HiddenEffect], form: str) -> Simulation:
    return once(replace(FINE, hidden=(hide(effect, form),)), SEED)


def columns(simulation: Simulation) -> Iterator[tuple[str, Any]]:
    """Yield everything that was logged and everything that truly happened."""
    yield "t", simulation.log.t
    yield from simulation.log.channels().items()
    yield from ((item.name, getattr(simulation.truth.motion, item.name)) for item in fields(TrueMotion))


@pytest.mark.parametrize(("effect", "form"), CASES, ids=NAMES)
def test_at_zero_strength_nothing_changes_to_the_bit(effect: type[HiddenEffect], form: str) -> None:
    """Whatever its other numbers; a joint gets warm without an effect on its friction too: warm-up may say how fast."""
    others = {item.name: np.clip(1.3 * item.default + 0.01, item.lower, item.upper) for item in effect.parameters()}
    hidden = hide(effect, form, **others | {effect.strength_name: 0.0})
    simulation, plain = simulate(replace(PLAIN, hidden=(hidden,)), SEED), once(PLAIN, SEED)
    for (name, column), (_, own) in zip(columns(simulation), columns(plain), strict=True):
        if (effect.name, name) != ("warm_up", "warmth"):
            assert_array_equal(column, own, err_msg=name)
    assert simulation.log.source == plain.log.source


@pytest.mark.parametrize(("effect", "form"), CASES, ids=NAMES)
def test_as_usual_it_shows_stays_finite_and_obeys_the_equation_of_motion(effect: type[HiddenEffect], form: str) -> None:
    """B ddq = F_m + u - tau_f at every tick, what else pulls behind the sensor being left over."""
    simulation, without = usual(effect, form), once(FINE, SEED)
    for name, column in columns(simulation):
        assert np.isfinite(column).all(), name
    assert simulation.log.source.sha256 != without.log.source.sha256
    motion, plain = simulation.truth.motion, without.truth.motion
    assert np.abs(motion.dq).max() < 2.0 * np.abs(plain.dq).max()
    if effect.name in READING or form == "reading":
        for item in fields(TrueMotion):
            assert_array_equal(getattr(motion, item.name), getattr(plain, item.name))
    else:
        assert np.abs(motion.q - plain.q).max() > 1e-5
    inertia = 0.3 + (0.1 if effect.name == "inertia_error" else 0.0)
    left = inertia * motion.inner_ddq - (motion.interaction_nm + motion.unlogged_nm - motion.friction_nm)
    if effect.name in ELSEWHERE and form != "reading":
        assert np.abs(left).max() > 1e-3 or form == "drag"
    else:
        assert_allclose(left, 0.0, atol=1e-9)


@pytest.mark.parametrize(("effect", "form"), [(e, f) for e, f in CASES if e.name in FRICTION])
def test_what_goes_in_is_taken_by_friction_or_still_moves(effect: type[HiddenEffect], form: str) -> None:
    motion = usual(effect, form).truth.motion
    taken = motion.dissipated_j[:, 0]
    assert (np.diff(taken) >= 0.0).all()
    kinetic = 0.5 * FINE.joints[0].inertia_kg_m2 * motion.inner_dq[:, 0] ** 2
    torque, held = motion.interaction_nm[:, 0], (motion.unlogged_nm + motion.compensation_nm)[1:, 0]
    work = np.cumsum((0.5 * (torque[1:] + torque[:-1]) + held) * np.diff(motion.inner_q[:, 0]))
    assert_allclose(work, (taken + kinetic)[1:], atol=1e-4 * taken[-1])
    assert (motion.friction_nm * motion.inner_dq >= 0.0).all()


def everything(number: int) -> Hidden:
    """Return all effects at once but stiction or bristles, in the forms that a number chooses."""
    chosen = [effect for effect in EFFECTS if effect.name != ("stiction" if number % 2 else "presliding")]
    forms = [{"form": effect.forms[number % len(effect.forms)]} if effect.forms else {} for effect in chosen]
    return Hidden().holding(*(effect.make(form) for effect, form in zip(chosen, forms, strict=True)))


# Resolutions of what is logged: what is hidden acts before the sensors round.
STEPS = {"q": 1e-6, "dq": 1e-6, "tau_interaction": 0.0357, "tau_J": 0.0357, "gravity": 1e-6} | {
    "tau_ext_hat_filtered": 1e-3, "temperature": 0.1, "tau_compensation": 0.0,
}  # fmt: skip


@pytest.mark.parametrize(("driven", "logs_sensor"), [(False, False), (False, True), (True, True)])
@pytest.mark.parametrize(
    "number", [0, 1, *(pytest.param(number, marks=pytest.mark.thorough) for number in range(2, 6))]
)
def test_all_effects_at_once(number: int, driven: bool, logs_sensor: bool) -> None:
    sensor = {"logs_sensor": logs_sensor, "gravity_nm": 5.0 * logs_sensor}
    settings = replace(PLAIN, **sensor, logs_temperature=True, driven=driven, duration_s=10.0)
    hidden = everything(number)
    if driven:
        hidden = replace(hidden, unlogged_compensation=Hidden().unlogged_compensation)
    simulation = simulate(replace(settings, hidden=(hidden,)), SEED)
    for name, column in columns(simulation):
        assert np.isfinite(column).all(), name
    for name, column in simulation.log.channels().items():
        assert_array_equal(column, quantise(STEPS[name], column))
    assert np.abs(simulation.truth.motion.dq).max() < 5.0
