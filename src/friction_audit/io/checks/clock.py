"""The clock of a recording: order of the stamps, stamps of batches, steps that are missing or uneven."""

from collections.abc import Iterator
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


SHORT = 0.5  # steps below so much of a period lie within a batch
LEAST_SHARE = 0.25  # of short steps, from which on stamps are those of batches: half in pairs, more in longer ones
_LONGEST_BATCH = 64  # samples over which the rate is even again; longer batches are not seen
_MOST_PLACES = 1 << 16


def places_of_batches(samples: int) -> tuple[int, int]:
    """Return over how many samples the rough period is taken, and of how many places one is."""
    return min(_LONGEST_BATCH, samples - 1), max(samples // _MOST_PLACES, 1)


def spread_batches(recording: Recording) -> Recording:
    """Return the recording with the samples of each batch a period apart, the last one where it is."""
    t = recording.t
    # The rough period is the median of mean steps over more than a batch: holes do not count.
    reach, every = places_of_batches(len(t))
    rough = float(np.median(t[reach::every] - t[:-reach:every])) / reach
    # Every step counts: of every second one, a log that comes in pairs would show only short ones or only long ones.
    short = np.diff(t) < SHORT * rough
    if np.mean(short) < LEAST_SHARE:
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
_TIMER = 0.95  # a timer of 100 Hz is a little off


def gap_threshold_s(median_step_s: float) -> float:
    """Return the step from which on a gap in the recording is reported on its own. [s]"""
    return max(_GAP_STEPS * median_step_s, GAP_S)


class StepSums:
    """Sums over the steps of a clock, of which a long log gives one block after the other."""

    def __init__(self, median: float) -> None:
        """Take the median step. [s]"""
        self.median, self.threshold_s = median, gap_threshold_s(median)
        self.count, self.long, self.dropped, self.gaps, self.longest = 0, 0, 0.0, 0, 0.0
        self.off, self.square = 0.0, 0.0  # of the steps that are not long, less the median

    def take(self, steps: Float) -> None:
        """Add the steps of a block. [s]"""
        long = steps[steps > DROPPED_STEPS * self.median]
        gaps = long[long > self.threshold_s]
        # By sums around the median instead of a masked copy of the steps.
        off, off_long = steps - self.median, long - self.median
        self.count, self.long, self.gaps = self.count + len(steps), self.long + len(long), self.gaps + len(gaps)
        self.dropped += float(np.maximum(np.round(long / self.median) - 1.0, 1.0).sum())
        self.longest = max(self.longest, float(gaps.max(initial=0.0)))
        self.off += float(off.sum() - off_long.sum())
        # No product of BLAS, whose threads would wait for each other.
        self.square += float(np.einsum("i,i", off, off) - np.einsum("i,i", off_long, off_long))

    def findings(self) -> Iterator[Finding]:
        """Yield what is to be noticed."""
        median = self.median
        if self.long:
            step = f"median step {median * 1e3:.3g} ms"
            text = f"{self.dropped:.0f} samples dropped at {self.long} places ({step})"
            yield Finding(code="dropped_samples", message=text, amount=self.dropped)
        if self.gaps:
            text = f"{self.gaps} gaps longer than {self.threshold_s:.3g} s, the longest {self.longest:.3g} s"
            yield Finding(code="gap", message=text, amount=float(self.gaps))
        even = self.count - self.long
        deviation = float(np.sqrt(max(self.square / even - (self.off / even) ** 2, 0.0)))
        if deviation > _JITTER_SHARE * median:
            text = (
                f"time step: standard deviation {deviation * 1e3:.3g} ms, median {median * 1e3:.3g} ms (without gaps); "
                "integrals use the logged time stamps"
            )
            yield Finding(code="jitter", message=text, amount=deviation)
        rate = 1.0 / median
        if rate < _TIMER * _LOW_RATE_HZ:
            text = (
                f"{rate:.3g} Hz is a low sampling rate: reversals and inertial torques are poorly resolved; record at "
                f"{_LOW_RATE_HZ:.0f} Hz or more"
            )
            yield Finding(code="low_rate", message=text, amount=rate)


def check_sampling(recording: Recording) -> Recording:
    """Notice dropped samples, gaps, jitter and a low rate."""
    steps = np.diff(recording.t)
    sums = StepSums(float(np.median(steps)))
    sums.take(steps)
    return recording.with_findings(*sums.findings())
