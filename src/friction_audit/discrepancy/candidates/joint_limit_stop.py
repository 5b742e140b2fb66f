"""Stops: quadratic hinges at both ends of the range."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Stops, shape (n, p)."""
    above = np.maximum(0.0, data.q - (data.q.max() - shape["margin_rad"]))
    below = np.maximum(0.0, data.q.min() + shape["margin_rad"] - data.q)
    return np.column_stack([above**2, -(below**2)])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.5)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(np.sum(factors) > 0)


CANDIDATE = Candidate(
    name="joint_limit_stop",
    label="a stop near the end of the range",
    shapes=tuple({"margin_rad": m} for m in (0.05, 0.1, 0.2, 0.4)),
    columns=columns,
    column_units=("nm_per_rad2", "nm_per_rad2"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
)
