"""Viscous friction: proportional to the velocity."""

from collections.abc import Sequence

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return dq as a column."""
    return motion.dq[:, None]


TERM = Term(
    name="viscous",
    label="viscous friction",
    coefficients=(Parameter(name="viscous_nms_per_rad", unit="N m s/rad", meaning="friction per velocity", lower=0.0),),
    basis=basis,
    friction=True,
    speed_only=True,
)
