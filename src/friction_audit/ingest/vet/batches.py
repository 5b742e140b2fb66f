"""Samples that arrive several at a time: their stamps tell of the network, not of the robot.

A driver that waits for a full packet, or a computer that was busy, hands over several samples at once, a tenth of a
millisecond apart, and then none for a while. The last one of a batch has just been taken; those before it were taken a
period apart. Read as they are, such stamps would pass for a log of ten times the rate with most of it missing.
"""

from dataclasses import replace

import numpy as np

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import with_findings
from friction_audit.joint_log import Finding, Float

SHORT = 0.5
"""Steps below so much of a period lie within a batch."""
LEAST_SHARE = 0.25
"""Share of short steps from which on stamps are those of batches: half in pairs, more in longer ones."""
LONGEST_BATCH = 64
_MOST_PLACES = 1 << 16


def spread_batches(recording: Recording) -> Recording:
    """Return the recording with the samples of each batch a period apart, the last one where it is.

    Args:
        recording: With strictly increasing stamps.
    """
    t = recording.t
    period = _period(t)
    short = _some(np.diff(t)) < SHORT * period
    if np.mean(short) < LEAST_SHARE:
        return recording
    spread, batches = _spread(t, period)
    message = (
        f"samples arrive in {batches} batches of {len(t) / batches:.1f} on average and carry times of arrival; "
        f"those of a batch are put {1e3 * period:.3g} ms apart; record the sensor's own stamps if there are any"
    )
    return with_findings(replace(recording, t=spread), Finding(code="batched_stamps", message=message, amount=batches))


def _period(t: Float) -> float:
    """Median of the mean steps over more than a batch: holes do not count. [s]"""
    reach = min(LONGEST_BATCH, len(t) - 1)
    return float(np.median(_some(t[reach:] - t[:-reach]))) / reach


def _some(values: Float) -> Float:
    """Values spread evenly over all, where there are very many."""
    return values[:: max(len(values) // _MOST_PLACES, 1)]


def _spread(t: Float, period: float) -> tuple[Float, int]:
    """Return the stamps, and how many batches there are."""
    ends = np.append(np.flatnonzero(np.diff(t) >= SHORT * period), len(t) - 1)
    size = np.diff(ends, prepend=-1)
    since = np.diff(t[ends], prepend=t[ends[0]] - size[0] * period)
    # A backlog may hold more samples than there was time for since the last batch: these share that time.
    apart = np.minimum(period, since / size)
    before = np.repeat(ends, size) - np.arange(len(t))
    return np.repeat(t[ends], size) - before * np.repeat(apart, size), len(ends)
