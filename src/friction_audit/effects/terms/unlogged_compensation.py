"""A friction compensator that the log does not tell of: it helps the motion, less at low speed.

Smooth compensators hold back below a speed w, as tanh(dq / w), others have a dead band; that of C. Gaz et al., Dynamic
identification of the Franka Emika Panda robot, RA-L 4 (2019) 4147, is a sigmoid shifted through the origin.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

SMOOTH, DEAD_BAND = 0, 1


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what the joint then takes less, -tanh(dq / w + k) + tanh(k) or -sgn(dq) beyond a dead band."""
    width, skew, form = shape
    speed = motion.dq / width
    if round(form) == DEAD_BAND:
        return -(np.sign(speed) * (np.abs(speed) > 1.0))[:, None]
    return np.asarray(np.tanh(skew) - np.tanh(speed + skew))[:, None]


TERM = Term(
    name="unlogged_compensation",
    label="a compensator that the log does not tell of",
    coefficients=(Parameter(name="unlogged_nm", unit="N m", meaning="torque that it gives at high speed", lower=0.0),),
    nonlinear=(
        Parameter(
            name="unlogged_width_rad_s", unit="rad/s", meaning="speed up to which it holds back", lower=1e-4, upper=10.0
        ),
        Parameter(name="unlogged_skew", unit="1", meaning="shift of its sigmoid", lower=-2.0, upper=2.0),
        Parameter(name="unlogged_form", unit="1", meaning="0 smooth, 1 dead band", lower=0.0, upper=1.0, whole=True),
    ),
    basis=basis,
    speed_only=True,
)
