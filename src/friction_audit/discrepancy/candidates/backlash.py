"""Backlash: friction and inertia are missing within a dead zone after each reversal."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import reversals
from friction_audit.discrepancy.displacement import strokes
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Backlash, shape (n, p)."""
    stroke = strokes(data)
    free = (np.abs(stroke.displacement) < shape["gap_rad"]) & (stroke.direction != 0)
    return np.column_stack([direction(data) * free, data.ddq * free])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return reversals(data, baseline, 20)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] <= 0)


CANDIDATE = Candidate(
    name="backlash",
    label="free play at a reversal",
    shapes=tuple({"gap_rad": float(g)} for g in np.geomspace(1e-3, 0.1, 9)),
    columns=columns,
    column_units=("nm", "kg_m2"),
    untestable=untestable,
    admissible=admissible,
    axis="displacement",
)
