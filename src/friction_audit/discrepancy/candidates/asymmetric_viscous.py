"""Half the difference of the two slopes: |v|."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Half the difference of the two slopes, shape (n, p)."""
    return np.asarray(np.abs(data.dq))[:, None]


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="asymmetric_viscous",
    label="viscous friction differs by direction",
    shapes=({},),
    columns=columns,
    column_units=("nms_per_rad",),
    untestable=both_directions,
    admissible=admissible,
    axis="speed",
)
