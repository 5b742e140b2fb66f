"""Ripple: cos kq, sin kq; every order tried is a trial."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Ripple, shape (n, p)."""
    angle = shape["order"] * data.q
    return np.column_stack([np.cos(angle), np.sin(angle)])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.5)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="torque_ripple",
    label="torque periodic in position",
    shapes=tuple({"order": float(k)} for k in range(8, 241, 2)),
    columns=columns,
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
)
