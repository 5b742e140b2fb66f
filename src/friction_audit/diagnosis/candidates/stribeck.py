"""Stribeck friction: more friction at low speed."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import speed_range
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.terms.stribeck import TERM
from friction_audit.joint_log import Float

SPEEDS = 8
EXPONENTS = (0.5, 1.0, 2.0)
LOWEST, HIGHEST = 0.01, 0.4
"""Shares of the log's high speed between which friction may fade: beyond, no film has built up within the log."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Speeds of fading by the speeds of the log, each with the exponents."""
    (fast,) = speeds(data, 95.0)
    fading = np.clip(
        np.geomspace(LOWEST * fast, HIGHEST * fast, SPEEDS), TERM.nonlinear[0].lower, TERM.nonlinear[0].upper
    )
    return tuple({"stribeck_speed_rad_s": float(v), "stribeck_exponent": d} for v in fading for d in EXPONENTS)


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return speed_range(data, baseline, 8.0)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Friction falls with speed."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label="more friction at low speed",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
    term=TERM,
)
