"""Half the difference of the two levels: 1 while the joint moves."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Half the difference of the two levels, shape (n, p)."""
    return np.asarray(np.abs(direction(data)))[:, None]


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="asymmetric_coulomb",
    label="friction differs by direction",
    shapes=({},),
    columns=columns,
    column_units=("nm",),
    untestable=both_directions,
    admissible=admissible,
    axis="speed",
    same_as=("torque_bias",),
)
