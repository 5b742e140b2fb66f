"""Control chart: every session against the reference; and the smallest change that the sessions can show."""

import math
from collections.abc import Collection

import numpy as np

from friction_audit.drift.change_test import orthogonal
from friction_audit.drift.regression import Fit, baseline_columns, is_near_zero, ramp_columns, relative_size
from friction_audit.drift.report import ControlPoint
from friction_audit.drift.session import Series
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

FAR = 30.0  # beyond it the noise of the numerator of t is negligible against that of its denominator


def make_chart(
    series: Series, y: Float, fit: Fit, level: Coefficient, reference: Collection[int], alpha: float
) -> tuple[ControlPoint, ...]:
    """Compare each session with the mean of the reference; limits hold for all sessions together.

    The limits are those of a new session: its own error, the scatter between sessions around the drift, and the error
    of the reference's mean.

    Args:
        series: With isolated sessions, n in all.
        y: At like temperature, shape (n,).
        fit: Model of the drift, for the scatter.
        level: The reference's level, unit of the coefficient.
        reference: Indices of its sessions among all of the arm.
        alpha: Probability that any session lies outside where nothing changes.
    """
    from scipy.stats import t

    inside = np.isin(series.session, list(reference)) & series.kept
    if not np.any(inside) or fit.freedom < 1:
        return ()
    variance = (series.y_error**2 + fit.scatter**2) * max(1.0, fit.scale) ** 2
    weight = np.where(inside, 1.0 / variance, 0.0)
    mean, mean_variance = float(np.average(y, weights=weight)), float(1.0 / np.sum(weight))
    spread = variance + np.where(inside, -mean_variance, mean_variance)
    half = float(t.isf(alpha / (2.0 * len(y)), fit.freedom)) * np.sqrt(np.maximum(spread, 0.0))
    outside = (np.abs(y - mean) > half) & (half > 0.0)
    ends = np.column_stack([y - mean, -half, half])
    if series.logarithmic:
        relative = _coefficients(relative_size(ends))
        deviation = _coefficients(level.value * relative_size(ends))
    else:
        deviation = _coefficients(ends)
        relative = [UNDETERMINED] * len(ends) if is_near_zero(level) else _coefficients(ends / abs(level.value))
    rows = zip(series.session.tolist(), deviation, relative, outside.tolist(), strict=True)
    return tuple(ControlPoint(session=i, deviation=d, relative=r, outside=out) for i, d, r, out in rows)


def _coefficients(rows: Float) -> list[Coefficient]:
    return [Coefficient(value=value, low=low, high=high) for value, low, high in rows.tolist()]


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
    from scipy.stats import t

    start = np.zeros(1, dtype=np.int64)
    ramp = orthogonal(
        ramp_columns(series)[:, :1],
        split=start,
        back=start + len(series.y),
        base=baseline_columns(series),
        y=series.y,
        weight=1.0 / (np.sqrt(series.y_error**2 + fit.scatter**2) * max(fit.scale, 1.0)),
    )
    if ramp.freedom < 1 or ramp.length[0] == 0.0:
        return math.nan
    statistic = float(t.isf(np.exp(-critical), ramp.freedom))
    return noncentrality(statistic, ramp.freedom, power) * growth / float(ramp.length[0])


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
