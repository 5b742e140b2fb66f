"""Some rows or joints of a recording, column by column: no second copy of the whole is made."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.reader import Recording
from friction_audit.joint_log import Finding, Float


def take_rows(recording: Recording, rows: NDArray[Any]) -> Recording:
    """Return the rows of a mask or in an order; works in place, one column at a time."""
    count = int(np.count_nonzero(rows)) if rows.dtype == np.bool_ else len(rows)
    for array in recording.channels.values():
        for column in array.T:
            column[:count] = column[rows]
    kept = {channel: array[:count] for channel, array in recording.channels.items()}
    return replace(recording, t=recording.t[rows], channels=kept)


def take_joints(recording: Recording, joints: Sequence[int]) -> Recording:
    """Return some joints only, given by column."""
    kept = {channel: np.asfortranarray(array[:, list(joints)]) for channel, array in recording.channels.items()}
    return replace(recording, channels=kept, joint_names=tuple(recording.joint_names[joint] for joint in joints))


def without_channels(recording: Recording, channels: Sequence[str]) -> Recording:
    """Return the recording without some channels."""
    return replace(
        recording,
        channels={channel: array for channel, array in recording.channels.items() if channel not in channels},
        mapping={channel: name for channel, name in recording.mapping.items() if channel not in channels},
    )


def with_findings(recording: Recording, *findings: Finding | None) -> Recording:
    """Return the recording with what was noticed added."""
    noticed = tuple(finding for finding in findings if finding is not None)
    return replace(recording, findings=(*recording.findings, *noticed)) if noticed else recording


SHORT = 0.5
"""Steps below so much of a period lie within a batch."""
LEAST_SHARE = 0.25
"""Share of short steps from which on stamps are those of batches: half in pairs, more in longer ones."""
LONGEST_BATCH = 64
"""Samples over which the rate is even again; of longer batches nothing is seen."""
_MOST_PLACES = 1 << 16


def spread_batches(recording: Recording) -> Recording:
    """Return the recording with the samples of each batch a period apart, the last one where it is.

    Args:
        recording: With strictly increasing stamps.
    """
    t = recording.t
    # Every step counts: of every second one, a log that comes in pairs would show only short ones or only long ones.
    short = np.diff(t) < SHORT * _rough_period(t)
    if np.mean(short) < LEAST_SHARE:
        return recording
    ends = np.append(np.flatnonzero(~short), len(t) - 1)
    period = _period(t, ends)
    message = (
        f"samples arrive in {len(ends)} batches of {len(t) / len(ends):.1f} on average and carry times of arrival; "
        f"those of a batch are put {1e3 * period:.3g} ms apart; record the sensor's own stamps if there are any"
    )
    finding = Finding(code="batched_stamps", message=message, amount=float(len(ends)))
    return with_findings(replace(recording, t=_spread(t, ends, period)), finding)


def _rough_period(t: Float) -> float:
    """Median of the mean steps over more than a batch: holes do not count. [s]"""
    reach = min(LONGEST_BATCH, len(t) - 1)
    # Of very many, some that are spread evenly do.
    every = max(len(t) // _MOST_PLACES, 1)
    return float(np.median(t[reach::every] - t[:-reach:every])) / reach


def _period(t: Float, ends: NDArray[np.intp]) -> float:
    """Median of the mean steps over whole batches: a part of one would make the period too short or too long. [s]"""
    reach = min(max(round(LONGEST_BATCH * len(ends) / len(t)), 1), len(ends) - 1)
    return float(np.median((t[ends[reach:]] - t[ends[:-reach]]) / (ends[reach:] - ends[:-reach])))


def _spread(t: Float, ends: NDArray[np.intp], period: float) -> Float:
    """Return the stamps of samples whose batches end where told."""
    size = np.diff(ends, prepend=-1)
    since = np.diff(t[ends], prepend=t[ends[0]] - size[0] * period)
    # A backlog may hold more samples than there was time for since the last batch: these share that time.
    apart = np.minimum(period, since / size)
    before = np.repeat(ends, size) - np.arange(len(t))
    spread: Float = np.repeat(t[ends], size) - before * np.repeat(apart, size)
    return spread


DROPPED_STEPS = 1.5
GAP_STEPS = 5.0
GAP_S = 0.05
JITTER_SHARE = 0.1
LOW_RATE_HZ = 100.0


def check_sampling(recording: Recording) -> Recording:
    """Notice dropped samples, gaps, jitter and a low rate; nothing is changed."""
    steps = np.diff(recording.t)
    median = float(np.median(steps))
    long = steps[steps > DROPPED_STEPS * median]
    return with_findings(
        recording, _dropped(long, median), _gaps(long, median), _jitter(steps, long, median), _low_rate(median)
    )


def gap_threshold_s(median_step_s: float) -> float:
    """Return the step from which on a hole in the recording is called a gap. [s]"""
    return max(GAP_STEPS * median_step_s, GAP_S)


def _dropped(long: Float, median: float) -> Finding | None:
    if len(long) == 0:
        return None
    dropped = float(np.maximum(np.round(long / median) - 1.0, 1.0).sum())
    message = (
        f"{dropped:.0f} samples are missing in {len(long)} holes, counted in median steps of {median * 1e3:.3g} ms"
    )
    return Finding(code="dropped_samples", message=message, amount=dropped)


def _gaps(long: Float, median: float) -> Finding | None:
    gaps = long[long > gap_threshold_s(median)]
    if len(gaps) == 0:
        return None
    message = f"{len(gaps)} gaps longer than {gap_threshold_s(median):.3g} s, the longest {gaps.max():.3g} s"
    return Finding(code="gap", message=message, amount=float(len(gaps)))


def _jitter(steps: Float, long: Float, median: float) -> Finding | None:
    """Take the spread of the steps that are no holes: one gap is no jitter."""
    count = len(steps) - len(long)
    # Sums around the median instead of a masked copy of the steps.
    off, off_long = steps - median, long - median
    mean = (off.sum() - off_long.sum()) / count
    variance = max((np.dot(off, off) - np.dot(off_long, off_long)) / count - mean**2, 0.0)
    deviation = float(np.sqrt(variance))
    if deviation <= JITTER_SHARE * median:
        return None
    message = (
        f"the time step has a standard deviation of {deviation * 1e3:.3g} ms around a median of {median * 1e3:.3g} ms "
        "(holes left aside); integrals use the stamps as they are"
    )
    return Finding(code="jitter", message=message, amount=deviation)


def _low_rate(median: float) -> Finding | None:
    rate = 1.0 / median
    if rate >= LOW_RATE_HZ:
        return None
    message = (
        f"{rate:.3g} Hz is a low rate: reversals and inertial torque are poorly sampled, and with them the start and "
        f"stop of every cycle; {LOW_RATE_HZ:.0f} Hz or more is better, 1000 Hz best"
    )
    return Finding(code="low_rate", message=message, amount=rate)
