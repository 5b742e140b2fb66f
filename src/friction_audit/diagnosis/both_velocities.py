"""One velocity from two: the position's derivative where that is quieter, the logged velocity where it is not.

The noise of a position's derivative grows with the frequency, that of a tachometer does not. Of two readings of the
same with independent noise the best mean weighs each by the inverse of its noise's density; with the crossover f_x,
where both are equally noisy, the derivative counts by

    w(f) = 1 / (1 + (f / f_x)^2),

which is a symmetric exponential in time (N. Wiener, Extrapolation, Interpolation, and Smoothing of Stationary Time
Series, 1949).
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.rows import noise_density
from friction_audit.joint_log import Float

LOWEST_HZ = 2.0
"""Below the motion's own frequencies a derivative has nothing to give."""
REACH = 9.0
"""Time constants after which the exponential ends."""


def crossover_of(slope: Float, logged: Float, step_s: float) -> float:
    """Frequency at which the position's derivative and the logged velocity are equally noisy, 0 where too low. [Hz]"""
    rising = noise_density(slope, step_s, 1)
    crossing = noise_density(logged, step_s, 0) / rising if rising > 0 else 0.0
    return crossing if crossing >= LOWEST_HZ else 0.0


def best_of_both(slope: Float, logged: Float, valid: NDArray[np.bool_], step_s: float, crossover_hz: float) -> Float:
    """The mean of both, shape (n,).

    Args:
        slope: Derivative of the position on an even grid, shape (n,). [rad/s]
        logged: Logged velocity through the same filter, shape (n,). [rad/s]
        valid: Samples in which both can be trusted; elsewhere it is the logged one.
        step_s: Spacing of the grid. [s]
        crossover_hz: From :func:`crossover_of`. [Hz]
    """
    from scipy.signal import oaconvolve

    rate = 2.0 * np.pi * crossover_hz * step_s
    half = int(np.ceil(REACH / rate))
    kernel = np.exp(-rate * np.abs(np.arange(-half, half + 1)))
    apart = np.pad(np.where(valid, slope - logged, 0.0), half)
    return np.asarray(logged + oaconvolve(apart, kernel / kernel.sum(), "valid"))
