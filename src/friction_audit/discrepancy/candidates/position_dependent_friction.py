"""Position-dependent friction: s cos kq, s sin kq."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import both_directions, span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Position-dependent friction, shape (n, p)."""
    angle = shape["order"] * data.q
    return np.asarray(direction(data)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return both_directions(data, baseline) or span(data, baseline, 0.5)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="position_dependent_friction",
    label="friction changes with position",
    shapes=tuple({"order": float(k)} for k in range(1, 9)),
    columns=columns,
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
)
