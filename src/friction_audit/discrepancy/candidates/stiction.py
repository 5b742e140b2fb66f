"""Stiction: friction that a rest has raised and that fades over the path after the onset."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import moves
from friction_audit.discrepancy.displacement import onsets
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.stiction import TERM

AGEINGS_S = (0.01, 0.3, 3.0)
"""At once, within a pause between strokes, and over many."""
SPAN_SHARES = np.geomspace(3e-4, 0.03, 6)
"""Paths of renewal as shares of the span of the motion."""
FEWEST_ONSETS = 15


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All ageings with all paths of renewal."""
    span = float(np.ptp(data.q)) or 1.0
    return tuple({"ageing_s": age, "renewal_rad": float(share) * span} for age in AGEINGS_S for share in SPAN_SHARES)


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    found = len(onsets(data))
    if found >= FEWEST_ONSETS:
        return moves(data, baseline)
    return f"{found} onsets after a rest: stop and start again at least {FEWEST_ONSETS} times, slowly"


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(factors[0] > 0)


CANDIDATE = Candidate(
    name="stiction",
    label="higher torque at breakaway",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="displacement",
    term=TERM,
)
