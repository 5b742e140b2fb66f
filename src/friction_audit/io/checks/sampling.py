"""Sampling: dropped samples, gaps, jitter and a low rate are noticed, and nothing is changed."""

from collections.abc import Iterator

import numpy as np

from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, Float

GAP_S = 0.05
DROPPED_STEPS = 1.5
_GAP_STEPS = 5.0
_JITTER_SHARE = 0.1
_LOW_RATE_HZ = 100.0


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
            places = f"{self.long} places (median step {median * 1e3:.3g} ms)"
            text = f"{self.dropped:.0f} samples dropped at {places}"
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
        if rate < _LOW_RATE_HZ:
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
