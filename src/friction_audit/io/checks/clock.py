"""The clock of a recording: order of the stamps, stamps of batches, steps that are missing or uneven."""

from dataclasses import replace

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, Float

_LONGEST_BACKWARDS_S = 1.0
_MOST_BACKWARDS = 0.01
_SHOWN = 5


def order_clock(recording: Recording, path: str, *, time_scale: float = 1.0) -> Recording:
    """Return the recording with strictly increasing stamps.

    Raises:
        InputError: If time stands still or runs backwards.
    """
    if time_scale != 1.0:
        recording = replace(recording, t=recording.t * time_scale)
    steps = np.diff(recording.t)
    if steps.min() > 0.0:
        return recording
    _refuse_no_clock(recording, steps, path)
    backwards = int(np.count_nonzero(steps < 0.0))
    if backwards:
        text = (
            f"{backwards} rows are older than the row before them ({path} is not in order of time); the rows are sorted"
        )
        finding = Finding(code="unordered", message=text, amount=float(backwards))
        recording = recording.take_rows(np.argsort(recording.t, kind="stable")).with_findings(finding)
    new = np.ones(len(recording.t), dtype=np.bool_)
    np.greater(recording.t[1:], recording.t[:-1], out=new[1:])
    repeats = len(new) - int(np.count_nonzero(new))
    if repeats == 0:
        return recording
    text = (
        f"{repeats} of {len(new)} rows ({repeats / len(new):.1%}) carry the stamp of the row before them; "
        "the first of each stamp is kept"
    )
    finding = Finding(code="duplicate_stamps", message=text, amount=float(repeats))
    return recording.take_rows(new).with_findings(finding)


def _refuse_no_clock(recording: Recording, steps: Float, path: str) -> None:
    name, rows = recording.mapping.get("t", recording.clock), len(recording.t)
    if not steps.any():
        raise InputError(
            f"{path}: time ({name}) is the same in all {rows} rows; expected strictly increasing stamps; "
            "name another clock with --map t=<column>, or another topic"
        )
    backwards = int(np.count_nonzero(steps < 0.0))
    late_s = np.maximum.accumulate(recording.t) - recording.t
    worst = int(late_s.argmax())
    is_few = backwards <= max(_MOST_BACKWARDS * len(steps), 1.0)
    if late_s[worst] <= _LONGEST_BACKWARDS_S and is_few:
        return
    advice = "bring the rows into order"
    if is_few:
        starts = ", ".join(map(str, (np.flatnonzero(steps < 0.0) + 2)[:_SHOWN]))
        advice = (
            f"these look like {backwards + 1} recordings in one file: cut it before row {starts}"
            f"{'...' if backwards > _SHOWN else ''} and read each part"
        )
    raise InputError(
        f"{path}: time ({name}) goes back at {backwards} of {len(steps)} rows, by up to {late_s[worst]:.4g} s "
        f"at row {worst + 1}; expected increasing stamps; {advice}, or name another clock with --map t=<column>"
    )


_SHORT = 0.5  # steps below so much of a period lie within a batch
_LEAST_SHARE = 0.25  # of short steps, from which on stamps are those of batches: half in pairs, more in longer ones
_LONGEST_BATCH = 64  # samples over which the rate is even again; longer batches are not seen
_MOST_PLACES = 1 << 16


def spread_batches(recording: Recording) -> Recording:
    """Return the recording with the samples of each batch a period apart, the last one where it is."""
    t = recording.t
    # The rough period is the median of mean steps over more than a batch: holes do not count.
    reach, every = min(_LONGEST_BATCH, len(t) - 1), max(len(t) // _MOST_PLACES, 1)
    rough = float(np.median(t[reach::every] - t[:-reach:every])) / reach
    # Every step counts: of every second one, a log that comes in pairs would show only short ones or only long ones.
    short = np.diff(t) < _SHORT * rough
    if np.mean(short) < _LEAST_SHARE:
        return recording
    ends = np.append(np.flatnonzero(~short), len(t) - 1)
    # Mean steps over whole batches: a part of one would make the period too short or too long.
    reach = min(max(round(_LONGEST_BATCH * len(ends) / len(t)), 1), len(ends) - 1)
    period = float(np.median((t[ends[reach:]] - t[ends[:-reach]]) / (ends[reach:] - ends[:-reach])))
    size = np.diff(ends, prepend=-1)
    since = np.diff(t[ends], prepend=t[ends[0]] - size[0] * period)
    # A backlog may hold more samples than there was time for since the last batch: these share that time.
    apart = np.minimum(period, since / size)
    before = np.repeat(ends, size) - np.arange(len(t))
    message = (
        f"samples arrive in {len(ends)} batches of {len(t) / len(ends):.1f} on average and carry times of arrival; "
        f"those of a batch are put {1e3 * period:.3g} ms apart; record the sensor's own stamps if there are any"
    )
    finding = Finding(code="batched_stamps", message=message, amount=float(len(ends)))
    return replace(recording, t=np.repeat(t[ends], size) - before * np.repeat(apart, size)).with_findings(finding)


GAP_S = 0.05
DROPPED_STEPS = 1.5
_GAP_STEPS = 5.0
_JITTER_SHARE = 0.1
_LOW_RATE_HZ = 100.0


def gap_threshold_s(median_step_s: float) -> float:
    """Return the step from which on a gap in the recording is reported on its own. [s]"""
    return max(_GAP_STEPS * median_step_s, GAP_S)


def check_sampling(recording: Recording) -> Recording:
    """Notice dropped samples, gaps, jitter and a low rate."""
    steps = np.diff(recording.t)
    median = float(np.median(steps))
    long = steps[steps > DROPPED_STEPS * median]
    findings = []
    if len(long):
        dropped = float(np.maximum(np.round(long / median) - 1.0, 1.0).sum())
        text = f"{dropped:.0f} samples dropped at {len(long)} places (median step {median * 1e3:.3g} ms)"
        findings.append(Finding(code="dropped_samples", message=text, amount=dropped))
    threshold_s = gap_threshold_s(median)
    gaps = long[long > threshold_s]
    if len(gaps):
        text = f"{len(gaps)} gaps longer than {threshold_s:.3g} s, the longest {gaps.max():.3g} s"
        findings.append(Finding(code="gap", message=text, amount=float(len(gaps))))
    # The spread of the steps that are no gaps, by sums around the median instead of a masked copy of the steps.
    off, off_long, count = steps - median, long - median, len(steps) - len(long)
    mean = (off.sum() - off_long.sum()) / count
    deviation = float(np.sqrt(max((np.dot(off, off) - np.dot(off_long, off_long)) / count - mean**2, 0.0)))
    if deviation > _JITTER_SHARE * median:
        text = (
            f"time step: standard deviation {deviation * 1e3:.3g} ms, median {median * 1e3:.3g} ms (without gaps); "
            "integrals use the logged time stamps"
        )
        findings.append(Finding(code="jitter", message=text, amount=deviation))
    rate = 1.0 / median
    if rate < _LOW_RATE_HZ:
        text = (
            f"{rate:.3g} Hz is a low sampling rate: reversals and inertial torques are poorly resolved; record at "
            f"{_LOW_RATE_HZ:.0f} Hz or more"
        )
        findings.append(Finding(code="low_rate", message=text, amount=rate))
    return recording.with_findings(*findings)
