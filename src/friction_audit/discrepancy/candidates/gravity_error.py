"""Gravity error: cos q, sin q."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Gravity error, shape (n, p)."""
    return np.column_stack([np.cos(data.q), np.sin(data.q)])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 1.5)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="gravity_error",
    label="gravity not fully compensated",
    shapes=({},),
    columns=columns,
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
)
