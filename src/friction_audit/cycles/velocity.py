"""The filtered velocity that detects cycles. It never enters an energy sum as the factor of a torque."""

import math

import numpy as np

from friction_audit.cycles import kernels
from friction_audit.joint_log import Float

HIGHEST_SHARE_OF_RATE = 0.4
"""A corner closer to the Nyquist frequency than this filters nothing worth filtering."""

PADDING = 9
"""Samples by which the signal is continued at each end, as scipy's sosfiltfilt does."""

MINIMUM_LENGTH = 16


def filter_velocity(dq: Float, *, rate_hz: float, cutoff_hz: float) -> Float:
    """Low-pass a velocity without phase shift (second-order Butterworth, forwards and backwards).

    Args:
        dq: Velocity, shape (n,). [rad/s]
        rate_hz: Sampling rate. [Hz]
        cutoff_hz: Corner of each pass. [Hz]

    Returns:
        Filtered velocity, shape (n,); ``dq`` itself where the rate is too low to filter. [rad/s]
    """
    if cutoff_hz >= HIGHEST_SHARE_OF_RATE * rate_hz or len(dq) < MINIMUM_LENGTH:
        return dq
    # Point reflections at both ends. scipy.signal would do the same, but loading it takes longer than this.
    head, tail = 2 * dq[0] - dq[PADDING:0:-1], 2 * dq[-1] - dq[-2 : -PADDING - 2 : -1]
    padded = np.concatenate([head, dq, tail])
    kernels.low_pass_both_ways(padded, *_butterworth(cutoff_hz / rate_hz))
    return padded[PADDING:-PADDING]


def _butterworth(corner: float) -> tuple[float, float, float]:
    """Return gain, a1 and a2 of the second-order filter, for a corner given in cycles per sample."""
    k = math.tan(math.pi * corner)
    whole = 1.0 + math.sqrt(2.0) * k + k * k
    return k * k / whole, 2.0 * (k * k - 1.0) / whole, (1.0 - math.sqrt(2.0) * k + k * k) / whole
