"""Pushes are seen by what they change against the noise's own colour, and nothing else is taken for one."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from friction_audit.diagnosis.pushes import Push, bridged, find_pushes
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import two_sines

MOTION = two_sines()
STEP_S = MOTION.step_s
CLEAR = np.ones(len(MOTION.t), bool)
NOTHING = np.zeros(len(MOTION.t))
TURNS = np.flatnonzero(np.diff(np.sign(MOTION.dq)) != 0)
TURNING = np.min(np.abs(np.arange(len(MOTION.t))[:, None] - TURNS), axis=1) <= round(0.025 / STEP_S)


def slow_noise(memory_s: float, seed: int = 3) -> Float:
    """Noise of standard deviation 1 that forgets exponentially."""
    rng, kept = np.random.default_rng(seed), np.exp(-STEP_S / memory_s)
    noise = rng.normal(size=len(MOTION.t))
    for k in range(1, len(noise)):
        noise[k] = kept * noise[k - 1] + np.sqrt(1.0 - kept**2) * noise[k]
    return noise


def box(start_s: float, length_s: float, size: float) -> Float:
    return np.where((MOTION.t >= start_s) & (MOTION.t < start_s + length_s), size, 0.0)


def found(left: Float, known: Float = NOTHING, data: JointData = MOTION) -> tuple[Push, ...]:
    return find_pushes(data, left, known, CLEAR, ~CLEAR, ~CLEAR)


def found_about_turns(left: Float, rests: NDArray[np.bool_] = ~CLEAR) -> tuple[Push, ...]:
    return find_pushes(MOTION, left, NOTHING, ~(TURNING | rests), TURNING | rests, rests)


@pytest.mark.parametrize("memory_s", [0.002, 0.02, 0.1])
def test_noise_of_any_memory_holds_none(memory_s: float) -> None:
    assert found(slow_noise(memory_s)) == ()


def test_a_push_is_seen_by_its_flanks_where_a_mean_over_it_is_like_the_noise() -> None:
    noise, size = slow_noise(0.1), 2.8
    means = np.convolve(noise, np.ones(40) / 40.0, mode="valid")
    assert size < 4.0 * np.std(means)
    (one,) = found(noise + box(30.0, 0.2, size))
    assert one.start_s == pytest.approx(30.0, abs=0.03)
    assert one.stop_s == pytest.approx(30.2, abs=0.03)
    assert one.size > 5.5


def test_the_sign_is_the_push_s() -> None:
    sizes = {round(one.start_s): one.size for one in found(slow_noise(0.1) + box(20, 0.2, 4.0) - box(40, 0.2, 4.0))}
    assert sizes[20] > 0.0 > sizes[40]


def test_units_of_measurement_change_nothing() -> None:
    left = slow_noise(0.02) + box(30.0, 0.2, 1.5)
    assert [one.size for one in found(1e3 * left)] == pytest.approx([one.size for one in found(left)])


def test_a_wild_sample_is_no_push() -> None:
    wild = np.zeros(len(MOTION.t))
    wild[4000] = 60.0
    assert found(slow_noise(0.02) + wild) == ()


def test_a_sample_out_of_place_times_the_inertia_is_no_push() -> None:
    bump = np.exp(-(((MOTION.t - 30.0) / 0.05) ** 2))
    hat = np.gradient(np.gradient(bump, MOTION.t), MOTION.t)
    assert found(slow_noise(0.02) + 8.0 * hat / np.abs(hat).max()) == ()
    assert len(found(slow_noise(0.02) + 8.0 * bump)) >= 1


def test_what_comes_at_the_same_place_and_speed_in_other_cycles_is_no_push() -> None:
    w = 2.0 * np.pi / 3.0
    q, dq, ddq = np.sin(w * MOTION.t), w * np.cos(w * MOTION.t), -(w**2) * np.sin(w * MOTION.t)
    sine = replace(MOTION, q=q, dq=dq, ddq=ddq, cycle=((MOTION.t + 0.75) // 3.0).astype(np.int64))
    bump = 3.0 * ((np.abs(q) < 0.1) & (dq > 0.0))
    assert found(slow_noise(0.02) + bump, data=sine) == ()
    assert len(found(slow_noise(0.02) + bump * (sine.cycle == 9), data=sine)) == 1


def test_what_is_far_smaller_than_what_was_taken_off_there_may_be_its_formula() -> None:
    left = slow_noise(0.1) + box(30.0, 0.2, 4.0)
    assert len(found(left, box(30.0, 0.2, 8.0))) == 1
    assert found(left, box(30.0, 0.2, 80.0)) == ()


def test_nothing_is_looked_for_where_little_is_clear() -> None:
    assert find_pushes(MOTION, slow_noise(0.1) + box(30.0, 0.2, 5.0), NOTHING, MOTION.t < 1.0, ~CLEAR, ~CLEAR) == ()


def test_a_model_that_lacks_more_the_faster_the_joint_is_accelerated_holds_none() -> None:
    burst = 1.0 + 7.0 * np.exp(-(((MOTION.t - 30.0) / 4.0) ** 2))
    data = replace(MOTION, ddq=burst)
    assert found(slow_noise(0.002) * burst) != ()
    assert found(slow_noise(0.002) * burst, data=data) == ()


@pytest.mark.parametrize("memory_s", [0.002, 0.02, 0.1])
def test_noise_at_reversals_holds_none(memory_s: float) -> None:
    assert found_about_turns(slow_noise(memory_s)) == ()


@pytest.mark.parametrize("late_s", [-0.2, -0.1, 0.0])
def test_a_push_that_turns_the_joint_is_seen(late_s: float) -> None:
    at = float(MOTION.t[TURNS[20]])
    (one,) = found_about_turns(slow_noise(0.02) + box(at + late_s, 0.2, 4.0))
    assert one.start_s < at + late_s + 0.1 < one.stop_s
    assert one.size > 0.0


def test_errors_at_reversals_are_none_however_large_unless_one_is_far_larger() -> None:
    sizes = np.random.default_rng(0).normal(scale=4.0, size=len(TURNS))
    errors = np.sum([box(float(MOTION.t[k]), 0.1, size) for k, size in zip(TURNS, sizes, strict=True)], axis=0)
    assert found_about_turns(slow_noise(0.02) + errors) == ()
    at = float(MOTION.t[TURNS[20]])
    pushes = found_about_turns(slow_noise(0.02) + errors + box(at, 0.1, 50.0))
    assert pushes
    assert all(abs(push.start_s - at) < 0.5 for push in pushes)


def test_what_shows_only_while_the_joint_rests_may_be_held_by_friction() -> None:
    at, noise = float(MOTION.t[TURNS[20]]), slow_noise(0.02)
    rests = np.abs(MOTION.t - at) < 0.225
    assert found_about_turns(noise + box(at - 0.2, 0.4, 6.0), rests) == ()
    assert len(found_about_turns(noise + box(at - 0.2, 0.8, 6.0), rests)) >= 1


def test_what_shows_only_while_friction_is_on_its_way_may_be_friction() -> None:
    winding = np.abs(MOTION.t - 30.0) < 0.1
    left = slow_noise(0.02) + box(29.9, 0.2, 6.0)
    assert len(found(left)) >= 1
    assert find_pushes(MOTION, left, NOTHING, CLEAR, ~CLEAR, winding) == ()


def test_a_smaller_push_during_alike_motion_is_not_its_repetition() -> None:
    w = 2.0 * np.pi / 20.0
    q, dq, ddq = np.sin(w * MOTION.t), w * np.cos(w * MOTION.t), -(w**2) * np.sin(w * MOTION.t)
    sine = replace(MOTION, q=q, dq=dq, ddq=ddq, cycle=((MOTION.t + 5.0) // 10.0).astype(np.int64))
    pushes = found(slow_noise(0.02) + box(20.0, 0.2, 8.0) + box(40.0, 0.2, 5.0), data=sine)
    assert sorted({round(one.start_s) for one in pushes}) == [20, 40]


def test_what_is_far_smaller_than_inertia_and_friction_is_what_they_get_wrong() -> None:
    left, brisk = slow_noise(0.002) + box(30.0, 0.2, 5.0), box(30.0, 0.2, 200.0)
    (push,) = found(left, data=replace(MOTION, torque=left + 0.1 * brisk))
    assert push.start_s == pytest.approx(30.0, abs=0.1)
    assert found(left, data=replace(MOTION, torque=left + brisk)) == ()


def test_lines_lead_over_a_gap_from_medians_of_a_quarter_of_it() -> None:
    signal = np.array([9.0, 9.0, 1.0, 1.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 3.0, 3.0, 8.0])
    counts = np.ones(len(signal), bool)
    counts[5:13] = False
    # A gap of eight is nine steps, a quarter of it two samples: (1 + 7) / 2 before it, (5 + 3) / 2 behind.
    assert bridged(signal, counts, 3)[5:13] == pytest.approx(4.0)
    assert bridged(signal, counts, 1)[5:13] == pytest.approx(np.interp(range(5, 13), [4, 13], [7.0, 5.0]))
    assert np.array_equal(bridged(signal, counts, 3)[counts], signal[counts])
    counts[:2] = False
    assert bridged(signal, counts, 3)[:2] == pytest.approx(1.0)


def test_lines_lead_where_an_encoder_s_noise_would_lead_a_median_astray() -> None:
    position = np.random.default_rng(5).standard_normal(4002)
    noise, counts = np.diff(position, 2), np.arange(4000) % 200 < 100
    lines = bridged(noise, counts, 20)[~counts]
    medians = [np.median(noise[k - 20 : k]) for k in range(100, 4000, 200)]
    assert np.std(lines) < 0.25 * np.std(medians)
