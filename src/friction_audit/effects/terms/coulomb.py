"""Coulomb friction: the same torque at any speed, against the motion."""

from collections.abc import Sequence

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return sgn(dq) as a column, 0 at rest: there, friction is whatever holds the joint."""
    return motion.direction[:, None]


TERM = Term(
    name="coulomb",
    label="Coulomb friction",
    coefficients=(Parameter(name="coulomb_nm", unit="N m", meaning="friction at any speed", lower=0.0),),
    basis=basis,
    friction=True,
    speed_only=True,
)
