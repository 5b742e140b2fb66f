"""How evenly the recording was sampled: dropped samples, gaps, jitter, rate."""

import numpy as np

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import with_findings
from friction_audit.joint_log import Finding, Float

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
