"""Stamps of batches: samples that were sent together carry the time of arrival of their batch."""

from dataclasses import replace

import numpy as np

from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding

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
