"""Constant torque: a sensor's zero, or Coulomb friction that differs between the directions (the same in motion)."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return a column of ones."""
    return np.ones((len(motion.t), 1))


TERM = Term(
    name="offset",
    label="constant torque",
    coefficients=(Parameter(name="offset_nm", unit="N m", meaning="torque that the joint takes without moving"),),
    basis=basis,
    speed_only=True,
)
