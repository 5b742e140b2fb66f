"""Interval of the moment at which something changes, by likelihood ratio: no derivative tells how well it is known.

A moment is kept that the log does not rule out, the other numbers of the shape as found and factors fitted anew:

    n_eff ln(RSS / RSS_best) < 7.35

The misfit about a change is a random walk and no parabola, so that the quantile is not that of chi squared (B. E.
Hansen, Sample splitting and threshold estimation, Econometrica 68 (2000) 575, table I: 95 %).
"""

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

QUANTILE = 7.35
SIDE = 25
"""Moments that are tried on either side, each about half as far again as the one before."""


def moment_interval(candidate: Effect, shape: Nonlinear, ground: Ground, baseline: Nominal, base: Float) -> Coefficient:
    """Tell how well the moment of a shape is known, on all rows.

    Args:
        candidate: The effect.
        shape: The shape that was found.
        ground: The joint.
        baseline: What columns may lean on.
        base: All other columns of the model on the rows, shape (m, b).
    """
    name, t, value = candidate.moment, ground.rows.t, shape[candidate.moment]
    away = np.geomspace(float(np.median(np.diff(t))), float(t[-1] - t[0]), SIDE)
    moments = np.clip(np.concatenate([value - away[::-1], [value], value + away]), t[0], t[-1])
    beside, left = Beside(base, ground.y), np.zeros(len(moments))
    tried = [{**shape, name: float(moment)} for moment in moments]
    for place, columns in candidate.regressors(ground.data, baseline, tried):
        left[place] = beside.fit(ground.rows.of(columns))[1]
    own = ground.rows.of(candidate.regressor(ground.data, baseline, shape))
    worth = len(ground.y) / ground.memory(base, own)
    kept = np.flatnonzero(left <= left.min() * np.exp(QUANTILE / worth))
    low, high = moments[max(kept[0] - 1, 0)], moments[min(kept[-1] + 1, len(moments) - 1)]
    return Coefficient(value=value, low=float(min(low, value)), high=float(max(high, value)))
