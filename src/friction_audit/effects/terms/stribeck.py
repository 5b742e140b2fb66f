"""Stribeck friction: more friction at low speed, which fades as the lubricant's film builds up.

Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, eq. (5): the excess falls as
exp(-|dq / v_s|^delta).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sgn(dq) exp(-|dq / v_s|^delta) as a column."""
    speed, exponent = shape
    fading = np.exp(-(np.abs(motion.dq / speed) ** exponent))
    return np.asarray(motion.direction * fading)[:, None]


TERM = Term(
    name="stribeck",
    label="Stribeck friction",
    coefficients=(
        Parameter(name="stribeck_excess_nm", unit="N m", meaning="friction above Coulomb at rest", lower=0.0),
    ),
    nonlinear=(
        Parameter(name="stribeck_speed_rad_s", unit="rad/s", meaning="speed of fading", lower=1e-6, upper=10.0),
        Parameter(name="stribeck_exponent", unit="1", meaning="exponent of fading", lower=0.2, upper=5.0),
    ),
    basis=basis,
    friction=True,
    speed_only=True,
)
