"""Velocity thresholds from the log's own noise and speeds (the paper leaves them to experiment)."""

import numpy as np

from friction_audit.joint_log import Float

INITIATION_SHARE = 0.25
"""Share of the speed of brisk motion at which a cycle begins: 0.2 rad/s (the paper's choice) at 0.8 rad/s."""

TERMINATION_SHARE = 0.25
"""Termination over initiation, 0.05 / 0.2 in the paper."""

NOISE_MULTIPLE = 5.0
"""Termination stays this many standard deviations above the noise of the filtered velocity."""

BRISK_QUANTILE = 0.9


def thresholds_from_log(dq: Float, filtered: Float, *, rate_hz: float, cutoff_hz: float) -> tuple[float, float]:
    """Choose initiation and termination for one signal.

    The noise is what the filter takes away (its robust standard deviation), scaled by the share of white noise that
    the filter lets through. Brisk motion is the upper decile of the speeds above that noise.

    Args:
        dq: Velocity or speed as measured, shape (n,).
        filtered: The same, filtered, shape (n,).
        rate_hz: Sampling rate. [Hz]
        cutoff_hz: Corner of the filter. [Hz]

    Returns:
        Initiation and termination, in the unit of ``dq``.
    """
    floor = NOISE_MULTIPLE * _noise_left(dq, filtered, rate_hz=rate_hz, cutoff_hz=cutoff_hz)
    speed = np.abs(filtered)
    moving = speed[speed > floor]
    brisk = float(np.quantile(moving, BRISK_QUANTILE)) if len(moving) else floor
    initiation = max(INITIATION_SHARE * brisk, floor / TERMINATION_SHARE, TINY)
    return initiation, TERMINATION_SHARE * initiation


TINY = 1e-6
"""A log without any motion still gets thresholds above zero."""


def _noise_left(dq: Float, filtered: Float, *, rate_hz: float, cutoff_hz: float) -> float:
    """Standard deviation of the noise that passes the filter, from what does not pass."""
    taken = np.abs(dq - filtered)
    sigma = 1.4826 * float(np.median(taken))
    share = min(2.0 * cutoff_hz / rate_hz, 1.0)
    return sigma * float(np.sqrt(share / max(1.0 - share, share)))
