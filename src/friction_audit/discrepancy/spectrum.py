"""A vibration in what a model leaves: a hump of its spectrum in time, wherever the joint goes and however fast."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.result import Vibration
from friction_audit.joint_log import Float

SEGMENT_S = 5.0
LOWEST_HZ = 0.6
HIGHEST_HZ = 40.0
LEAST_RISE = 3.0
"""By how much a hump must stand above the valley beside it, in power."""
SIGMAS = 6.0
"""Or by so many standard errors of the spectrum's logarithm, where few segments leave it rough."""
LEAST_USED = 0.8
FEWEST_SEGMENTS = 4
SMOOTHED = 3


def find_vibration(residual: Float, data: JointData) -> Vibration | None:
    """Find the strongest hump between 0.6 and 40 Hz.

    The power spectral density is a mean over stretches of five seconds (Welch 1967); the logarithm of a mean of k has a
    standard error of about 1 / sqrt(k).

    Args:
        residual: Measured less simulated torque on the fine grid, shape (n,). [N m]
        data: The joint.

    Returns:
        The hump; None where there is none, or too few whole stretches of motion.
    """
    from scipy.signal import find_peaks

    density, segments = _mean_spectrum(np.where(data.used, residual, 0.0), data.used, data.step_s)
    if segments < FEWEST_SEGMENTS:
        return None
    frequency = np.arange(len(density)) / SEGMENT_S
    level = np.log(np.convolve(density, np.ones(SMOOTHED) / SMOOTHED, mode="same").clip(min=1e-300))
    top = min(HIGHEST_HZ, 0.2 / data.step_s)
    band = np.flatnonzero((frequency >= LOWEST_HZ) & (frequency <= top))
    if not len(band):
        return None
    rise = max(np.log(LEAST_RISE), SIGMAS / np.sqrt(segments * SMOOTHED / 2.0))
    peaks, found = find_peaks(level[band], prominence=rise, width=1, rel_height=0.7)
    if not len(peaks):
        return None
    left, right = (np.rint(found[side]).astype(int) for side in ("left_ips", "right_ips"))
    power = [float(density[band[a] : band[b] + 1].sum() / SEGMENT_S) for a, b in zip(left, right, strict=True)]
    best = int(np.argmax(power))
    return Vibration(
        frequency_hz=float(frequency[band[peaks[best]]]),
        low_hz=float(frequency[band[left[best]]]),
        high_hz=float(frequency[band[right[best]]]),
        rms_nm=float(np.sqrt(power[best])),
    )


def _mean_spectrum(signal: Float, used: NDArray[np.bool_], step_s: float) -> tuple[Float, int]:
    """One-sided density [N m^2/Hz] over half-overlapping stretches in motion, and how many there were."""
    length = round(SEGMENT_S / step_s)
    window = np.hanning(length)
    starts = [a for a in range(0, len(signal) - length + 1, length // 2) if used[a : a + length].mean() >= LEAST_USED]
    if not starts:
        return np.zeros(length // 2 + 1), 0
    parts = np.stack([signal[a : a + length] * window for a in starts])
    power = np.mean(np.abs(np.fft.rfft(parts, axis=1)) ** 2, axis=0)
    return np.asarray(2.0 * power * step_s / np.sum(window**2)), len(starts)
