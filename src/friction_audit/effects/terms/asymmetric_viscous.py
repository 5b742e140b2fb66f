"""Viscous friction that differs between the directions: half the difference acts the same way in both."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return |dq| as a column."""
    return np.abs(motion.dq)[:, None]


TERM = Term(
    name="asymmetric_viscous",
    label="viscous friction differs by direction",
    coefficients=(
        Parameter(
            name="viscous_half_difference_nms_per_rad",
            unit="N m s/rad",
            meaning="half of the viscous coefficient forward less backward",
        ),
    ),
    basis=basis,
    speed_only=True,
)
