"""Interval of a time constant, by likelihood ratio, whatever the law by which friction follows the temperature.

A time is kept that the log does not rule out, the other numbers of the shape as found and factors fitted anew:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

A time is told by what is left behind it as much as by what is gone, so that its interval is no interval about it (A. F.
Venzon, S. H. Moolgavkar, Journal of the Royal Statistical Society C 37 (1988) 87).

What fades as u = exp(-t / T) is the way to the final temperature. How friction follows from the temperature nobody
stated; to second order it is b u + c u^2, and the part that fades twice as fast moves the time. Two things are known of
it. Friction falls faster at first than later, as that of lubricants does (O. Reynolds, Philosophical Transactions 177
(1886) 157): c has the sign of b. And it would not rise again if the joint got warm once more as much: at u = -1 it
still falls, 2 c < b. So each time is tried with every law between u and u + u^2 / 2, beside the plain one.
"""

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.declared import CONFIDENCE
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

FARTHEST = 6.0
"""Times are tried from so many times less to so many times more than the one that was found."""
VALUES = 31
MOST_BENT = 0.5
"""Of u^2, beside u: friction would rise again soon behind the warm joint if it were more."""


def time_interval(found: Found, ground: Ground, baseline: Nominal, others: Float) -> Coefficient:
    """Tell how well the time constant of an effect is known, on all rows; without bounds where they are too far.

    Args:
        found: The effect, whose candidate names the number.
        ground: The joint.
        baseline: What columns may lean on.
        others: All other columns of the model on the rows, shape (m, b).
    """
    from scipy.special import chdtri

    value = found.shape[found.candidate.time_constant]
    times = value * np.geomspace(1.0 / FARTHEST, FARTHEST, VALUES)
    left = _left(found, times, ground, baseline, others)
    worth = len(ground.y) / ground.memory(others, found.columns)
    kept = np.flatnonzero(left <= left.min() * np.exp(chdtri(1, 1.0 - CONFIDENCE) / worth))
    if kept[0] == 0 or kept[-1] == VALUES - 1:
        return Coefficient(value=value, low=-np.inf, high=np.inf)
    low, high = float(times[kept[0] - 1]), float(times[kept[-1] + 1])
    return Coefficient(value=value, low=min(low, value), high=max(high, value))


def _left(found: Found, times: Float, ground: Ground, baseline: Nominal, others: Float) -> Float:
    """Residual sum of squares with each time, the least of all laws, shape (k,)."""
    beside, name, left = Beside(others, ground.y), found.candidate.time_constant, np.zeros(len(times))
    falls = np.sign(beside.fit(found.columns)[0])
    for k, time in enumerate(times.tolist()):
        once, twice = (
            ground.rows.of(found.candidate.regressor(ground.data, baseline, {**found.shape, name: time / power}))
            for power in (1.0, 2.0)
        )
        laws = np.hstack([once, once + MOST_BENT * twice])
        left[k] = min(beside.fit(once)[1], beside.left_above_zero(laws * np.tile(falls, 2)))
    return left
