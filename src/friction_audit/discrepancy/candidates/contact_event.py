"""Contact: one raised-cosine window in time."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import moves
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

WINDOWS = 120


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Contact, shape (n, p)."""
    width = (data.t[-1] - data.t[0]) / WINDOWS
    x = (data.t - data.t[0]) / width - shape["window"]
    return np.asarray(np.where(np.abs(x) < 1.0, 0.5 + 0.5 * np.cos(np.pi * x), 0.0))[:, None]


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="contact_event",
    label="something touches the arm for a moment",
    shapes=tuple({"window": float(k)} for k in range(1, WINDOWS)),
    columns=columns,
    column_units=("nm",),
    untestable=moves,
    admissible=admissible,
    axis="time",
)
