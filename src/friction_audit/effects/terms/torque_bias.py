"""A torque sensor that does not read zero without a load."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, _shape: Sequence[float]) -> Float:
    """Return a column of ones: at rest too."""
    return np.ones((len(motion.t), 1))


TERM = Term(
    name="torque_bias",
    label="offset of the torque sensor",
    coefficients=(Parameter(name="torque_bias_nm", unit="N m", meaning="interaction torque as read without a load"),),
    basis=basis,
    speed_only=True,
)
