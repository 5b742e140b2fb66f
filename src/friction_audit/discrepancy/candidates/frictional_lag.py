"""Frictional lag: friction at a lagged speed less that at the present one."""

import numpy as np

from friction_audit.discrepancy.candidate import Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import several_speeds
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.frictional_lag import TERM

LAGS_S = np.geomspace(3e-3, 1.0, 8)
FADING_SHARES = np.geomspace(0.02, 0.5, 5)
"""Speeds at which Stribeck friction fades, as shares of the usual top speed."""
UNFADING = 100.0
"""In usual top speeds: the slope is the same at all of them."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Viscous friction and Stribeck friction of several widths, by all lags."""
    usual = float(np.quantile(np.abs(data.dq), 0.95)) or 1.0
    return tuple(
        {"friction_lag_s": float(lag), "lag_speed_rad_s": float(share) * usual}
        for share in (UNFADING, *FADING_SHARES)
        for lag in LAGS_S
    )


def admissible(factors: Float, shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    del shape
    return bool(factors[0] != 0)


CANDIDATE = Candidate(
    name="frictional_lag",
    label="friction follows speed late",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nms_per_rad",),
    untestable=several_speeds,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
)
