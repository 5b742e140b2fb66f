from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.errors import InputError
from friction_audit.io.checks import examine
from friction_audit.io.readers import read_log
from friction_audit.io.readers.read import to_joint_log
from friction_audit.io.readers.reader import ReadOptions
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, JointLog
from friction_audit.preprocessing.interaction_torque import extract_interaction
from friction_audit.preprocessing.segmentation import segment_cycles
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from tests.io.synthetic_recordings import motion, recording, tidy_frame


def vetted(given_recording: Recording, options: ReadOptions | None = None) -> JointLog:
    used = options or ReadOptions()
    examined = examine(given_recording, path="run.log", robot=used.robot, time_scale=used.time_scale)
    return to_joint_log(examined, path="run.log", sha256="0" * 64, format="test")


def finding(log: JointLog, code: str) -> Finding:
    found = [finding for finding in log.source.findings if finding.code == code]
    assert len(found) == 1, f"{code} not once in {[f.code for f in log.source.findings]}"
    return found[0]


def codes(log: JointLog) -> list[str]:
    return [finding.code for finding in log.source.findings]


def test_a_clean_recording_passes_unchanged() -> None:
    log = vetted(recording())
    assert codes(log) == []
    assert log.t[0] == 0.0
    assert len(log.t) == 3000
    np.testing.assert_array_equal(log.dq, recording().channels["dq"])
    assert log.q.flags.f_contiguous


def test_time_starts_at_zero_and_the_start_follows() -> None:
    given_recording = recording()
    given_recording.t += 5.0
    given_recording.start_s = 1.7e9
    log = vetted(given_recording)
    assert log.t[0] == 0.0
    assert log.source.start_s == 1.7e9 + 5.0


def test_an_empty_channel_is_dropped() -> None:
    given_recording = recording()
    given_recording.channels["tau_J_d"] = np.full((3000, 3), np.nan)
    log = vetted(given_recording)
    assert log.tau_J_d is None
    assert finding(log, "empty_channel").amount == 3000


def test_the_only_torque_is_nan() -> None:
    given_recording = recording()
    given_recording.channels["tau_J"][:] = np.nan
    given_recording.mapping = {"tau_J": "effort.{i}"}
    with pytest.raises(InputError, match=r"tau_J \(effort.\{i\}\): none of the 3000 rows holds a number"):
        vetted(given_recording)


def test_rows_with_nan_or_infinity_are_left_out() -> None:
    given_recording = recording()
    given_recording.channels["q"][10, 0] = np.nan
    given_recording.channels["tau_J"][20, 2] = np.inf
    given_recording.t[30] = np.nan
    log = vetted(given_recording)
    noticed = finding(log, "non_finite")
    assert (noticed.amount, noticed.damaged, len(log.t)) == (3, True, 2997)


def test_absurd_numbers_count_as_damage() -> None:
    given_recording = recording()
    given_recording.channels["q"][10, 0] = 1e300
    assert finding(vetted(given_recording), "non_finite").amount == 1


def test_a_joint_without_data_is_dropped() -> None:
    given_recording = recording()
    given_recording.channels["tau_J"][:, 1] = np.nan
    log = vetted(given_recording)
    assert log.joint_names == ("panda_joint1", "panda_joint3")
    assert finding(log, "empty_joint").joint == 2


def test_a_sparse_channel_is_dropped_and_its_rows_are_kept() -> None:
    given_recording = recording()
    given_recording.channels["temperature"] = np.full((3000, 3), 30.0)
    given_recording.channels["temperature"][1::2] = np.nan
    log = vetted(given_recording)
    assert log.temperature is None
    assert len(log.t) == 3000
    assert finding(log, "sparse_channel").amount == 1500


def test_rows_out_of_order_are_sorted() -> None:
    given_recording = recording()
    order = np.arange(3000)
    order[[100, 101]] = [101, 100]
    given_recording.t = given_recording.t[order]
    given_recording.channels = {c: np.asfortranarray(a[order]) for c, a in given_recording.channels.items()}
    log = vetted(given_recording)
    assert finding(log, "unordered").amount == 1
    np.testing.assert_array_equal(log.q, recording().channels["q"])


def test_time_that_runs_backwards_is_refused_with_row_and_amount() -> None:
    given_recording = recording()
    given_recording.t[2000:] -= 2.0
    with pytest.raises(InputError, match=r"goes back at 1 of 2999 rows, by up to 1.999 s at row 2001"):
        vetted(given_recording)


def test_reversed_time_is_refused() -> None:
    given_recording = recording(300)
    given_recording.t = given_recording.t[::-1].copy()
    with pytest.raises(InputError, match="goes back at 299 of 299 rows"):
        vetted(given_recording)


def test_constant_time_is_refused() -> None:
    given_recording = recording()
    given_recording.t[:] = 4.0
    with pytest.raises(InputError, match="is the same in all 3000 rows"):
        vetted(given_recording)


def test_duplicate_stamps_keep_the_first() -> None:
    given_recording = recording()
    given_recording.t[50] = given_recording.t[49]
    log = vetted(given_recording)
    assert finding(log, "duplicate_stamps").amount == 1
    np.testing.assert_array_equal(log.q, np.delete(recording().channels["q"], 50, axis=0))


def test_stale_samples_are_dropped_while_the_arm_moves() -> None:
    given_recording = recording()
    for array in given_recording.channels.values():
        array[101:104] = array[100]
    log = vetted(given_recording)
    noticed = finding(log, "stale_samples")
    assert noticed.amount == 3
    assert "0.1%" in noticed.message
    assert len(log.t) == 2997


def test_equal_rows_at_rest_are_kept() -> None:
    given_recording = recording()
    for channel, array in given_recording.channels.items():
        array[2000:] = 0.0 if channel == "dq" else array[2000]
    assert "stale_samples" not in codes(vetted(given_recording))


def test_a_torque_that_changes_makes_a_row_fresh() -> None:
    given_recording = recording()
    for channel in ("q", "dq"):
        given_recording.channels[channel][101] = given_recording.channels[channel][100]
    assert "stale_samples" not in codes(vetted(given_recording))


def without(given_recording: Recording, rows: list[int]) -> Recording:
    channels = {c: np.asfortranarray(np.delete(a, rows, axis=0)) for c, a in given_recording.channels.items()}
    return replace(given_recording, t=np.delete(given_recording.t, rows), channels=channels)


def test_dropped_samples_are_counted() -> None:
    log = vetted(without(recording(), [100, 500, 501, 502]))
    assert finding(log, "dropped_samples").amount == 4
    assert "gap" not in codes(log)


def test_gaps_are_counted_and_do_not_count_as_jitter() -> None:
    log = vetted(without(recording(), [*range(1000, 1200), *range(2000, 2100)]))
    noticed = finding(log, "gap")
    assert noticed.amount == 2
    assert "longest 0.201 s" in noticed.message
    assert "jitter" not in codes(log)


def test_jitter_is_measured() -> None:
    rng = np.random.default_rng(1)
    given_recording = recording(20_000)
    given_recording.t += rng.uniform(-0.3e-3, 0.3e-3, 20_000)
    amount = finding(vetted(given_recording), "jitter").amount
    assert amount is not None
    # The difference of two uniform errors of half width a has the variance 2 a^2/3; long steps count as holes.
    assert 0.15e-3 < amount <= 0.3e-3 * np.sqrt(2 / 3) * 1.02


@pytest.mark.parametrize("size", [2, 3, 4, 50])
def test_samples_of_a_batch_are_put_a_period_apart(size: int) -> None:
    given_recording = recording(6000)
    even, place = given_recording.t.copy(), np.arange(6000) % size
    given_recording.t = even[np.arange(6000) - place + size - 1] - 1e-5 * (size - 1 - place)
    log = vetted(given_recording)
    assert finding(log, "batched_stamps").amount == 6000 / size
    np.testing.assert_allclose(log.t, even - even[0], atol=1e-9)
    assert "dropped_samples" not in codes(log)


def test_batches_of_a_long_log_are_seen_wherever_it_begins() -> None:
    """More samples than are looked at for the rate; the first pair is half a pair."""
    samples = np.arange(140_001)
    given_recording = recording(len(samples), joints=1)
    even = given_recording.t.copy()
    given_recording.t = even + np.where(samples % 2 == 1, 9e-4, 0.0)
    log = vetted(given_recording)
    assert finding(log, "batched_stamps").amount == 70_001
    assert np.diff(log.t) == pytest.approx(1e-3)


def test_a_backlog_is_spread_over_the_time_since_the_last_batch() -> None:
    """Eight samples come with a batch of four's time: half a period apart, still in order."""
    given_recording = recording(4000)
    t = np.repeat(np.arange(1, 1001) * 4e-3, 4) - np.tile([3e-4, 2e-4, 1e-4, 0.0], 1000)
    t[2000:2008] = t[2007] - np.arange(7, -1, -1) * 1e-5
    given_recording.t = np.sort(t)
    assert np.diff(vetted(given_recording).t).min() > 0.4e-3


def test_jitter_and_single_holes_are_no_batches() -> None:
    rng = np.random.default_rng(3)
    given_recording = without(recording(20_000), [*range(1000, 1200), *range(5000, 20_000, 50)])
    given_recording.t += rng.uniform(-0.3e-3, 0.3e-3, len(given_recording.t))
    assert "batched_stamps" not in codes(vetted(given_recording))


def test_a_low_rate_is_named() -> None:
    assert finding(vetted(recording(900, rate_hz=30.0)), "low_rate").amount == pytest.approx(30.0)


@pytest.mark.parametrize(("turned", "named"), [(("q",), 1), (("dq",), 1)])
def test_degrees_are_told_by_the_ratio(turned: tuple[str, ...], named: int) -> None:
    given_recording = recording()
    for channel in turned:
        given_recording.channels[channel] *= 180.0 / np.pi
    log = vetted(given_recording)
    assert codes(log).count("degrees") == named
    np.testing.assert_allclose(log.q, recording().channels["q"], atol=1e-12)
    np.testing.assert_allclose(log.dq, recording().channels["dq"], atol=1e-12)


def test_degrees_in_both_are_told_by_the_magnitudes() -> None:
    given_recording = recording()
    for channel in ("q", "dq"):
        given_recording.channels[channel] *= 180.0 / np.pi
    log = vetted(given_recording)
    assert codes(log) == ["degrees", "degrees"]
    np.testing.assert_allclose(log.q, recording().channels["q"], atol=1e-12)


def test_a_rig_that_turns_without_end_is_not_turned_into_radians() -> None:
    given_recording = recording(joints=1)
    t = given_recording.t[:, None]
    given_recording.channels |= {"q": 40.0 * t, "dq": 40.0 + 0.1 * np.sin(3.0 * t)}
    log = vetted(given_recording)
    assert codes(log) == ["degrees_suspected"]
    assert log.q[-1, 0] == pytest.approx(40.0 * 2.999)


def test_a_rig_that_may_be_in_degrees_is_refused_with_the_way_to_say_it(tmp_path: Path) -> None:
    """58 and 110 to and fro: degrees, or a motor of nine turns."""
    arrays = motion(3000, 1)
    columns = {"t": arrays["t"], "tau_J": arrays["tau_J"][:, 0]}
    columns |= {"q": arrays["q"][:, 0] * 116.0, "dq": arrays["dq"][:, 0] * 116.0}
    pd.DataFrame(columns).to_csv(tmp_path / "rig.csv", index=False)
    with pytest.raises(InputError, match=r"degrees.*--map q=q:deg --map dq=dq:deg"):
        read_log(tmp_path / "rig.csv")
    turned = read_log(tmp_path / "rig.csv", ReadOptions(mapping={"q": "q:deg", "dq": "dq:deg"}))
    assert turned.q[:, 0].max() == pytest.approx(np.deg2rad(58.0), rel=1e-3)
    kept = read_log(tmp_path / "rig.csv", ReadOptions(mapping={"q": "q:rad", "dq": "dq:rad"}))
    assert kept.q[:, 0].max() == pytest.approx(58.0, rel=1e-3)


def test_two_recordings_in_one_file_are_named_with_the_row(tmp_path: Path) -> None:
    both = pd.concat([tidy_frame(3000)] * 2)
    both.to_csv(tmp_path / "two.csv", index=False)
    with pytest.raises(InputError, match=r"2 recordings in one file: cut it before row 3001"):
        read_log(tmp_path / "two.csv")


def test_a_torque_that_may_be_in_millinewton_metres_is_noticed_and_kept() -> None:
    given_recording = recording()
    given_recording.channels["tau_J"][:, 2] = 1500.0 * np.sign(np.sin(given_recording.t))
    log = vetted(given_recording)
    found = finding(log, "torque_unit_suspected")
    assert (found.joint, found.amount) == (3, 1500.0)
    assert log.tau_J is not None
    assert np.abs(log.tau_J[:, 2]).max() == 1500.0


def test_a_few_wild_torques_are_no_unit() -> None:
    given_recording = recording()
    given_recording.channels["tau_J"][::100, 0] = 9000.0
    assert "torque_unit_suspected" not in codes(vetted(given_recording))


def test_a_mapped_current_makes_the_unit_of_the_log_ampere() -> None:
    given_recording = recording()
    given_recording.mapping = {"q": "actual_q_{i}", "tau_J": "actual_current_{i}"}
    assert vetted(given_recording).source.torque_unit == "A"
    assert vetted(recording()).source.torque_unit == "N m"


@pytest.mark.parametrize("stretch", [0.8, 0.96, 1.04, 1.3])
def test_a_stretched_clock_is_noticed_and_kept(stretch: float) -> None:
    given_recording = recording()
    given_recording.t *= stretch
    log = vetted(given_recording)
    noticed = finding(log, "clock_stretched")
    assert noticed.amount == pytest.approx(1.0 / stretch, rel=2e-3)
    assert log.duration_s == pytest.approx(2.999 * stretch)


def test_the_time_scale_mends_a_stretched_clock() -> None:
    given_recording = recording()
    given_recording.t *= 2.0
    log = vetted(given_recording, ReadOptions(time_scale=0.5))
    assert codes(log) == []
    assert log.duration_s == pytest.approx(2.999)


def test_a_clock_stretched_too_far_is_refused() -> None:
    given_recording = recording()
    given_recording.t *= 2.0
    with pytest.raises(InputError, match=r"q changes 0\.5 times the integral of dq over time; .*--time-scale 0\.5"):
        vetted(given_recording)


def uneven(given_recording: Recording, seed: int = 5) -> Recording:
    """Round the stamps to 2 ms and lose 18 % of the rows."""
    kept = np.flatnonzero(np.random.default_rng(seed).uniform(size=len(given_recording.t)) > 0.18)
    given_recording.t = np.round(given_recording.t / 2e-3) * 2e-3
    return replace(
        given_recording,
        t=given_recording.t[kept],
        channels={c: np.asfortranarray(a[kept]) for c, a in given_recording.channels.items()},
    )


def test_a_clock_wrong_by_two_is_seen_on_uneven_stamps() -> None:
    given_recording = recording(6000)
    given_recording.t *= 2.0
    with pytest.raises(InputError, match=r"q changes 0\.5 times .*--time-scale 0\.5.*or dq has another scale"):
        vetted(uneven(given_recording))
    assert vetted(uneven(recording(6000))).source.clock_windows > 20


def slow(speed_rad_s: float) -> Recording:
    """A joint that creeps: 3 mrad in half a second at 6 mrad/s."""
    given_recording = recording(60_000, joints=1)
    t = given_recording.t[:, None]
    given_recording.channels |= {"q": 10.0 * speed_rad_s * np.sin(0.1 * t), "dq": speed_rad_s * np.cos(0.1 * t)}
    return given_recording


def test_a_stretched_clock_is_seen_on_a_joint_that_creeps() -> None:
    given_recording = slow(3e-3)
    given_recording.t *= 1.25
    assert finding(vetted(given_recording), "clock_stretched").amount == pytest.approx(0.8, rel=1e-3)


def test_a_clock_that_cannot_be_checked_has_no_windows() -> None:
    given_recording = recording()
    given_recording.channels["q"][:] = 1.0
    given_recording.channels["dq"][:] = 0.0
    assert vetted(given_recording).source.clock_windows == 0
    assert vetted(recording()).source.clock_windows > 0


def standing(given_recording: Recording, joints: list[int]) -> Recording:
    """Let some joints stand still with noise and offset of their velocity; the encoder of each flickers and jumps."""
    rng = np.random.default_rng(2)
    for joint in joints:
        given_recording.channels["q"][:, joint] = 6e-3 * rng.integers(0, 2, len(given_recording.t))
        given_recording.channels["q"][1000:, joint] += 0.05
        given_recording.channels["dq"][:, joint] = 0.01 + 4e-3 * rng.standard_normal(len(given_recording.t))
    return given_recording


def test_joints_that_stand_still_neither_vote_nor_are_accused() -> None:
    """Four of seven joints stand still, whatever their torque; the clock of the three that move is right, or is not."""
    assert codes(vetted(standing(recording(6000, joints=7), [0, 2, 4, 6]))) == []
    given_recording = standing(recording(6000, joints=7), [0, 2, 4, 6])
    given_recording.t *= 1.1
    log = vetted(given_recording)
    assert codes(log) == ["clock_stretched"]
    assert finding(log, "clock_stretched").amount == pytest.approx(1 / 1.1, rel=2e-3)


def test_both_explanations_of_a_ratio_are_given() -> None:
    given_recording = recording(joints=1)
    given_recording.channels["dq"] *= 1.1
    message = finding(vetted(given_recording), "clock_stretched").message
    assert "--time-scale 0.909" in message
    assert "multiply dq by 0.909" in message


@pytest.mark.parametrize("joints", [2, 7])
def test_a_velocity_of_another_scale_on_some_joints_is_the_velocity_s(joints: int) -> None:
    given_recording = recording(joints=joints)
    given_recording.channels["dq"][:, joints - 1] *= 1.6
    log = vetted(given_recording)
    assert codes(log) == ["velocity_scale"]
    noticed = finding(log, "velocity_scale")
    assert noticed.joint == joints
    assert noticed.amount == pytest.approx(1 / 1.6, rel=1e-3)


def test_revolutions_per_minute_are_turned_into_radians_per_second() -> None:
    given_recording = recording()
    given_recording.channels["dq"] *= 30.0 / np.pi
    log = vetted(given_recording)
    assert codes(log) == ["velocity_unit"]
    np.testing.assert_allclose(log.dq, recording().channels["dq"], atol=1e-12)


def test_a_velocity_that_is_one_number_while_the_joint_moves_is_refused() -> None:
    given_recording = recording()
    given_recording.channels["dq"][:] = 0.0
    with pytest.raises(InputError, match=r"dq .* is 0 in all 3000 rows while q moves by 1"):
        vetted(given_recording)
    given_recording = recording()
    given_recording.channels["dq"][:, 1] = 0.0
    assert finding(vetted(given_recording), "velocity_dead").joint == 2


@pytest.mark.parametrize("torque", ["zero", "constant", "a few counts"])
def test_a_dead_torque_is_named_by_joint(torque: str) -> None:
    given_recording = recording()
    counts = np.random.default_rng(1).integers(-3, 4, len(given_recording.t)) * 1e-3
    least = {"zero": 0.0, "constant": 4.2, "a few counts": 0.0}[torque]
    given_recording.channels["tau_J"][:, 1] = least + (counts if torque == "a few counts" else 0.0)
    log = vetted(given_recording)
    assert codes(log) == ["torque_dead"]
    assert log.source.dead_torque == {2}


def test_a_torque_of_coarse_steps_is_named_with_the_step() -> None:
    given_recording = recording()
    given_recording.channels["tau_J"] = np.asfortranarray(np.round(2.0 * given_recording.channels["tau_J"]))
    assert [one.amount for one in vetted(given_recording).source.findings] == [1.0, 1.0, 1.0]
    assert set(codes(vetted(given_recording))) == {"torque_coarse"}
    given_recording = recording()
    given_recording.channels["tau_J"] = np.asfortranarray(np.round(given_recording.channels["tau_J"], 2))
    assert codes(vetted(given_recording)) == []
    given_recording.channels["tau_J"] = np.asfortranarray(0.3 * np.sign(given_recording.channels["dq"]))
    assert codes(vetted(given_recording)) == []


def bus(seconds: float = 60.0) -> Recording:
    """One motor of a bus of seven, asked in every seventh row of 100 Hz, that pauses between its strokes."""
    t = np.arange(round(100 * seconds)) / 100.0
    moves = t % 20.0 < 14.0
    dq = np.where(moves, 0.6 * np.cos(1.2 * t), 0.0)
    q = np.cumsum(dq) * 0.01
    held = np.arange(len(t)) // 7 * 7
    channels = {"q": q, "dq": dq, "tau_interaction": 0.3 * np.sign(dq) + 0.1 * dq}
    return Recording(t=t, channels={c: a[held][:, None] for c, a in channels.items()}, joint_names=("joint5",))


def test_rows_that_repeat_a_slow_state_are_kept_and_make_no_holes() -> None:
    log = vetted(bus())
    assert codes(log) == ["slow_state"]
    assert finding(log, "slow_state").amount == pytest.approx(0.07)
    interaction = extract_interaction(log, TorqueSettings())
    cycles = segment_cycles(interaction, CycleSettings())
    assert len(cycles.reason) > 15
    assert (cycles.reason == 0).mean() > 0.9


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_misjudged_unit_of_time_is_mended(factor: float) -> None:
    given_recording = recording()
    given_recording.t *= factor
    log = vetted(given_recording)
    assert finding(log, "time_unit").amount == pytest.approx(1.0 / factor)
    assert log.duration_s == pytest.approx(2.999)


@pytest.mark.parametrize("delay", [5, 20])
def test_a_delay_of_the_velocity_is_no_stretched_clock(delay: int) -> None:
    given_recording = recording()
    given_recording.channels = {
        c: np.asfortranarray(a[delay:] if c == "q" else a[:-delay]) for c, a in given_recording.channels.items()
    }
    given_recording.t = given_recording.t[delay:].copy()
    assert codes(vetted(given_recording)) == []


def test_a_wrong_column_is_named_by_joint() -> None:
    given_recording = recording(joints=7)
    given_recording.channels["q"][:, 4] = 0.5 * np.sin(1.3 * given_recording.t)
    log = vetted(given_recording)
    assert finding(log, "position_mismatch").joint == 5


def test_a_joint_with_the_other_sign_is_named() -> None:
    given_recording = recording(joints=7)
    given_recording.channels["q"][:, 2] *= -1.0
    assert finding(vetted(given_recording), "position_mismatch").joint == 3


def test_noise_of_a_real_arm_is_no_finding() -> None:
    rng = np.random.default_rng(3)
    given_recording = recording(joints=7)
    given_recording.channels["q"] += 1e-5 * rng.standard_normal((3000, 7))
    given_recording.channels["dq"] += 2e-3 * rng.standard_normal((3000, 7))
    assert codes(vetted(given_recording)) == []


def test_rest_is_no_finding() -> None:
    rng = np.random.default_rng(3)
    given_recording = recording(joints=7)
    given_recording.channels["q"][:] = 1.0 + 1e-5 * rng.standard_normal((3000, 7))
    given_recording.channels["dq"][:] = 1e-3 * rng.standard_normal((3000, 7))
    assert codes(vetted(given_recording)) == []


@pytest.mark.parametrize("samples", [0, 1])
def test_too_few_samples(samples: int) -> None:
    with pytest.raises(InputError, match=f"{samples} sample"):
        vetted(recording(samples))


def test_too_few_samples_left() -> None:
    given_recording = recording(3)
    given_recording.t[1:] = np.nan
    with pytest.raises(InputError, match=r"1 sample; .*2 of 3 rows hold NaN"):
        vetted(given_recording)


def _with_nan(given_recording: Recording, row: int) -> None:
    given_recording.channels["dq"][row] = np.nan


def _with_old_stamp(given_recording: Recording, row: int) -> None:
    given_recording.t[row] = given_recording.t[row - 1]


def _with_repeat(given_recording: Recording, row: int) -> None:
    for array in given_recording.channels.values():
        array[row] = array[row - 1]


@settings(max_examples=30, deadline=None)
@given(
    faults=st.lists(
        st.tuples(st.sampled_from([_with_nan, _with_old_stamp, _with_repeat]), st.integers(1, 299)), max_size=20
    )
)
def test_whatever_the_faults_the_log_keeps_its_promises(
    faults: list[tuple[Callable[[Recording, int], None], int]],
) -> None:
    given_recording = recording(300)
    for fault, row in faults:
        fault(given_recording, row)
    log = vetted(given_recording)
    lost = sum(
        f.amount or 0 for f in log.source.findings if f.code in ("non_finite", "duplicate_stamps", "stale_samples")
    )
    assert len(log.t) + lost == 300
