"""Trend: a straight, robust slope over the sessions and over the days."""

from dataclasses import dataclass

import numpy as np

from friction_audit.drift.fit import Fit, fit_model, to_level
from friction_audit.drift.series import Series
from friction_audit.drift.shapes import base_shapes
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

COLLINEAR = 1e4
"""Condition number beyond which a slope over the sessions cannot be told from one over the temperature."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Trend:
    """Slopes, unit of the coefficient.

    Attributes:
        per_session: Per session.
        per_day: Per day; NaN where starts are not known.
    """

    per_session: Coefficient
    per_day: Coefficient


def find_trend(series: Series, inflation: float) -> Trend:
    """Fit the slopes, temperature beside them.

    Args:
        series: All of its sessions count.
        inflation: Variance of a mean over that of independent sessions.
    """
    per_day = UNDETERMINED if series.day is None else _slope(series, series.day, inflation)
    return Trend(per_session=_slope(series, series.place, inflation), per_day=per_day)


def _slope(series: Series, clock: Float, inflation: float) -> Coefficient:
    base = base_shapes(series)
    shapes = np.column_stack([base, clock - np.mean(clock)])
    if (
        len(clock) <= shapes.shape[1]
        or np.linalg.cond(shapes / np.linalg.norm(shapes, axis=0).clip(1e-300)) > COLLINEAR
    ):
        return UNDETERMINED
    fit = fit_model(series, shapes, inflation)
    slope = fit.interval(_unit(shapes.shape[1], shapes.shape[1] - 1))
    if not series.logarithmic:
        return slope
    level = to_level(fit.interval(_unit(shapes.shape[1], 0)), series).value
    return Coefficient(value=level * slope.value, low=level * slope.low, high=level * slope.high)


def temperature_slope(fit: Fit, series: Series, level: float) -> Coefficient:
    """Return the relative change per degree of a fit with the temperature in its last column; NaN without one."""
    if series.temperature is None:
        return UNDETERMINED
    slope = fit.interval(_unit(len(fit.value), len(fit.value) - 1))
    over = 1.0 if series.logarithmic else level
    low, high = sorted((slope.low / over, slope.high / over)) if over else (np.nan, np.nan)
    return Coefficient(value=slope.value / over if over else np.nan, low=low, high=high)


def _unit(length: int, place: int) -> Float:
    return np.asarray(np.eye(length)[place])
