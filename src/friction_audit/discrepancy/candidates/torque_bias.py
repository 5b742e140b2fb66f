"""Torque bias: a constant, at rest too."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Torque bias, shape (n, p)."""
    return np.ones((len(data.t), 1))


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="torque_bias",
    label="offset of the torque sensor",
    shapes=({},),
    columns=columns,
    column_units=("nm",),
    untestable=both_directions,
    admissible=admissible,
    axis="time",
    same_as=("asymmetric_coulomb",),
)
