from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.compensation.compensators import FixedCompensation
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import (
    IDEAL_SENSORS,
    BenchSettings,
    JointParameters,
    Operator,
    Sensors,
    Simulation,
    simulate,
)
from friction_audit.simulation.motion import StopAndGo

SHORT = BenchSettings(duration_s=20.0)
IDEAL = replace(SHORT, sensors=(IDEAL_SENSORS,))
HELPED = replace(IDEAL, compensator=FixedCompensation(coulomb_nm=0.2, viscous_nms_per_rad=0.05))


def only(column: Float) -> Float:
    return column[:, 0]


def work(simulation: Simulation) -> float:
    channels = simulation.log.channels()
    torque = channels["tau_interaction"] + channels.get("tau_compensation", 0.0)
    return float(np.trapezoid(only(torque * simulation.log.dq), simulation.log.t))


# The drive's torque is linear from tick to tick. Its kinks are smaller than what noise hides, but the trapezoidal rule
# at the ticks sees them: some parts in a million of the work.
@pytest.mark.parametrize("settings", [IDEAL, HELPED], ids=["free", "compensated"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_work_of_the_ideal_log_is_what_friction_took(settings: BenchSettings, seed: int) -> None:
    simulation = simulate(settings, seed)
    dq, friction = only(simulation.log.dq), settings.joints[0]
    expected = np.trapezoid(friction.coulomb_nm * np.abs(dq) + friction.viscous_nms_per_rad * dq**2, simulation.log.t)
    taken = simulation.truth.motion.dissipated_j[-1, 0]
    assert_allclose(taken, expected, rtol=2e-6)
    assert_allclose(work(simulation), taken, rtol=1e-6)


def test_sensors_do_not_change_the_motion() -> None:
    ideal, noisy = simulate(IDEAL, 11), simulate(SHORT, 11)
    assert_array_equal(ideal.truth.motion.q, noisy.truth.motion.q)
    assert_array_equal(ideal.log.q, ideal.truth.motion.q)


def test_panda_sensors_have_the_measured_statistics() -> None:
    simulation = simulate(BenchSettings(duration_s=60.0), 13)
    log, motion = simulation.log, simulation.truth.motion
    spacing = np.diff(log.t)
    assert_allclose(spacing.mean(), 1.02e-3, rtol=0.01)
    assert_allclose(spacing.std(), 0.19e-3, rtol=0.1)
    assert_allclose(spacing.max(), 8.8e-3, rtol=0.05)
    repeats = np.all([np.diff(only(channel)) == 0 for channel in log.channels().values()], axis=0)
    assert_allclose(repeats.mean(), 0.056, atol=0.006)
    assert log.tau_interaction is not None
    steps = log.tau_interaction / 0.0357
    assert_allclose(steps, np.rint(steps), atol=1e-6)
    error = only(log.tau_interaction) - np.interp(log.t, motion.t, only(motion.interaction_nm))
    assert_allclose(error.std(), np.hypot(0.055, 0.0357 / np.sqrt(12)), rtol=0.06)
    assert abs(error.mean()) < 0.005
    assert_allclose((only(log.dq) - np.interp(log.t, motion.t, only(motion.dq))).std(), 0.0027, rtol=0.1)


@pytest.mark.parametrize("driven", [False, True], ids=["guided", "driven"])
def test_sensor_reads_gravity_and_the_load_does_not_change_a_rigid_joint(driven: bool) -> None:
    loaded = replace(IDEAL, driven=driven, gravity_nm=5.0, gravity_phase_rad=0.3, logs_sensor=True)
    simulation = simulate(loaded, 17)
    log, motion = simulation.log, simulation.truth.motion
    alone = simulate(replace(loaded, gravity_nm=0.0), 17).truth.motion
    assert log.tau_J is not None
    assert log.gravity is not None
    assert_allclose(motion.dq, alone.dq, atol=1e-9)
    assert_allclose(log.gravity, 5.0 * np.sin(log.q + 0.3), atol=1e-6)
    assert_allclose(log.tau_J - log.gravity, (1 if driven else -1) * motion.interaction_nm, atol=1e-5)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: JointParameters(inertia_kg_m2=0.0), "inertia_kg_m2 0: expected a number above zero"),
        (lambda: JointParameters(coulomb_nm=-0.1), "coulomb_nm -0.1: expected zero or more"),
        (lambda: Operator(stiffness_nm_per_rad=0.0), "stiffness_nm_per_rad 0: expected a number above zero"),
        (lambda: StopAndGo(pause_s=(1.0, 0.5)), "pause_s 1, 0.5: expected the smaller number first"),
        (lambda: StopAndGo(range_rad=(0.5, 1.0)), "expected a range around the start"),
        (lambda: Sensors(lost=0.9), "expected shares up to 0.5"),
        (lambda: Sensors(torque_noise_nm=1e6), "torque_noise_nm 1e\\+06: expected a number from 0 to 1000"),
        (lambda: Sensors(torque_step_nm=1e-12), "torque_step_nm 1e-12: expected 0, for none, or at least 1e-09"),
        (lambda: BenchSettings(duration_s=1e6), "duration_s 1e\\+06: expected at most 7200"),
        (lambda: BenchSettings(duration_s=1e-4), "expected at least 2 sampling intervals"),
        (lambda: BenchSettings(rate_hz=2000.0), "rate_hz 2000: expected at most 1000"),
        (lambda: BenchSettings(gravity_nm=1.0), "cannot log the interaction torque; expected logs_sensor=true"),
        (lambda: BenchSettings(driven=True), "cannot log the interaction torque; expected logs_sensor=true"),
        (lambda: replace(HELPED, driven=True, logs_sensor=True), "compensator takes a hand that moves the joint"),
    ],
)
def test_settings_out_of_range_are_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        make()
