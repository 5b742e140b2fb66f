"""Unlogged compensation: a share of the declared friction, smooth at low speed."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

NEEDED = frozenset({"coulomb_nm", "viscous_nms_per_rad"})
NOT_DECLARED = "the friction was fitted, so a compensator only makes it less: declare it, or log the command"
LARGEST_SHARE = 2.0


def columns(data: JointData, baseline: Baseline, shape: Shape) -> Float:
    """Unlogged compensation, shape (n, p)."""
    smooth = np.tanh(data.dq / shape["width_rad_s"])
    return np.asarray(-(baseline.coulomb_nm * smooth + baseline.viscous_nms_per_rad * data.dq))[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return both_directions(data, baseline) if baseline.declared >= NEEDED else NOT_DECLARED


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(0 < factors[0] < LARGEST_SHARE)


CANDIDATE = Candidate(
    name="unlogged_compensation",
    label="a compensator that the log does not name",
    shapes=tuple({"width_rad_s": v} for v in (0.01, 0.03, 0.1, 0.3)),
    columns=columns,
    column_units=("1",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
)
