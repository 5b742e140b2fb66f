from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulate import (
    IDEAL_SENSORS,
    PANDA_SENSORS,
    Compensation,
    JointParameters,
    JointSettings,
    Operator,
    Sensors,
    Simulation,
    simulate_joint,
)
from friction_audit.simulate.operator import plan_strokes

SHORT = JointSettings(duration_s=20.0)
IDEAL = replace(SHORT, sensors=IDEAL_SENSORS)
HELPED = replace(IDEAL, compensation=Compensation(coulomb_nm=0.2, viscous_nms_per_rad=0.05))


def work(simulation: Simulation) -> float:
    channels = simulation.log.channels()
    torque = channels["tau_interaction"] + channels.get("tau_compensation", 0.0)
    return float(np.trapezoid((torque * simulation.log.dq)[:, 0], simulation.log.t))


@pytest.mark.parametrize("settings", [IDEAL, HELPED], ids=["free", "compensated"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_work_of_the_ideal_log_is_what_friction_took(settings: JointSettings, seed: int) -> None:
    simulation = simulate_joint(settings, seed)
    dq, friction = simulation.log.dq[:, 0], settings.joint
    expected = np.trapezoid(friction.coulomb_nm * np.abs(dq) + friction.viscous_nms_per_rad * dq**2, simulation.log.t)
    assert_allclose(work(simulation), expected, rtol=1e-6)
    assert_allclose(work(simulation), simulation.truth.motion.dissipated_j[-1], rtol=1e-6)


def test_energy_balance_holds_at_every_sample() -> None:
    simulation = simulate_joint(IDEAL, 3)
    motion, inertia = simulation.truth.motion, IDEAL.joint.inertia_kg_m2
    power = motion.interaction_nm * motion.dq
    net = np.concatenate(([0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(motion.t))))
    assert_allclose(net, motion.dissipated_j + inertia * motion.dq**2 / 2, atol=1e-5 * net[-1])


def test_every_stroke_of_the_ideal_log_gives_the_coefficients() -> None:
    log = simulate_joint(IDEAL, 4).log
    assert log.tau_interaction is not None
    dq, power = log.dq[:, 0], (log.tau_interaction * log.dq)[:, 0]
    starts = np.flatnonzero(np.diff((dq != 0).astype(int)) == 1)
    rows = []
    for start, stop in pairwise([*starts, len(dq) - 1]):
        part = slice(start, stop + 1)
        rows.append([np.trapezoid(y[part], log.t[part]) for y in (np.abs(dq), dq**2, power)])
    table = np.array(rows)
    coefficients = np.linalg.lstsq(table[:, :2], table[:, 2])[0]
    assert_allclose(coefficients, [0.30, 0.07], rtol=1e-5)


def test_equation_of_motion_holds_at_every_tick() -> None:
    motion = simulate_joint(HELPED, 5).truth.motion
    net = motion.interaction_nm + motion.compensation_nm - motion.friction_nm
    assert_allclose(HELPED.joint.inertia_kg_m2 * motion.ddq, net, atol=1e-12)
    moving = motion.dq != 0
    sliding = 0.30 * np.sign(motion.dq) + 0.07 * motion.dq
    assert_allclose(motion.friction_nm[moving], sliding[moving], atol=1e-12)


def test_friction_holds_the_joint_still_within_the_coulomb_level() -> None:
    motion = simulate_joint(IDEAL, 6).truth.motion
    still = motion.dq == 0
    assert 0.05 < still.mean() < 0.5
    assert np.abs(motion.friction_nm[still]).max() <= 0.30 + 1e-12
    assert_array_equal(np.diff(motion.q)[still[1:] & still[:-1]], 0.0)


def test_position_is_the_integral_of_velocity() -> None:
    motion = simulate_joint(IDEAL, 7).truth.motion
    path = np.concatenate(([0.0], np.cumsum((motion.dq[1:] + motion.dq[:-1]) / 2 * np.diff(motion.t))))
    assert_allclose(motion.q, path, atol=1e-5)


def test_frictionless_joint_dissipates_nothing() -> None:
    free = JointParameters(inertia_kg_m2=0.2, coulomb_nm=0.0, viscous_nms_per_rad=0.0)
    simulation = simulate_joint(replace(IDEAL, joint=free), 8)
    assert simulation.truth.motion.dissipated_j[-1] == 0.0
    assert_allclose(work(simulation), 0.2 * simulation.log.dq[-1, 0] ** 2 / 2, atol=1e-6)


def test_same_seed_same_log_to_the_bit() -> None:
    one, two, other = (simulate_joint(SHORT, seed).log for seed in (9, 9, 10))
    assert_array_equal(one.t, two.t)
    for name, channel in one.channels().items():
        assert_array_equal(channel, two.channels()[name])
    assert one.source == two.source
    assert one.source.sha256 != other.source.sha256


def test_sensors_do_not_change_the_motion() -> None:
    ideal, noisy = simulate_joint(IDEAL, 11), simulate_joint(SHORT, 11)
    assert_array_equal(ideal.truth.motion.q, noisy.truth.motion.q)
    assert_array_equal(ideal.log.q[:, 0], ideal.truth.motion.q)


def test_source_does_not_tell_the_truth() -> None:
    source = simulate_joint(SHORT, 12, path="bench.csv").log.source
    assert (source.path, source.format, source.robot) == ("bench.csv", "simulation", "unknown")
    assert not source.findings
    assert "0.3" not in repr(replace(source, sha256=""))


def test_panda_sensors_have_the_measured_statistics() -> None:
    simulation = simulate_joint(JointSettings(duration_s=60.0), 13)
    log, motion = simulation.log, simulation.truth.motion
    spacing = np.diff(log.t)
    assert_allclose(spacing.mean(), 1.02e-3, rtol=0.01)
    assert_allclose(spacing.std(), 0.19e-3, rtol=0.1)
    assert_allclose(spacing.max(), 8.8e-3, rtol=0.05)
    repeats = np.all([np.diff(channel[:, 0]) == 0 for channel in log.channels().values()], axis=0)
    assert_allclose(repeats.mean(), 0.056, atol=0.006)
    assert log.tau_interaction is not None
    steps = log.tau_interaction / 0.0357
    assert_allclose(steps, np.rint(steps), atol=1e-6)
    error = log.tau_interaction[:, 0] - np.interp(log.t, motion.t, motion.interaction_nm)
    assert_allclose(error.std(), np.hypot(0.055, 0.0357 / np.sqrt(12)), rtol=0.06)
    assert abs(error.mean()) < 0.005
    assert_allclose((log.dq[:, 0] - np.interp(log.t, motion.t, motion.dq)).std(), 0.0027, rtol=0.1)


def test_torque_noise_is_correlated() -> None:
    sensors = Sensors(torque_noise_nm=0.05, torque_correlation_s=0.01)
    simulation = simulate_joint(replace(SHORT, sensors=sensors), 14)
    assert simulation.log.tau_interaction is not None
    noise = simulation.log.tau_interaction[:, 0] - simulation.truth.motion.interaction_nm
    assert_allclose(np.corrcoef(noise[10:], noise[:-10])[0, 1], np.exp(-1), atol=0.08)


def test_hidden_errors_are_added_to_the_measured_torque() -> None:
    hidden = simulate_joint(replace(IDEAL, torque_offset_nm=0.1, gravity_error_nm=0.2), 15).log
    clean = simulate_joint(IDEAL, 15).log
    assert hidden.tau_interaction is not None
    assert clean.tau_interaction is not None
    assert_allclose(hidden.tau_interaction - clean.tau_interaction, 0.1 + 0.2 * np.sin(clean.q), atol=1e-12)


def test_compensator_is_silent_in_its_dead_band_and_eases_the_hand() -> None:
    helped, alone = simulate_joint(HELPED, 16), simulate_joint(IDEAL, 16)
    log = helped.log
    assert log.tau_compensation is not None
    slow = np.abs(log.dq) <= 0.02
    assert_array_equal(log.tau_compensation[slow], 0.0)
    assert_allclose(log.tau_compensation[~slow], (0.2 * np.sign(log.dq) + 0.05 * log.dq)[~slow], atol=1e-12)
    assert alone.log.tau_compensation is None
    by_hand = np.trapezoid((log.channels()["tau_interaction"] * log.dq)[:, 0], log.t)
    assert by_hand < 0.6 * work(alone)


@pytest.mark.parametrize("seed", range(5))
def test_strokes_vary_and_stay_in_the_range(seed: int) -> None:
    strokes = plan_strokes(Operator(), 120.0, np.random.default_rng(seed))
    speeds, ends = strokes.peak_speed_rad_s, strokes.origin_rad + strokes.length_rad
    assert 50 <= len(speeds) <= 80
    assert speeds.std() / speeds.mean() >= 0.30
    assert np.abs(ends).max() <= 1.2 + 1e-12
    assert_allclose(strokes.origin_rad[1:], ends[:-1])
    pauses = strokes.start_s[1:] - (strokes.start_s + strokes.duration_s)[:-1]
    assert pauses.min() >= 0.2
    assert strokes.start_s[-1] + strokes.duration_s[-1] <= 119.5


def test_time_too_short_for_a_stroke_is_a_log_at_rest() -> None:
    log = simulate_joint(JointSettings(duration_s=1.0, sensors=IDEAL_SENSORS), 17).log
    assert len(log.t) == 1001
    assert_array_equal(log.dq, 0.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: JointParameters(inertia_kg_m2=0.0), "inertia_kg_m2 0: expected a number above zero"),
        (lambda: JointParameters(coulomb_nm=-0.1), "coulomb_nm -0.1: expected zero or more"),
        (lambda: Operator(pause_s=(1.0, 0.5)), "pause_s 1, 0.5: expected the smaller number first"),
        (lambda: Operator(range_rad=(0.5, 1.0)), "expected a range around the start"),
        (lambda: Sensors(lost=0.9), "expected shares up to 0.5"),
        (lambda: JointSettings(duration_s=1e-4), "expected at least 2 samples"),
    ],
)
def test_settings_out_of_range_are_refused(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(UsageError, match=words):
        make()


def test_distal_joints_are_quieter() -> None:
    assert len(PANDA_SENSORS) == 7
    assert PANDA_SENSORS[6].torque_step_nm < PANDA_SENSORS[0].torque_step_nm
