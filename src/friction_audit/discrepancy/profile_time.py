"""Interval of a time constant, by likelihood ratio, under every law that what fades may follow.

A time is kept that the log does not rule out, factors fitted anew:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

A time is told by what is left behind it as much as by what is gone, so that its interval is no interval about it (A. F.
Venzon, S. H. Moolgavkar, Journal of the Royal Statistical Society C 37 (1988) 87). Where a second law is as likely as
the formula, the interval holds the times of both: nobody knows which one the joint follows.
"""

from collections.abc import Callable

import numpy as np

from friction_audit.discrepancy.beside import Beside
from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.declared import CONFIDENCE
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.naming import Found
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

FARTHEST = 6.0
"""Times are tried from so many times less to so many times more than the one that was found."""
VALUES = 41
Columns = Callable[[float], Float]
"""Columns on the rows for a time."""


def time_interval(found: Found, ground: Ground, baseline: Baseline, others: Float) -> Coefficient:
    """Tell how well the time constant of an effect is known, on all rows; without bounds where they are too far.

    Args:
        found: The effect, whose candidate names the number.
        ground: The joint.
        baseline: What columns may lean on.
        others: All other columns of the model on the rows, shape (m, b).
    """
    candidate, name = found.candidate, found.candidate.fading
    beside, data, rows = Beside(others, ground.y), ground.data, ground.rows
    factors, _ = beside.fit(found.columns)
    other = candidate.other_law

    def usual(time_s: float) -> Float:
        return rows.of(candidate.columns(data, baseline, {**found.shape, name: time_s}))

    def another(time_s: float) -> Float:
        shape = {**found.shape, name: time_s}
        return usual(time_s) if other is None else rows.of(other(data, baseline, shape, factors))

    worth = len(ground.y) / ground.memory(others, found.columns)
    value = found.shape[name]
    times = value * np.geomspace(1.0 / FARTHEST, FARTHEST, VALUES)
    ends = [_ends(times, law, beside, worth) for law in (usual, another)]
    if any(end is None for end in ends):
        return Coefficient(value=value, low=-np.inf, high=np.inf)
    every = [value, *(one for end in ends if end is not None for one in end)]
    return Coefficient(value=value, low=min(every), high=max(every))


def _ends(times: Float, law: Columns, beside: Beside, worth: float) -> tuple[float, float] | None:
    """The nearest times that the log rules out; None where it does not on one side."""
    from scipy.special import chdtri

    left = np.array([beside.fit(law(float(time)))[1] for time in times])
    kept = np.flatnonzero(left <= left.min() * np.exp(chdtri(1, 1.0 - CONFIDENCE) / worth))
    if kept[0] == 0 or kept[-1] == len(times) - 1:
        return None
    return float(times[kept[0] - 1]), float(times[kept[-1] + 1])
