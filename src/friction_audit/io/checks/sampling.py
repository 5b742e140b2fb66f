"""Sampling: dropped samples, gaps, jitter and a low rate are noticed, and nothing is changed."""

import numpy as np

from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding

GAP_S = 0.05
DROPPED_STEPS = 1.5
_GAP_STEPS = 5.0
_JITTER_SHARE = 0.1
_LOW_RATE_HZ = 100.0
_TIMER = 0.95  # a timer of 100 Hz is a little off


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
    if rate < _TIMER * _LOW_RATE_HZ:
        text = (
            f"{rate:.3g} Hz is a low sampling rate: reversals and inertial torques are poorly resolved; record at "
            f"{_LOW_RATE_HZ:.0f} Hz or more"
        )
        findings.append(Finding(code="low_rate", message=text, amount=rate))
    return recording.with_findings(*findings)
