"""Samples that arrive several at a time: their stamps tell of the network, not of the robot.

A driver that waits for a full packet, or a computer that was busy, hands over several samples at once, a tenth of a
millisecond apart, and then none for a while. The last one of a batch has just been taken; those before it were taken a
period apart. Read as they are, such stamps would pass for a log of ten times the rate with most of it missing.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import with_findings
from friction_audit.joint_log import Finding, Float

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
