"""Frictional lag: friction at a lagged speed less that at the present one."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import several_speeds
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Frictional lag, shape (n, p)."""
    from scipy.signal import lfilter

    keep = float(np.exp(-data.step_s / shape["lag_s"]))
    speed = np.abs(data.dq)
    lagged = lfilter([1.0 - keep], [1.0, -keep], speed, zi=[keep * speed[0]])[0]
    weaker = np.exp(-((lagged / shape["speed_rad_s"]) ** 2)) - np.exp(-((speed / shape["speed_rad_s"]) ** 2))
    return np.column_stack([direction(data) * weaker, direction(data) * (lagged - speed)])


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(np.any(factors > 0))


CANDIDATE = Candidate(
    name="frictional_lag",
    label="friction follows speed late",
    shapes=tuple({"lag_s": lag, "speed_rad_s": v} for lag in (0.01, 0.03, 0.1, 0.3) for v in (0.05, 0.15, 0.4)),
    columns=columns,
    column_units=("nm", "nms_per_rad"),
    untestable=several_speeds,
    admissible=admissible,
    axis="acceleration",
)
