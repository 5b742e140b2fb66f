"""Unlogged compensation: Coulomb friction is missing at speed and comes back where a compensator holds back.

Only what is stated can be missing: where Coulomb friction is fitted, less of it is all that a compensator leaves beside
a rise towards rest, which is Stribeck's. Viscous friction is fitted all the same, for a compensator takes of it too.
"""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.terms.unlogged_compensation import DEAD_BAND, SMOOTH, TERM
from friction_audit.joint_log import Float

NOT_DECLARED = (
    "the friction was fitted to this log, and a compensator makes it less: state Coulomb friction (--model with held = "
    '["coulomb"]), or log the commanded torque'
)
WIDTHS = 6
LOWEST, HIGHEST = 0.01, 0.4
"""Shares of the log's high speed below which a compensator may hold back."""
SKEWS = (-0.3, 0.0, 0.3)


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Widths by the speeds of the log; smooth ones with some skew."""
    (fast,) = speeds(data, 95.0)
    widths = np.clip(
        np.geomspace(LOWEST * fast, HIGHEST * fast, WIDTHS), TERM.nonlinear[0].lower, TERM.nonlinear[0].upper
    )
    forms = (*((skew, SMOOTH) for skew in SKEWS), (0.0, DEAD_BAND))
    return tuple(
        {"unlogged_width_rad_s": float(width), "unlogged_skew": skew, "unlogged_form": float(form)}
        for width in widths
        for skew, form in forms
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The numbers or the motion that are lacking."""
    return both_directions(data, baseline) if "coulomb_nm" in baseline.declared else NOT_DECLARED


def admissible(factors: Float, _shape: Shape) -> bool:
    """It helps the motion."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label="less friction than stated, as a compensator that the log does not name leaves",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
    term=TERM,
)
