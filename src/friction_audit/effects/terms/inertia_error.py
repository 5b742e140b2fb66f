"""Inertia behind the sensor that is not the one stated."""

from collections.abc import Sequence

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return ddq as a column."""
    return motion.ddq[:, None]


TERM = Term(
    name="inertia_error",
    label="the stated inertia is wrong",
    coefficients=(Parameter(name="extra_inertia_kg_m2", unit="kg m^2", meaning="true inertia less the one stated"),),
    basis=basis,
)
