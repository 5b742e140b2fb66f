"""Crosstalk: torques of the joints before and after, 0 where there is none."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import neighbours_move
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Crosstalk, shape (n, p)."""
    padded = np.pad(data.others_torque, ((0, 0), (1, 1)))
    return np.asarray(padded[:, [data.joint, data.joint + 2]])


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(np.all(np.abs(factors) < 1))


CANDIDATE = Candidate(
    name="torque_crosstalk",
    label="torque of a neighbour leaks in",
    shapes=({},),
    columns=columns,
    column_units=("1", "1"),
    untestable=neighbours_move,
    admissible=admissible,
    axis="neighbour",
)
