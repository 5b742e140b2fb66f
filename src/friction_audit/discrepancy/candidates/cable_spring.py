"""Cable: linear and cubic spring about the middle of the range."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Cable, shape (n, p)."""
    off = data.q - 0.5 * (data.q.min() + data.q.max())
    return np.column_stack([off, off**3])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.8)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="cable_spring",
    label="a cable pulls towards the middle",
    shapes=({},),
    columns=columns,
    column_units=("nm_per_rad", "nm_per_rad3"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
)
