"""Presliding: a stop element in the place of the sign."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import reversals
from friction_audit.discrepancy.displacement import stop_operator
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Presliding, shape (n, p)."""
    return np.asarray(stop_operator(data.q, shape["reach_rad"]) - direction(data))[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return reversals(data, baseline, 20)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name="presliding",
    label="friction builds up after a reversal",
    shapes=tuple({"reach_rad": float(d)} for d in np.geomspace(3e-4, 0.1, 11)),
    columns=columns,
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="displacement",
)
