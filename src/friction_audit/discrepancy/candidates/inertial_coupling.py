"""Inertial coupling: accelerations and squared speeds of all other joints."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import neighbours_move
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Inertial coupling, shape (n, p)."""
    ddq = np.delete(data.others_ddq, data.joint, axis=1)
    dq = np.delete(data.others_dq, data.joint, axis=1)
    return np.hstack([ddq, dq**2])


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="inertial_coupling",
    label="other joints shake this one",
    shapes=({},),
    columns=columns,
    column_units=("kg_m2",),
    untestable=neighbours_move,
    admissible=admissible,
    axis="neighbour",
)
