"""Breakaway torque: a burst that fades after each onset of motion."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import moves
from friction_audit.discrepancy.displacement import onsets
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

FEWEST_ONSETS = 15


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Breakaway torque, shape (n, p)."""
    since = np.full(len(data.t), np.inf)
    starts = onsets(data)
    last = np.searchsorted(starts, np.arange(len(data.t)), side="right") - 1
    if len(starts):
        since = np.where(last >= 0, data.t - data.t[starts[np.maximum(last, 0)]], np.inf)
    return np.asarray(direction(data) * np.exp(-since / shape["fade_s"]))[:, None]


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
    shapes=tuple({"fade_s": f} for f in (0.02, 0.05, 0.1, 0.2)),
    columns=columns,
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="time",
)
