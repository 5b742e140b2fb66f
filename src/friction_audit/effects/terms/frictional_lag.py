"""Frictional lag: friction follows the speed late, its direction does not.

Of the torque of friction at a steady speed s, level + mu_v s + e mu_c exp(-s / v_s), all that depends on the speed is
that of a speed behind a first-order delay (A. Ruina, J. Geophys. Res. 88 (1983) 10359; D. P. Hess, A. Soom, J. Tribol.
112 (1990) 147). The excess e at rest is 0 for viscous friction alone.
"""

from collections.abc import Iterator, Sequence
from math import exp

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import far_side
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def lagged(signal: Float, step_s: float, lag_s: float) -> Float:
    """Return a signal behind a first-order delay, from its first value on, shape (n,)."""
    from scipy.signal import lfilter

    keep = exp(-step_s / lag_s)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * signal[0]])[0])


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return friction at the lagged speed less that at the present one, as a column."""
    ((_, column),) = bases(motion, [shape])
    return column


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield the same for many shapes; those with the same lag see the same speed."""
    far, speed, sign = far_side(motion), np.abs(motion.dq), motion.direction
    step = float(motion.t[1] - motion.t[0])
    now = {fading: np.exp(-speed / fading) for fading in {fading for _, _, fading in shapes}}
    places: dict[float, list[int]] = {}
    for place, (lag, _, _) in enumerate(shapes):
        places.setdefault(lag, []).append(place)
    for lag, alike in places.items():
        seen = lagged(speed, step, lag)
        viscous = far.viscous_nms_per_rad * (seen - speed)
        for place in alike:
            _, excess, fading = shapes[place]
            stribeck = excess * far.coulomb_nm * (np.exp(-seen / fading) - now[fading])
            yield place, (sign * (viscous + stribeck))[:, None]


TERM = Term(
    name="frictional_lag",
    label="friction follows speed late",
    coefficients=(
        Parameter(name="lagging_share", unit="1", meaning="share of friction that lags", lower=0.0, upper=2.0),
    ),
    nonlinear=(
        Parameter(name="friction_lag_s", unit="s", meaning="time by which friction lags", lower=1e-4, upper=10.0),
        Parameter(
            name="lagging_excess", unit="1", meaning="Stribeck friction at rest over Coulomb", lower=0.0, upper=5.0
        ),
        Parameter(name="lag_speed_rad_s", unit="rad/s", meaning="speed at which it fades", lower=1e-4, upper=1e2),
    ),
    basis=basis,
    bases=bases,
)
