"""Nonlinear viscous friction: drag, or a lubricant that thins or saturates, as one family of curves."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import speed_range
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.terms.nonlinear_viscous import TERM
from friction_audit.joint_log import Float

POWERS = (0.5, 1.5, 2.0, 3.0)
"""Exponents of plain powers: the bend lies below all speeds of the log."""
BENDS = 9
LOWEST, HIGHEST = 0.001, 1.0
"""Shares of the log's high speed between which a friction may saturate."""
SHARPNESSES = (-0.7, 0.0, 1.5)
"""Of saturation: as the arc tangent, a root and tanh."""
NO_BEND = 1e-3


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Plain powers, and saturation at several speeds."""
    (fast,) = speeds(data, 95.0)
    powers = [_curve(exponent, NO_BEND * float(fast)) for exponent in POWERS]
    bends = [float(share * fast) for share in np.geomspace(LOWEST, HIGHEST, BENDS)]
    return *powers, *(_curve(0.0, v) | {"curved_viscous_sharpness": s} for v in bends for s in SHARPNESSES)


def _curve(exponent: float, speed: float) -> dict[str, float]:
    return {"curved_viscous_exponent": exponent, "curved_viscous_speed_rad_s": speed}


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return speed_range(data, baseline, 5.0)


def admissible(factors: Float, shape: Shape) -> bool:
    """A curve that flattens must rise: if it fell, friction would fall steeply with speed, which is Stribeck's."""
    return bool(factors[0] > 0 or shape["curved_viscous_exponent"] > 1.0)


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="speed",
    term=TERM,
)
