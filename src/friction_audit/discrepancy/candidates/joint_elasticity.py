"""Elasticity: second derivative of the smooth part of the model torque."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import several_speeds
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, baseline: Baseline, _shape: Shape) -> Float:
    """Elasticity, shape (n, p)."""
    smooth = baseline.inertia_kg_m2 * data.ddq + baseline.viscous_nms_per_rad * data.dq
    return np.asarray(np.gradient(np.gradient(smooth, data.step_s), data.step_s))[:, None]


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="joint_elasticity",
    label="a spring between motor and link",
    shapes=({},),
    columns=columns,
    column_units=("s2",),
    untestable=several_speeds,
    admissible=admissible,
    axis="acceleration",
)
