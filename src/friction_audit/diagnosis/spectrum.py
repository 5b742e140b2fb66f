"""A vibration in what a model leaves: a hump of its spectrum in time, wherever the joint goes and however fast."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.result import Vibration
from friction_audit.effects.joint_data import JointData
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
COHERENT = 5
"""Frequencies beside each other, a fifth of a hertz each, over which the share of the motion is averaged."""
LEAST_SHARE = 0.5
"""Of what the model gives the motion: less is not taken for a motion of the joint."""
MOTION_SHARES = (0.5, 1.5)
"""Of a hump, what it has in common with the motion's torque, if it is a motion that noise of the encoder hides."""
SURE = 3.0
"""Standard errors by which it must be more than nothing."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Spectra:
    """One-sided densities of f frequencies, means over stretches, shape (f,) each. [N m^2/Hz]

    Attributes:
        segments: How many stretches.
        left: Of what is left beside the motion.
        torque: Of the residual.
        motion: Of what the model gives the motion.
        common: Real part of the cross density of the two.
    """

    segments: int
    left: Float
    torque: Float
    motion: Float
    common: Float

    def moves(self, band: slice) -> bool:
        """Whether what shakes there is a motion, though it may drown in the encoder's noise.

        That noise is not in the torque, so that the two have the power of the motion in common: all that a trembling
        hand adds to the torque, nothing of a hum, and more than there is where a gear shakes below the encoder.
        """
        common, torque, motion = (float(of[band].mean()) for of in (self.common, self.torque, self.motion))
        error = np.sqrt(torque * motion / (self.segments * (band.stop - band.start)))
        return common > SURE * error and MOTION_SHARES[0] * torque <= common <= MOTION_SHARES[1] * torque


def find_vibration(residual: Float, data: JointData, motion: Float | None = None) -> Vibration | None:
    """Find the strongest hump between 0.6 and 40 Hz.

    The power spectral density is a mean over stretches of five seconds (Welch 1967); the logarithm of a mean of k has a
    standard error of about 1 / sqrt(k).

    Args:
        residual: Measured less simulated torque on the fine grid, shape (n,). [N m]
        data: The joint.
        motion: Torque that the model gives the motion and that was not taken off the residual, for it may be noise of
            the encoder: what the residual is coherent with is taken off, shape (n,); None for no such torque. [N m]

    Returns:
        The hump; None where there is none, or too few whole stretches of motion.
    """
    from scipy.signal import find_peaks

    spectra = _mean_spectra(residual, data, np.zeros_like(residual) if motion is None else motion)
    if spectra is None or spectra.segments < FEWEST_SEGMENTS:
        return None
    density = spectra.left
    frequency = np.arange(len(density)) / SEGMENT_S
    level = np.log(np.convolve(density, np.ones(SMOOTHED) / SMOOTHED, mode="same").clip(min=1e-300))
    top = min(HIGHEST_HZ, 0.2 / data.step_s)
    band = np.flatnonzero((frequency >= LOWEST_HZ) & (frequency <= top))
    if not len(band):
        return None
    rise = max(np.log(LEAST_RISE), SIGMAS / np.sqrt(spectra.segments * SMOOTHED / 2.0))
    peaks, found = find_peaks(level[band], prominence=rise, width=1, rel_height=0.7)
    left, right = (np.rint(found[side]).astype(int) for side in ("left_ips", "right_ips"))
    still = [not spectra.moves(slice(band[a], band[b] + 1)) for a, b in zip(left, right, strict=True)]
    peaks, left, right = (of[np.asarray(still, bool)] for of in (peaks, left, right))
    if not len(peaks):
        return None
    power = [float(density[band[a] : band[b] + 1].sum() / SEGMENT_S) for a, b in zip(left, right, strict=True)]
    best = int(np.argmax(power))
    return Vibration(
        frequency_hz=float(frequency[band[peaks[best]]]),
        low_hz=float(frequency[band[left[best]]]),
        high_hz=float(frequency[band[right[best]]]),
        rms_nm=float(np.sqrt(power[best])),
    )


def _mean_spectra(residual: Float, data: JointData, motion: Float) -> _Spectra | None:
    """Over half-overlapping stretches in motion; None where there is none."""
    length = round(SEGMENT_S / data.step_s)
    window = np.hanning(length)
    used = data.used
    starts = [a for a in range(0, len(used) - length + 1, length // 2) if used[a : a + length].mean() >= LEAST_USED]
    if not starts:
        return None

    def transformed(signal: Float) -> NDArray[np.complex128]:
        masked = np.where(used, signal, 0.0)
        return np.asarray(np.fft.rfft(np.stack([masked[a : a + length] * window for a in starts]), axis=1))

    def density(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> Float:
        return np.asarray(2.0 * data.step_s / np.sum(window**2) * np.mean(np.real(one * np.conj(other)), axis=0))

    torque, moved = transformed(residual), transformed(motion)
    common, own = density(torque, moved), density(moved, moved)
    left = torque - _share(common, own) * moved
    return _Spectra(
        segments=len(starts), left=density(left, left), torque=density(torque, torque), motion=own, common=common
    )


def _share(common: Float, motion: Float) -> Float:
    """Share of the motion's torque that is taken off at each frequency, shape (f,).

    ``w = Re S_tm / S_mm``, at most all, leaves the least power (Bendat and Piersol 2010, chapter 6): all where the
    joint moves so, nothing where the encoder makes noise. Less than half is not taken off: most of it is noise, or the
    encoder is not on what the torque moves, as on a gear that shakes, and then that is what is looked for.

    Args:
        common: Real part of the cross density of torque and motion, shape (f,).
        motion: Density of what the model gives the motion.
    """
    together, whole = (np.convolve(of, np.ones(COHERENT), mode="same") for of in (common, motion))
    share = np.minimum(together / np.maximum(whole, np.finfo(float).tiny), 1.0)
    return np.where(share < LEAST_SHARE, 0.0, share)
