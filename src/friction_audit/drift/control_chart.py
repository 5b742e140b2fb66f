"""Control chart: every session against the reference."""

from collections.abc import Collection

import numpy as np

from friction_audit.drift.fit import Fit, is_near_zero
from friction_audit.drift.report import ControlPoint
from friction_audit.drift.series import Series
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float


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
    bound = float(t.isf(alpha / (2.0 * len(y)), fit.freedom))
    half = bound * np.sqrt(np.maximum(spread, 0.0))
    outside = (np.abs(y - mean) > half) & (half > 0.0)
    return tuple(
        _point(int(index), float(off), float(limit), level, logarithmic=series.logarithmic, outside=bool(out))
        for index, off, limit, out in zip(series.session, y - mean, half, outside, strict=True)
    )


def _point(
    session: int, off: float, half: float, level: Coefficient, *, logarithmic: bool, outside: bool
) -> ControlPoint:
    ends = (off, -half, half)
    if logarithmic:
        relative = Coefficient(**_named(np.expm1(ends)))
        deviation = Coefficient(**_named(level.value * np.expm1(ends)))
    else:
        deviation = Coefficient(**_named(np.array(ends)))
        size = abs(level.value)
        relative = UNDETERMINED if is_near_zero(level) else Coefficient(**_named(np.array(ends) / size))
    return ControlPoint(session=session, deviation=deviation, relative=relative, outside=outside)


def _named(ends: Float) -> dict[str, float]:
    return dict(zip(("value", "low", "high"), (float(end) for end in ends), strict=True))
