"""Drift: a cubic of time that is zero at the start of the recording."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Drift from the start of the recording, shape (n, p)."""
    x = (data.t - data.t[0]) / (data.t[-1] - data.t[0])
    return np.column_stack([x, x**2, x**3])


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="torque_drift",
    label="the torque drifts slowly",
    shapes=({},),
    columns=columns,
    column_units=("nm", "nm", "nm"),
    untestable=both_directions,
    admissible=admissible,
    axis="time",
)
