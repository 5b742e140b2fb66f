"""Nonlinear viscous friction: s |v|^p."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import speed_range
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Nonlinear viscous friction, shape (n, p)."""
    return np.asarray(direction(data) * np.abs(data.dq) ** shape["exponent"])[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return speed_range(data, baseline, 5.0)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="nonlinear_viscous",
    label="friction curved in speed",
    shapes=tuple({"exponent": p} for p in (0.3, 0.5, 0.7, 1.5, 2.0, 2.5, 3.0)),
    columns=columns,
    column_units=("nm_at_1_rad_s",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
)
