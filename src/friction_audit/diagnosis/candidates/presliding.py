"""Presliding: bristles in the place of the sign."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of, columns_together
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal, strokes
from friction_audit.effects.terms.presliding import TERM
from friction_audit.joint_log import Float

SPAN_SHARES = np.append(np.geomspace(1e-5, 1e-4, 3)[:-1], np.geomspace(1e-4, 0.3, 18))
"""Reaches as shares of the span of the motion, from friction that is hardly rounded: a stiff spring rounds it too, and
would take its name."""
KINDS = ((0.02, 1e-4), (0.5, 1e-4), (1.0, 1e-4), (2.0, 1e-4), (1.0, 0.01))
"""Exponents with times of damping: one stop, a row of stops, Dahl's, a slow one, and LuGre's with its damping."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All reaches of all kinds."""
    span = float(np.ptp(data.q)) or 1.0
    return tuple(
        {"reach_rad": float(share) * span, "yielding_exponent": exponent, "bristle_damping_s": damping}
        for exponent, damping in KINDS
        for share in SPAN_SHARES
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return reversals(data, baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] > 0)


def stands_in(data: JointData, shape: Shape) -> str:
    """Whether friction would still build up at most moments of the motion: what never slides is no presliding."""
    travelled = float(np.median(np.abs(strokes(data).displacement[data.used]))) if data.used.any() else 0.0
    if shape["reach_rad"] <= travelled:
        return ""
    return (
        f"presliding over {shape['reach_rad']:.2g} rad, where the joint is within {travelled:.2g} rad of its last "
        "reversal half of the time, stands in for something else that follows the motion"
    )


CANDIDATE = Candidate(
    name="presliding",
    label="friction builds up after a reversal",
    shapes=shapes,
    columns=columns_of(TERM),
    together=columns_together(TERM),
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="displacement",
    term=TERM,
    stands_in=stands_in,
)
