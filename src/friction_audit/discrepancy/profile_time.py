"""Interval of a time constant, by likelihood ratio, under all laws that what fades may follow.

A time is kept that the log does not rule out, factors fitted anew:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

A time is told by what is left behind it as much as by what is gone, so that its interval is no interval about it (A. F.
Venzon, S. H. Moolgavkar, Journal of the Royal Statistical Society C 37 (1988) 87). Where what fades may follow other
laws than the formula, nobody knows which: each time is tried with all that hold for what is fitted with them, and the
best one counts.
"""

from collections.abc import Iterator

import numpy as np

from friction_audit.discrepancy.beside import Beside
from friction_audit.discrepancy.candidate import Baseline, Shape
from friction_audit.discrepancy.declared import CONFIDENCE, least_squares
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

    candidate, name = found.candidate, found.candidate.fading
    beside, value = Beside(others, ground.y), found.shape[name]
    times = (value * np.geomspace(1.0 / FARTHEST, FARTHEST, VALUES)).tolist()
    tried = [{**found.shape, name: time} for time in times]
    left = np.array(
        [
            min(
                beside.fit(ground.rows.of(candidate.columns(ground.data, baseline, one)))[1],
                *_left_by_others(found, one, ground, baseline, others),
                beside.without,
            )
            for one in tried
        ]
    )
    worth = len(ground.y) / ground.memory(others, found.columns)
    kept = np.flatnonzero(left <= left.min() * np.exp(chdtri(1, 1.0 - CONFIDENCE) / worth))
    if kept[0] == 0 or kept[-1] == len(times) - 1:
        return Coefficient(value=value, low=-np.inf, high=np.inf)
    return Coefficient(value=value, low=min(times[kept[0] - 1], value), high=max(times[kept[-1] + 1], value))


def _left_by_others(found: Found, shape: Shape, ground: Ground, baseline: Baseline, others: Float) -> Iterator[float]:
    """What other laws leave, the sum of squares, as far as they hold for the factors that they are fitted with."""
    for law in found.candidate.other_laws:
        columns = np.hstack([others, ground.rows.of(law.columns(ground.data, baseline, shape))])
        factors = least_squares(columns, ground.y)
        if law.holds(factors[others.shape[1] :], ground.declared.baseline(factors[: ground.base.shape[1]])):
            yield float(np.sum((ground.y - columns @ factors) ** 2))
