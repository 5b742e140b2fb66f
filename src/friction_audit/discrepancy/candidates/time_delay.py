"""Delay: minus the derivative of the predicted torque."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import several_speeds
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

LONGEST_S = 0.1


def columns(data: JointData, baseline: Baseline, _shape: Shape) -> Float:
    """Delay, shape (n, p)."""
    return np.asarray(-np.gradient(baseline.torque, data.step_s))[:, None]


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(abs(factors[0]) < LONGEST_S)


CANDIDATE = Candidate(
    name="time_delay",
    label="torque and velocity are not simultaneous",
    shapes=({},),
    columns=columns,
    column_units=("s",),
    untestable=several_speeds,
    admissible=admissible,
    axis="acceleration",
)
