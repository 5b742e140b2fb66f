"""The filtered curve of a figure: zero-phase, for the eye only; no estimate is made from it."""

import numpy as np

from friction_audit.joint_log import Float

CUTOFF_HZ = 10.0
"""Corner of the low-pass filter of the drawn curves. [Hz]"""
ORDER = 2
SHORTEST = 20
"""Samples below which a filter makes no sense."""


def cutoff_hz(t: Float) -> float:
    """Return the corner in force: CUTOFF_HZ, or less where the log is too slow for it. [Hz]"""
    return min(CUTOFF_HZ, 0.2 * median_rate_hz(t))


def median_rate_hz(t: Float) -> float:
    """Return the sampling rate of stamps, shape (n,). [Hz]"""
    return 1.0 / float(np.median(np.diff(t)))


def smooth(t: Float, signal: Float) -> Float:
    """Return the signal after a zero-phase Butterworth low-pass filter, both of shape (n,)."""
    from scipy.signal import butter, sosfiltfilt

    if len(t) < SHORTEST:
        return signal
    sections = butter(ORDER, cutoff_hz(t), fs=median_rate_hz(t), output="sos")
    return np.asarray(sosfiltfilt(sections, signal, padlen=min(len(t) - 1, 3 * SHORTEST)), dtype=np.float64)
