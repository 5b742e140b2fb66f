"""The smallest drift that so many sessions would have shown."""

import math

import numpy as np

from friction_audit.drift.family import statistic_of
from friction_audit.drift.fit import Fit
from friction_audit.drift.series import Series
from friction_audit.drift.shapes import base_shapes, orthogonal, ramp_shapes

FAR = 30.0
"""Beyond it the noise of the numerator of t does not count beside that of its denominator."""


def smallest_change(series: Series, fit: Fit, *, critical: float, growth: float, power: float) -> float:
    """Return the straight change of y, start to end, that the test of the arm finds with the power asked for.

    A step of that size near the middle is found more often, one near either end less often.

    Args:
        series: All of its sessions count.
        fit: For the scatter between sessions.
        critical: Score that the test of the arm asks for.
        growth: By how much autocorrelation makes statistics larger.
        power: Probability to find it.
    """
    weight = 1.0 / (np.sqrt(series.y_error**2 + fit.scatter**2) * max(fit.scale, 1.0))
    ramp = orthogonal(
        ramp_shapes(series)[:, :1],
        split=np.zeros(1, dtype=np.int64),
        base=base_shapes(series),
        y=series.y,
        weight=weight,
    )
    if ramp.freedom < 1 or ramp.length[0] == 0.0:
        return math.nan
    return noncentrality(statistic_of(critical, ramp.freedom), ramp.freedom, power) * growth / float(ramp.length[0])


def noncentrality(statistic: float, freedom: int, power: float) -> float:
    """Return the shift of a t-statistic that passes a bound with a given probability."""
    from scipy.optimize import brentq
    from scipy.stats import chi2, nct, norm

    if statistic > FAR:
        return statistic * math.sqrt(float(chi2.ppf(power, freedom)) / freedom)

    def lacking(shift: float) -> float:
        return float(nct.sf(statistic, freedom, shift)) - power

    high = statistic + float(norm.ppf(power)) + 1.0
    while lacking(high) < 0.0:
        high *= 1.5
    return float(brentq(lacking, 0.0, high, xtol=1e-6))
