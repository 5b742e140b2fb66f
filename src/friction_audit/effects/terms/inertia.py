"""Reflected inertia behind the torque sensor."""

from collections.abc import Sequence

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return ddq as a column: tau = B ddq."""
    return motion.ddq[:, None]


TERM = Term(
    name="inertia",
    label="inertia",
    coefficients=(Parameter(name="inertia_kg_m2", unit="kg m^2", meaning="inertia behind the sensor", lower=0.0),),
    basis=basis,
)
