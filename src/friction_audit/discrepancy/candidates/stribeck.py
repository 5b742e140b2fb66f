"""Stribeck friction: s exp(-|v/vs|^d)."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import speed_range
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Stribeck friction, shape (n, p)."""
    ratio = np.abs(data.dq) / shape["speed_rad_s"]
    return np.asarray(direction(data) * np.exp(-(ratio ** shape["exponent"])))[:, None]


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return speed_range(data, baseline, 8.0)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name="stribeck",
    label="more friction at low speed",
    shapes=tuple({"speed_rad_s": float(v), "exponent": d} for v in np.geomspace(0.01, 0.5, 9) for d in (1.0, 2.0)),
    columns=columns,
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
)
