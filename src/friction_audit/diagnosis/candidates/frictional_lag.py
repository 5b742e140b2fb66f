"""Frictional lag: friction at a lagged speed less that at the present one."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of, columns_together
from friction_audit.effects.excitation import several_speeds
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.terms.frictional_lag import TERM
from friction_audit.joint_log import Float

LAGS_S = np.geomspace(3e-3, 0.5, 8)
STRIBECK = ((1e-3, 0.3), *((excess, float(share)) for excess in (0.2, 1.0) for share in np.geomspace(0.05, 0.5, 4)))
"""Excess at rest over Coulomb friction, and the speed at which it fades as a share of the usual top speed."""
LARGEST_SHARE = 1.6
"""All the friction that depends on the speed lags, as far as a fit that did not know of it can tell."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Viscous friction, and Stribeck friction of several sizes and widths, by all lags."""
    usual = float(np.quantile(np.abs(data.dq), 0.95)) or 1.0
    return tuple(
        {"friction_lag_s": float(lag), "lagging_excess": excess, "lag_speed_rad_s": share * usual}
        for excess, share in STRIBECK
        for lag in LAGS_S
    )


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(0.0 < factors[0] <= LARGEST_SHARE)


CANDIDATE = Candidate(
    name="frictional_lag",
    label="friction follows speed late",
    shapes=shapes,
    columns=columns_of(TERM),
    together=columns_together(TERM),
    column_units=("1",),
    untestable=several_speeds,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
    leans_on_model=True,
)
