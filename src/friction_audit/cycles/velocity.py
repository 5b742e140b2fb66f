"""The filtered velocity that detects cycles. It never enters an energy sum as the factor of a torque."""

import numpy as np

from friction_audit.joint_log import Float

HIGHEST_SHARE_OF_RATE = 0.4
"""A corner closer to the Nyquist frequency than this filters nothing worth filtering."""


def filter_velocity(dq: Float, *, rate_hz: float, cutoff_hz: float) -> Float:
    """Low-pass a velocity without phase shift (second-order Butterworth, forwards and backwards).

    Args:
        dq: Velocity, shape (n,). [rad/s]
        rate_hz: Sampling rate. [Hz]
        cutoff_hz: Corner of each pass. [Hz]

    Returns:
        Filtered velocity, shape (n,); ``dq`` itself where the rate is too low to filter. [rad/s]
    """
    from scipy.signal import butter, sosfiltfilt

    if cutoff_hz >= HIGHEST_SHARE_OF_RATE * rate_hz or len(dq) < MINIMUM_LENGTH:
        return dq
    corner = butter(2, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(sosfiltfilt(corner, dq), dtype=np.float64)


MINIMUM_LENGTH = 16
"""sosfiltfilt pads by nine samples at each end and needs more than that."""
