"""Interval of a time constant, by likelihood ratio.

A time is kept that the log does not rule out, the other numbers of the shape as found and factors fitted anew:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

A time is told by what is left behind it as much as by what is gone, so that its interval is no interval about it (A. F.
Venzon, S. H. Moolgavkar, Journal of the Royal Statistical Society C 37 (1988) 87).
"""

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
VALUES = 31


def time_interval(found: Found, ground: Ground, baseline: Baseline, others: Float) -> Coefficient:
    """Tell how well the time constant of an effect is known, on all rows; without bounds where they are too far.

    Args:
        found: The effect, whose candidate names the number.
        ground: The joint.
        baseline: What columns may lean on.
        others: All other columns of the model on the rows, shape (m, b).
    """
    from scipy.special import chdtri

    name = found.candidate.fading
    beside, value, left = Beside(others, ground.y), found.shape[name], np.zeros(VALUES)
    times = (value * np.geomspace(1.0 / FARTHEST, FARTHEST, VALUES)).tolist()
    for place, columns in found.candidate.each(ground.data, baseline, [{**found.shape, name: one} for one in times]):
        left[place] = beside.fit(ground.rows.of(columns))[1]
    worth = len(ground.y) / ground.memory(others, found.columns)
    kept = np.flatnonzero(left <= left.min() * np.exp(chdtri(1, 1.0 - CONFIDENCE) / worth))
    if kept[0] == 0 or kept[-1] == VALUES - 1:
        return Coefficient(value=value, low=-np.inf, high=np.inf)
    return Coefficient(value=value, low=min(times[kept[0] - 1], value), high=max(times[kept[-1] + 1], value))
