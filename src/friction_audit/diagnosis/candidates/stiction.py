"""Stiction: friction that a rest has raised and that fades over the path after the onset."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.breakaway import find_breakaways, torque_known
from friction_audit.effects.excitation import moves
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.stiction import TERM
from friction_audit.joint_log import Float

AGEINGS_S = (0.01, 0.3, 3.0)
"""At once, within a pause between strokes, and over many."""
AT_ONCE_RAD = 1e-5
"""A path of renewal that is over before the direction of motion is certain."""
SPAN_SHARES = np.geomspace(3e-4, 0.03, 6)
"""Longer ones as shares of the span of the motion."""
FEWEST_BREAKAWAYS = 6
"""As many as the cycles that a diagnosis takes; whether they are enough, price of entry and locked cycles say."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All ageings with all paths of renewal."""
    return _shapes(AT_ONCE_RAD, *_paths(data))


def shown(data: JointData) -> tuple[Shape, ...]:
    """Those that fade over a path behind the start, whatever the torque did at the moment of break-away."""
    starts, _ = _starts(data)
    return _shapes(*_paths(data)) if starts >= FEWEST_BREAKAWAYS else ()


def _shapes(*paths: float) -> tuple[Shape, ...]:
    return tuple({"ageing_s": age, "renewal_rad": path} for age in AGEINGS_S for path in paths)


def _paths(data: JointData) -> list[float]:
    span = float(np.ptp(data.q)) or 1.0
    return [float(share) * span for share in SPAN_SHARES]


def _starts(data: JointData) -> tuple[int, int]:
    """How often the joint breaks away from a standstill, and how often the torque at that moment is known."""
    seen = find_breakaways(data.q, data.dq, data.dead_speed_rad_s, data.step_s)
    counted = data.valid[seen.onset] & (data.cycle[seen.onset] >= 0)
    return int(counted.sum()), int(np.sum(counted & torque_known(data.torque, seen, data.step_s)))


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking for an excess that is gone at once."""
    starts, telling = _starts(data)
    if telling >= FEWEST_BREAKAWAYS:
        return moves(data, baseline)
    return (
        f"the joint breaks away from a standstill {starts} times, {telling} of them under a torque that rises slowly "
        "or falls behind the start: let it stand still for a tenth of a second or more, then raise the torque slowly "
        f"until it moves, at least {FEWEST_BREAKAWAYS} times"
    )


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
    shown=shown,
)
