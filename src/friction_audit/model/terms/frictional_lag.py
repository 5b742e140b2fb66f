"""Frictional lag: friction follows the speed late, its direction does not.

Friction is level + slope v_s (1 - exp(-s / v_s)) at a speed s that lags behind the present one by a first-order delay
(A. Ruina, J. Geophys. Res. 88 (1983) 10359; D. P. Hess, A. Soom, J. Tribol. 112 (1990) 147). A slope above zero is
viscous friction, one below zero Stribeck's, which fades at v_s.
"""

from collections.abc import Sequence
from math import exp

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term


def lagged(signal: Float, step_s: float, lag_s: float) -> Float:
    """Return a signal behind a first-order delay, from its first value on, shape (n,)."""
    from scipy.signal import lfilter

    keep = exp(-step_s / lag_s)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * signal[0]])[0])


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return friction at the lagged speed less that at the present one, per slope, as a column."""
    lag, fading = shape
    speed = np.abs(motion.dq)
    seen = lagged(speed, float(motion.t[1] - motion.t[0]), lag)
    return np.asarray(np.sign(motion.dq) * fading * (np.exp(-speed / fading) - np.exp(-seen / fading)))[:, None]


TERM = Term(
    name="frictional_lag",
    label="friction follows speed late",
    linear=(Parameter(name="lagging_nms_per_rad", unit="N m s/rad", meaning="slope of the friction that lags"),),
    shape=(
        Parameter(name="friction_lag_s", unit="s", meaning="time by which friction lags", lower=1e-4, upper=10.0),
        Parameter(
            name="lag_speed_rad_s", unit="rad/s", meaning="speed at which the slope fades", lower=1e-4, upper=1e4
        ),
    ),
    basis=basis,
)
