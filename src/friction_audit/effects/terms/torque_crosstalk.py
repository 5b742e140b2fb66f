"""Crosstalk: a torque sensor also feels what the sensors before and after it feel."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

BOTH = 0


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the readings of the joints before and after as columns, 0 where there is none or it is not meant."""
    side = round(shape[0])
    columns = np.zeros((len(motion.t), 2))
    if motion.others is None:
        return columns
    joint, sensed = motion.others.joint, motion.others.sensed
    if side <= BOTH and joint > 0:
        columns[:, 0] = sensed[:, joint - 1]
    if side >= BOTH and joint + 1 < sensed.shape[1]:
        columns[:, 1] = sensed[:, joint + 1]
    return columns


TERM = Term(
    name="torque_crosstalk",
    label="torque of a neighbour leaks in",
    coefficients=(
        Parameter(name="crosstalk_before", unit="1", meaning="share of the reading of the joint before"),
        Parameter(name="crosstalk_after", unit="1", meaning="share of the reading of the joint after"),
    ),
    nonlinear=(
        Parameter(
            name="crosstalk_side",
            unit="1",
            meaning="-1 the joint before, 1 the one after, 0 both",
            lower=-1,
            upper=1,
            whole=True,
        ),
    ),
    basis=basis,
)
