"""Inertia error: the acceleration."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import several_speeds
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

NOT_DECLARED = "the inertia was fitted, so it cannot be wrong: declare it, and move at two or more frequencies"


def columns(data: JointData, _baseline: Baseline, _shape: Shape) -> Float:
    """Inertia error, shape (n, p)."""
    return np.asarray(data.ddq)[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return several_speeds(data, baseline) if "inertia_kg_m2" in baseline.declared else NOT_DECLARED


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return True


CANDIDATE = Candidate(
    name="inertia_error",
    label="the declared inertia is wrong",
    shapes=({},),
    columns=columns,
    column_units=("kg_m2",),
    untestable=untestable,
    admissible=admissible,
    axis="acceleration",
)
