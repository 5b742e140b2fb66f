"""Coulomb friction that differs between the directions: half the difference acts the same way in both."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return |sgn(dq)| as a column: 1 in motion, 0 at rest."""
    return np.abs(np.sign(motion.dq))[:, None]


TERM = Term(
    name="asymmetric_coulomb",
    label="Coulomb friction differs by direction",
    coefficients=(
        Parameter(
            name="coulomb_half_difference_nm", unit="N m", meaning="half of Coulomb friction forward less backward"
        ),
    ),
    basis=basis,
    speed_only=True,
)
