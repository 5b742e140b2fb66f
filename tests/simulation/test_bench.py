"""One joint on a bench: recording, sensors, settings; what holds of every effect, alone and in company."""

from collections.abc import Iterator
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.simulation import IDEAL_SENSORS, BenchSettings, Sensors, simulate
from friction_audit.simulation.effects import EFFECTS, Hidden
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.load_and_place import JointLimitStop
from friction_audit.simulation.sensors import draw_noise, quantise
from friction_audit.simulation.settings import Simulation, TrueMotion
from tests.each_case import thorough

SHORT = BenchSettings(duration_s=20.0)
IDEAL = replace(SHORT, sensors=(IDEAL_SENSORS,))


def only(column: Float) -> Float:
    return column[:, 0]


def test_panda_sensors_have_the_measured_statistics() -> None:
    simulation = simulate(BenchSettings(duration_s=60.0), 13)
    log, motion = simulation.log, simulation.truth.motion
    spacing = np.diff(log.t)
    assert_allclose(spacing.mean(), 1.02e-3, rtol=0.01)
    assert_allclose(spacing.std(), 0.19e-3, rtol=0.1)
    assert_allclose(spacing.max(), 8.8e-3, rtol=0.05)
    repeats = np.all([np.diff(only(channel)) == 0 for channel in log.channels().values()], axis=0)
    assert_allclose(repeats.mean(), 0.056, atol=0.006)
    steps = log.channels()["tau_interaction"] / 0.0357
    assert_allclose(steps, np.rint(steps), atol=1e-6)
    error = only(log.channels()["tau_interaction"]) - np.interp(log.t, motion.t, only(motion.interaction_nm))
    assert_allclose(error.std(), np.hypot(0.055, 0.0357 / np.sqrt(12)), rtol=0.06)
    assert abs(error.mean()) < 0.005
    assert_allclose((only(log.dq) - np.interp(log.t, motion.t, only(motion.dq))).std(), 0.0027, rtol=0.1)


@pytest.mark.parametrize("driven", [False, True], ids=["guided", "driven"])
def test_sensor_reads_gravity_and_the_load_does_not_change_a_rigid_joint(driven: bool) -> None:
    loaded = replace(IDEAL, driven=driven, gravity_nm=5.0, gravity_phase_rad=0.3, logs_sensor=True)
    simulation = simulate(loaded, 17)
    log, motion = simulation.log, simulation.truth.motion
    alone = simulate(replace(loaded, gravity_nm=0.0), 17).truth.motion
    assert_allclose(motion.dq, alone.dq, atol=1e-9)
    assert_allclose(log.channels()["gravity"], 5.0 * np.sin(log.q + 0.3), atol=1e-6)
    assert_allclose(
        log.channels()["tau_J"] - log.channels()["gravity"], (1 if driven else -1) * motion.interaction_nm, atol=1e-5
    )


# At the ends of their ranges effects are still physics; beyond them they are refused.

LIMITS_IDEAL = BenchSettings(duration_s=4.0, sensors=(IDEAL_SENSORS,))


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_every_end_of_every_range_keeps_the_joint_under_the_hand(effect: type[HiddenEffect]) -> None:
    plain = np.abs(simulate(LIMITS_IDEAL, 1).truth.motion.dq).max()
    ends = [(item.name, f"{end:g}") for item in effect.parameters() for end in (item.lower, item.upper)]
    for given in ({name: end} for name, end in ends if end not in ("inf", "-inf")):
        for form in effect.forms or ("",):
            if given.get(effect.strength_name) == "0":
                continue
            group = effect.make(given | ({"form": form} if form else {}))
            motion = simulate(replace(LIMITS_IDEAL, hidden=(Hidden().holding(group),)), 1).truth.motion
            assert np.abs(motion.dq).max() < 2.0 * plain, (given, form)


@pytest.mark.parametrize("form", ["spring_damper", "quadratic"])
def test_the_stiffest_wall_takes_energy(form: str) -> None:
    """Energy that the hand has put in is never less than what friction took and what moves."""
    group = JointLimitStop.make({"stiffness_nm_per_rad": "2000", "damping_s": "0.2", "at_rad": "0.2", "form": form})
    motion = simulate(replace(LIMITS_IDEAL, hidden=(Hidden(joint_limit_stop=group),)), 1).truth.motion
    power = (motion.interaction_nm * motion.dq)[:, 0]
    work = np.cumsum(0.5 * (power[1:] + power[:-1]) * 1e-3)
    kept = motion.dissipated_j[1:, 0] + 0.5 * 0.3 * motion.dq[1:, 0] ** 2
    assert np.abs(motion.q).max() < 0.4
    assert (work - kept).min() > -1e-3 * work[-1]


# Coloured noise.


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_slow_part_keeps_the_variance_and_changes_the_colour(share: float) -> None:
    sensors = Sensors(torque_noise_nm=0.05, torque_correlation_s=0.002, slow_noise_share=share, slow_correlation_s=0.02)
    noise = draw_noise(400_000, 1000.0, sensors, np.random.default_rng(2))[0]
    assert_allclose(noise.std(), 0.05, rtol=0.04)
    for lag in (2, 10, 20):
        expected = (1 - share) * np.exp(-lag / 2) + share * np.exp(-lag / 20)
        assert_allclose(np.corrcoef(noise[lag:], noise[:-lag])[0, 1], expected, atol=0.03)


# What holds of every effect: nothing at zero strength, finite and visible as usual, alone and in company.

SEED = 4
USUAL = BenchSettings(duration_s=10.0)
FINE = replace(USUAL, sensors=(IDEAL_SENSORS,), duration_s=20.0)
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


def hide(effect: type[HiddenEffect], form: str, **numbers: Any) -> Hidden:
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
    simulation, plain = simulate(replace(USUAL, hidden=(hidden,)), SEED), once(USUAL, SEED)
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
@pytest.mark.parametrize("number", [0, 1, *thorough(range(2, 6))])
def test_all_effects_at_once(number: int, driven: bool, logs_sensor: bool) -> None:
    settings = replace(USUAL, logs_sensor=logs_sensor, logs_temperature=True, driven=driven)
    settings = replace(settings, gravity_nm=5.0 * logs_sensor)
    hidden = everything(number)
    if driven:
        hidden = replace(hidden, unlogged_compensation=Hidden().unlogged_compensation)
    simulation = simulate(replace(settings, hidden=(hidden,)), SEED)
    for name, column in columns(simulation):
        assert np.isfinite(column).all(), name
    for name, column in simulation.log.channels().items():
        assert_array_equal(column, quantise(STEPS[name], column))
    motion, temperature = simulation.truth.motion, simulation.log.channels()["temperature"]
    assert np.abs(motion.dq).max() < 5.0
    assert np.isin(temperature, quantise(0.1, 25.0 + 15.0 * motion.warmth)).all()
