"""Each fault of a recording is noticed with its amount, handled or refused; a sound recording passes unchanged."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings, strategies as st

from friction_audit.errors import InputError
from friction_audit.io.checks import examine
from friction_audit.io.readers import ReadOptions, to_joint_log
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, Float, JointLog
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.reporting.notices import NO_PHYSICS, minor
from tests.io.synthetic_recordings import motion, read_text, recording, refused, tidy_frame

Change = Callable[[Recording], None]
NAN = np.nan


def vetted(rec: Recording, time_scale: float = 1.0) -> JointLog:
    examined = examine(rec, ReadOptions(time_scale=time_scale))
    return to_joint_log(examined, sha256="0" * 64, format="test")


def finding(log: JointLog, code: str) -> Finding:
    found = [finding for finding in log.source.findings if finding.code == code]
    assert len(found) == 1, f"{code} not once in {[f.code for f in log.source.findings]}"
    return found[0]


def codes(log: JointLog) -> list[str]:
    return [finding.code for finding in log.source.findings]


def put(name: str, where: Any, value: Any) -> Change:
    """Return what writes a value into some rows, or rows and joint, of the time ("t") or of a channel."""

    def change(rec: Recording) -> None:
        array = rec.t if name == "t" else rec.channels.setdefault(name, np.full(rec.channels["q"].shape, 30.0))
        array[where] = value(array) if callable(value) else value

    return change


def times(names: str, factor: float, where: Any = ...) -> Change:
    def change(rec: Recording) -> None:
        for name in names.split():
            (rec.t if name == "t" else rec.channels[name])[where] *= factor

    return change


def changed(*changes: Change, samples: int = 3000, joints: int = 3) -> Recording:
    rec = recording(samples, joints)
    for change in changes:
        change(rec)
    return rec


def taken(rec: Recording, rows: Any) -> Recording:
    channels = {c: np.asfortranarray(a[rows]) for c, a in rec.channels.items()}
    return replace(rec, t=rec.t[rows].copy(), channels=channels)


def without(rec: Recording, rows: list[int]) -> Recording:
    return taken(rec, np.delete(np.arange(len(rec.t)), rows))


def test_a_clean_recording_passes_unchanged() -> None:
    log = vetted(recording())
    assert codes(log) == []
    np.testing.assert_array_equal(log.dq, recording().channels["dq"])
    assert log.q.flags.f_contiguous
    assert log.source.clock_windows > 0


def test_time_starts_at_zero_and_the_start_follows() -> None:
    log = vetted(replace(recording(), t=recording().t + 5.0, start_s=1.7e9))
    assert (log.t[0], log.source.start_s) == (0.0, 1.7e9 + 5.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("t", slice(2000, None), lambda t: t[2000:] - 2.0), "back at 1 of 2999 rows, by up to 1.999 s at row 2001"),
        (times("t", 2.0), r"q is 0\.5 times the integral of dq over time; .*--time-scale 0\.5"),
        (times("dq", 1e3), r"q is 0\.001 times the integral of dq over time; .*dq has another scale or unit"),
        (put("dq", ..., 0.0), r"dq .* is 0 in all 3000 rows while q moves by 1"),
        (times("t", 2e-5), r"advances by 2e-08 s a row; expected 5e-07 to 100 s; .*--time-scale"),
        (times("t", 2e8), r"advances by 2e\+05 s a row; expected"),
        (put("t", slice(1, None), NAN), r"1 sample; .*2999 of 3000 rows hold NaN"),
    ],
)
def test_recordings_that_cannot_be_used_are_refused(change: Change, words: str) -> None:
    refused(words, vetted, changed(change))


@pytest.mark.parametrize(
    ("change", "code", "joint", "amount"),
    [
        (put("tau_J_d", ..., NAN), "empty_channel", None, 3000),
        (put("temperature", slice(1, None, 2), NAN), "sparse_channel", None, 1500),
        (put("tau_J", (..., 1), NAN), "empty_joint", None, 3000),
        (put("q", (10, 0), 1e300), "non_finite", None, 1),
        *((put("t", row, -1.7e9), "non_finite", None, 1) for row in (0, 50, 2999)),  # 0 where others are of an epoch
        (put("t", 50, lambda t: t[49]), "duplicate_stamps", None, 1),
        (put("dq", (..., 1), 0.0), "velocity_dead", 2, None),
        (put("tau_J", (..., 2), lambda a: 1500.0 * np.sign(a[:, 2])), "torque_unit_suspected", 3, 1500),
        (times("dq", 1.6, (..., 2)), "velocity_scale", 3, 1 / 1.6),
        (times("dq", 30.0 / np.pi), "velocity_unit", None, 30.0 / np.pi),
        (times("t", 1e-3), "time_unit", None, 1e3),
        (times("t", 1e3), "time_unit", None, 1e-3),
        *((times("t", stretch), "clock_stretched", None, 1.0 / stretch) for stretch in (0.8, 0.96, 1.04, 1.3)),
        (times("q", -1.0, (..., 2)), "position_mismatch", 3, None),
        (put("q", (..., 1), 0.5 * np.sin(np.arange(3000) * 1.3e-3)), "position_mismatch", 2, None),
    ],
)
def test_a_fault_is_named_with_its_amount(change: Change, code: str, joint: int | None, amount: float | None) -> None:
    log = vetted(changed(change))
    noticed = finding(log, code)
    marked = code in ("torque_unit_suspected", "velocity_scale", "clock_stretched", "position_mismatch")  # its row
    assert (noticed.joint, code in minor(log), code not in NO_PHYSICS) == (joint, code == "duplicate_stamps", marked)
    assert amount is None or noticed.amount == pytest.approx(amount, rel=2e-3)


def test_what_is_left_out_and_what_is_kept() -> None:
    log = vetted(changed(put("tau_J_d", ..., NAN), put("temperature", slice(1, None, 2), NAN)))
    assert (log.tau_J_d, log.temperature, len(log.t)) == (None, None, 3000)
    log = vetted(changed(put("tau_J", (..., 1), NAN), put("gravity", (..., 2), NAN)))
    assert log.joint_names == ("panda_joint1", "panda_joint3")
    assert finding(log, "empty_joint").message.endswith("joints are numbered without it (2 is panda_joint3)")
    assert finding(log, "sparse_channel").message.startswith("gravity (gravity) of panda_joint3 lacks 3000 of 3000")
    log = vetted(changed(put("q", (10, 0), NAN), put("tau_J", (20, 2), np.inf), put("t", 30, NAN)))
    assert (finding(log, "non_finite").amount, finding(log, "non_finite").damaged, len(log.t)) == (3, True, 2997)
    assert "(q (q) of panda_joint1, tau_J (tau_J) of panda_joint3)" in finding(log, "non_finite").message
    log = vetted(changed(put("t", 50, lambda t: t[49])))
    np.testing.assert_array_equal(log.q, np.delete(recording().channels["q"], 50, axis=0))
    log = vetted(changed(put("tau_J", (..., 2), lambda a: 1500.0 * np.sign(a[:, 2]))))
    assert log.tau_J is not None
    assert np.abs(log.tau_J[:, 2]).max() == 1500.0


def test_rows_out_of_order_are_sorted() -> None:
    order = np.arange(3000)
    order[[100, 101]] = [101, 100]
    log = vetted(taken(recording(), order))
    assert finding(log, "unordered").amount == 1
    np.testing.assert_array_equal(log.q, recording().channels["q"])


def repeated(names: str, rows: Any, row: int) -> list[Change]:
    return [put(name, rows, lambda a: a[row].copy()) for name in names.split()]


def test_stale_samples_are_dropped_while_the_arm_moves() -> None:
    log = vetted(changed(*repeated("q dq tau_J", slice(101, 104), 100)))
    noticed = finding(log, "stale_samples")
    assert (noticed.amount, len(log.t)) == (3, 2997)
    assert "0.1%" in noticed.message
    at_rest = changed(*repeated("q tau_J", slice(2000, None), 2000), put("dq", slice(2000, None), 0.0))
    for fresh in (at_rest, changed(*repeated("q dq", 101, 100))):
        assert "stale_samples" not in codes(vetted(fresh))


@pytest.mark.parametrize("name", ["tau_J", "q", "dq"])
def test_held_values_of_a_slower_topic_are_interpolated(name: str) -> None:
    """A torque held for 10 ms made viscous friction 20 to 80 % wrong without a word."""
    rec, true = recording(8000, 3), recording(8000, 3).channels[name]
    log = vetted(replace(rec, channels=rec.channels | {name: np.asfortranarray(true[np.arange(8000) // 10 * 10])}))
    assert finding(log, "held_values").amount == pytest.approx(0.01, rel=1e-6)
    assert "late on average" in finding(log, "held_values").message
    off = np.abs(getattr(log, name) - true)[:7990]  # large only where Coulomb friction steps
    assert np.median(off) < 0.1 * np.median(np.abs(true[10:] - true[:-10]))


def test_coarse_encoders_and_torques_are_not_held() -> None:
    rec = recording(8000, 3)
    noisy = rec.channels["tau_J"] + 0.05 * np.random.default_rng(0).standard_normal((8000, 3))
    coarse = {"q": np.round(rec.channels["q"] / 5e-3) * 5e-3, "tau_J": np.round(noisy / 0.1) * 0.1}
    held = {"tau_J": coarse["tau_J"][np.arange(8000) // 5 * 5]}  # most updates change by one step or by none
    found = [codes(vetted(replace(rec, channels=rec.channels | one))) for one in (coarse, held)]
    assert ["held_values" in one for one in found] == [False, True]


def test_a_velocity_that_is_mostly_noise_is_named_with_the_way_out() -> None:
    rec = recording(8000, 3)
    assert "velocity_noisy" not in codes(vetted(rec))
    dq = rec.channels["dq"] + 0.0
    dq[:, 1] += np.sqrt(0.2) * np.sqrt(np.mean(dq[:, 1] ** 2)) * np.random.default_rng(0).standard_normal(8000)
    noticed = finding(vetted(replace(rec, channels=rec.channels | {"dq": dq})), "velocity_noisy")
    assert [noticed.joint, noticed.amount] == pytest.approx([2, 0.2 / 1.2], rel=0.1)
    assert "--map dq=derivative" in noticed.message


def test_dropped_samples_and_gaps_are_counted_and_are_no_jitter() -> None:
    log = vetted(without(recording(), [100, 500, 501, 502]))
    assert finding(log, "dropped_samples").amount == 4
    assert "gap" not in codes(log)
    log = vetted(without(recording(), [*range(1000, 1200), *range(2000, 2100)]))
    assert finding(log, "gap").amount == 2
    assert "longest 0.201 s" in finding(log, "gap").message
    assert "jitter" not in codes(log)


def jittered(rec: Recording, seed: int) -> Recording:
    return replace(rec, t=rec.t + np.random.default_rng(seed).uniform(-0.3e-3, 0.3e-3, len(rec.t)))


def test_jitter_is_measured() -> None:
    amount = finding(vetted(jittered(recording(20_000), 1)), "jitter").amount
    assert amount is not None
    # The difference of two uniform errors of half width a has the variance 2 a^2/3; long steps count as holes.
    assert 0.15e-3 < amount <= 0.3e-3 * np.sqrt(2 / 3) * 1.02


def test_a_low_rate_is_named() -> None:
    assert finding(vetted(recording(900, rate_hz=30.0)), "low_rate").amount == pytest.approx(30.0)


@pytest.mark.parametrize("size", [2, 3, 4, 50])
def test_samples_of_a_batch_are_put_a_period_apart(size: int) -> None:
    even, place = recording(6000).t, np.arange(6000) % size
    log = vetted(replace(recording(6000), t=even[np.arange(6000) - place + size - 1] - 1e-5 * (size - 1 - place)))
    assert finding(log, "batched_stamps").amount == 6000 / size
    np.testing.assert_allclose(log.t, even - even[0], atol=1e-9)
    assert "dropped_samples" not in codes(log)


def test_stamps_of_a_coarse_clock_are_spread_and_copies_of_rows_are_not() -> None:
    """A clock of 100 Hz on a log of 1 kHz: no row is lost; rows that were written ten times are."""
    rec = recording(6000)
    coarse = np.round(rec.t - 0.0045, 2)
    log = vetted(replace(recording(6000), t=coarse))
    assert finding(log, "batched_stamps").amount == 600
    np.testing.assert_allclose(log.t, rec.t - rec.t[0], atol=1e-9)
    copies = {name: array[np.arange(6000) // 10 * 10] for name, array in rec.channels.items()}
    assert finding(vetted(replace(rec, t=coarse, channels=copies)), "duplicate_stamps").amount == 5400


def test_batches_of_a_long_log_are_seen_in_any_phase() -> None:
    """More samples than the rate is taken from; the first pair is half a pair."""
    rec = recording(140_001, joints=1)
    log = vetted(replace(rec, t=rec.t + np.where(np.arange(140_001) % 2 == 1, 9e-4, 0.0)))
    assert finding(log, "batched_stamps").amount == 70_001
    assert np.diff(log.t) == pytest.approx(1e-3)


def test_a_backlog_is_spread_over_the_time_since_the_last_batch() -> None:
    """Eight samples come with a batch of four's time: half a period apart, still in order."""
    t = np.repeat(np.arange(1, 1001) * 4e-3, 4) - np.tile([3e-4, 2e-4, 1e-4, 0.0], 1000)
    t[2000:2008] = t[2007] - np.arange(7, -1, -1) * 1e-5
    assert np.diff(vetted(replace(recording(4000), t=np.sort(t))).t).min() > 0.4e-3


def test_jitter_and_single_holes_are_no_batches() -> None:
    holes = [*range(1000, 1200), *range(5000, 20_000, 50)]
    assert "batched_stamps" not in codes(vetted(jittered(without(recording(20_000), holes), 3)))


@pytest.mark.parametrize(
    ("turned", "factor", "named"),
    [
        *((turned, 180.0 / np.pi, ["degrees"] * len(turned.split())) for turned in ("q", "dq", "q dq")),
        ("dq", 30.0 / np.pi, ["velocity_unit"]),  # revolutions per minute
        ("dq", 0.5 / np.pi, ["velocity_unit"]),  # per second
        ("q", 0.5 / np.pi, ["position_unit"]),
    ],
)
def test_other_units_are_turned_into_radians(turned: str, factor: float, named: list[str]) -> None:
    log = vetted(changed(times(turned, factor)))
    assert codes(log) == named
    np.testing.assert_allclose(log.q, recording().channels["q"], atol=1e-12)
    np.testing.assert_allclose(log.dq, recording().channels["dq"], atol=1e-12)


def test_degrees_of_an_arm_at_rest_are_named_without_a_ratio() -> None:
    log = vetted(changed(put("q", ..., 40.0), put("dq", ..., 0.0)))
    assert (
        finding(log, "degrees").message
        == "q is in degrees: it reaches 40, and q hardly moves; it was turned into radians, times 0.01745"
    )


def test_a_rig_that_turns_without_end_is_not_turned_into_radians() -> None:
    rec = recording(joints=1)
    t = rec.t[:, None]
    rec.channels |= {"q": 40.0 * t, "dq": 40.0 + 0.1 * np.sin(3.0 * t)}
    log = vetted(rec)
    assert codes(log) == ["degrees_suspected"]
    assert log.q[-1, 0] == pytest.approx(40.0 * 2.999)


def test_a_rig_that_may_be_in_degrees_is_refused_with_the_way_to_say_it(tmp_path: Path) -> None:
    """58 and 110 to and fro: degrees, or a motor of nine turns."""
    arrays = motion(3000, 1)
    columns = {"t": arrays["t"], "tau_J": arrays["tau_J"][:, 0]}
    columns |= {"q": arrays["q"][:, 0] * 116.0, "dq": arrays["dq"][:, 0] * 116.0}
    frame = pd.DataFrame(columns)
    refused(r"degrees.*--map q=q:deg --map dq=dq:deg", read_text, tmp_path, frame)
    for unit, largest in (("deg", np.deg2rad(58.0)), ("rad", 58.0)):
        log = read_text(tmp_path, frame, mapping={"q": f"q:{unit}", "dq": f"dq:{unit}"})
        assert log.q[:, 0].max() == pytest.approx(largest, rel=1e-3)


@pytest.mark.parametrize(("name", "factor"), [("motor_position", 100.0), ("position", 2000.0)])
def test_a_motor_or_an_encoder_of_an_arm_is_not_taken_for_degrees(tmp_path: Path, name: str, factor: float) -> None:
    frame = tidy_frame(3000).rename(columns=lambda one: one.replace("q_", f"{name}_") if one[0] == "q" else one)
    turned = [column for column in map(str, frame) if column.startswith((name, "dq"))]
    frame[turned] *= factor
    words = r"a motor of many turns; .* divide the columns of a motor by the gear ratio"
    refused(words, read_text, tmp_path, frame)


def test_an_axis_in_millimetres_does_not_turn_the_others_into_radians(tmp_path: Path) -> None:
    frame = tidy_frame(3000)
    frame[["q_3", "dq_3"]] *= 500.0
    refused("leave an axis in mm out", read_text, tmp_path, frame)
    both = {"q": "q_1,q_2", "dq": "dq_1,dq_2", "tau_J": "tau_J_1,tau_J_2"}
    log = read_text(tmp_path, frame, mapping=both)
    np.testing.assert_array_equal(log.q, motion(3000)["q"][:, :2])


@pytest.mark.parametrize(("turn", "low"), [(2.0 * np.pi, 0.2), (360.0, 0.0)])
def test_turns_are_joined(turn: float, low: float) -> None:
    rec, unit = recording(), 2.0 * np.pi / turn
    turned = (rec.channels["q"] + 0.1) / unit
    rec.channels |= {"q": np.mod(turned - low, turn) + low, "dq": rec.channels["dq"] / unit}
    log = vetted(rec)
    assert codes(log)[:3] == ["turns_joined"] * 3
    np.testing.assert_allclose(np.diff(log.q, axis=0), np.diff(motion()["q"], axis=0), atol=1e-9)


@pytest.mark.parametrize("channel", ["q", "dq", "tau_J"])
def test_a_channel_that_keeps_its_value_is_named_with_the_part(channel: str) -> None:
    found = vetted(changed(put(channel, (slice(1200, None), 1), lambda a: a[1200, 1]))).source.findings
    assert (found[0].code, found[0].joint) == ("channel_frozen", 2)
    assert "from about 1.2 to 3 s" in found[0].message


def test_a_jump_of_the_clock_holds_no_value_and_moves_no_joint() -> None:
    jump = put("t", slice(1500, None), lambda t: t[1500:] + 1e6)
    log = vetted(changed(jump, put("dq", (slice(100, 102), 1), 0.4)))
    assert "channel_frozen" not in codes(log)
    assert 1.0 < estimate_log(log, AuditSettings()).friction.joints[0].moving_s < 3.0


def test_two_recordings_in_one_file_are_named_with_the_row(tmp_path: Path) -> None:
    both = pd.concat([tidy_frame(3000)] * 2)
    refused(r"2 recordings in one file: cut it before row 3001", read_text, tmp_path, both)


def test_a_few_wild_torques_are_no_unit() -> None:
    assert "torque_unit_suspected" not in codes(vetted(changed(put("tau_J", (slice(None, None, 100), 0), 9000.0))))


def test_a_stretched_clock_is_kept_and_the_time_scale_corrects_it() -> None:
    assert vetted(changed(times("t", 1.3))).duration_s == pytest.approx(2.999 * 1.3)
    log = vetted(changed(times("t", 2.0)), time_scale=0.5)
    assert codes(log) == []
    assert log.duration_s == pytest.approx(2.999)
    assert vetted(changed(times("t", 1e3))).duration_s == pytest.approx(2.999)


def uneven(rec: Recording) -> Recording:
    """Round the stamps to 2 ms and lose 18 % of the rows."""
    kept = np.flatnonzero(np.random.default_rng(5).uniform(size=len(rec.t)) > 0.18)
    return taken(replace(rec, t=np.round(rec.t / 2e-3) * 2e-3), kept)


def test_a_clock_wrong_by_two_is_seen_on_uneven_stamps() -> None:
    with pytest.raises(InputError, match=r"q is 0\.5 times .*--time-scale 0\.5.*dq has another scale"):
        vetted(uneven(changed(times("t", 2.0), samples=6000)))
    assert vetted(uneven(recording(6000))).source.clock_windows > 20


def test_a_stretched_clock_is_seen_on_a_joint_that_creeps() -> None:
    """3 mrad in half a second at 6 mrad/s."""
    rec = recording(60_000, joints=1)
    t = rec.t[:, None]
    rec.channels |= {"q": 0.03 * np.sin(0.1 * t), "dq": 3e-3 * np.cos(0.1 * t)}
    assert finding(vetted(replace(rec, t=1.25 * rec.t)), "clock_stretched").amount == pytest.approx(0.8, rel=1e-3)


def test_a_clock_that_cannot_be_checked_has_no_windows() -> None:
    assert vetted(changed(put("q", ..., 1.0), put("dq", ..., 0.0))).source.clock_windows == 0


def test_joints_that_stand_still_neither_vote_nor_are_accused() -> None:
    """Four of seven joints stand still with noise and offset of dq and flicker of q; the clock is right, or is not."""

    def standing(rec: Recording) -> None:
        rng = np.random.default_rng(2)
        for joint in (0, 2, 4, 6):
            rec.channels["q"][:, joint] = 6e-3 * rng.integers(0, 2, len(rec.t))
            rec.channels["q"][1000:, joint] += 0.05
            rec.channels["dq"][:, joint] = 0.01 + 4e-3 * rng.standard_normal(len(rec.t))

    assert codes(vetted(changed(standing, samples=6000, joints=7))) == []
    log = vetted(changed(standing, times("t", 1.1), samples=6000, joints=7))
    assert codes(log) == ["clock_stretched"]
    assert finding(log, "clock_stretched").amount == pytest.approx(1 / 1.1, rel=2e-3)


@pytest.mark.parametrize("joints", [2, 7])
def test_a_velocity_of_another_scale_on_one_joint(joints: int) -> None:
    log = vetted(changed(times("dq", 1.6, (..., joints - 1)), joints=joints))
    assert [(one.code, one.joint) for one in log.source.findings] == [("velocity_scale", joints)]


@pytest.mark.parametrize("torque", [0.0, 4.2, np.random.default_rng(1).integers(-3, 4, 3000) * 1e-3])
def test_a_dead_torque_is_named_by_joint(torque: float | Float) -> None:
    log = vetted(changed(put("tau_J", (..., 1), torque)))
    assert codes(log) == ["torque_dead"]
    assert log.source.dead_torque == {2}


def test_a_torque_of_coarse_steps_is_named_with_the_step() -> None:
    log = vetted(changed(put("tau_J", ..., lambda a: np.round(2.0 * a))))
    assert [(one.code, one.amount) for one in log.source.findings] == [("torque_coarse", 1.0)] * 3
    assert codes(vetted(changed(put("tau_J", ..., lambda a: np.round(a, 2))))) == []
    assert codes(vetted(changed(put("tau_J", ..., lambda a: 0.3 * np.sign(a))))) == []


def test_rows_that_repeat_a_slow_state_are_kept_and_make_no_holes() -> None:
    """One motor of a bus of seven, asked in every seventh row of 100 Hz, that pauses between its strokes."""
    t = np.arange(6000) / 100.0
    dq = np.where(t % 20.0 < 14.0, 0.6 * np.cos(1.2 * t), 0.0)
    channels = {"q": np.cumsum(dq) * 0.01, "dq": dq, "tau_interaction": 0.3 * np.sign(dq) + 0.1 * dq}
    held = np.arange(len(t)) // 7 * 7
    rec = Recording(t=t, channels={c: a[held][:, None] for c, a in channels.items()}, joint_names=("joint5",))
    log = vetted(rec)
    assert codes(log) == ["slow_state"]
    assert finding(log, "slow_state").amount == pytest.approx(0.07)
    cycles, *_ = estimate_log(log, AuditSettings()).cycles
    assert len(cycles.reason) > 15
    assert (cycles.reason == 0).mean() > 0.9


@pytest.mark.parametrize("delay", [5, 20])
def test_a_delay_of_the_velocity_is_no_stretched_clock(delay: int) -> None:
    rec = recording()
    late = {c: np.asfortranarray(a[delay:] if c == "q" else a[:-delay]) for c, a in rec.channels.items()}
    assert codes(vetted(replace(rec, t=rec.t[delay:].copy(), channels=late))) == []


@pytest.mark.parametrize("rests", [False, True])
def test_noise_of_a_real_arm_is_no_finding(rests: bool) -> None:
    rng = np.random.default_rng(3)
    rec = recording(joints=7)
    if rests:
        rec.channels["q"][:], rec.channels["dq"][:] = 1.0, 0.0
    rec.channels["q"] += 1e-5 * rng.standard_normal((3000, 7))
    rec.channels["dq"] += (1e-3 if rests else 2e-3) * rng.standard_normal((3000, 7))
    assert codes(vetted(rec)) == []


@settings(max_examples=30, deadline=None)
@given(faults=st.lists(st.tuples(st.sampled_from(["nan", "stamp", "repeat"]), st.integers(1, 299)), max_size=20))
def test_with_any_faults_the_log_keeps_its_promises(faults: list[tuple[str, int]]) -> None:
    rec = recording(300)
    for fault, row in faults:
        if fault == "stamp":
            rec.t[row] = rec.t[row - 1]
        elif fault == "nan":
            rec.channels["dq"][row] = np.nan
        else:
            for array in rec.channels.values():
                array[row] = array[row - 1]
    log = vetted(rec)
    left_out = ("non_finite", "duplicate_stamps", "stale_samples")
    assert len(log.t) + sum(f.amount or 0 for f in log.source.findings if f.code in left_out) == 300
