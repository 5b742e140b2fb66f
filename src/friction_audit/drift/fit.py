"""A model of the drift of one coefficient, fitted: weights with the scatter between sessions, Huber's loss."""

from dataclasses import dataclass

import numpy as np

from friction_audit.drift.scatter import residual_scatter
from friction_audit.drift.series import Series
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

CONFIDENCE = 0.95

FEWEST_FOR_HUBER = 8
"""Fewer sessions do not tell an outlier from the others: plain weighted least squares."""

EXACT = 1e-6
"""Residuals so far below their errors are those of a made-up series; they have no outliers."""

ROUNDING = 1e-13
"""Residuals of so much of the values are rounding, however small the errors are stated."""

NEAR_ZERO = 2.0
"""Half intervals of the reference's level; a level that is not larger has no relative change."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Fit:
    """A linear model of y over the sessions.

    Attributes:
        value: Coefficients of the model, shape (p,).
        covariance: Of them, autocorrelation included, shape (p, p).
        freedom: Sessions minus parameters.
        scatter: Standard deviation between sessions beyond the errors of the estimates.
        scale: What the whitened residuals' standard deviation is; 1 if errors and scatter are right.
    """

    value: Float
    covariance: Float
    freedom: int
    scatter: float
    scale: float

    def contrast(self, weights: Float) -> tuple[float, float]:
        """Return a combination of the coefficients and its standard error."""
        return float(weights @ self.value), float(np.sqrt(np.maximum(weights @ self.covariance @ weights, 0.0)))

    def interval(self, weights: Float) -> Coefficient:
        """Return a combination of the coefficients with its 95 % interval."""
        from scipy.stats import t

        value, error = self.contrast(weights)
        half = float(t.ppf(0.5 + CONFIDENCE / 2, self.freedom)) * error if self.freedom > 0 else float("nan")
        return Coefficient(value=value, low=value - half, high=value + half)


def fit_model(series: Series, shapes: Float, inflation: float = 1.0) -> Fit:
    """Fit y of the sessions that count by columns.

    Args:
        series: All of its sessions count, n of them.
        shapes: Columns of the model, level and temperature included, shape (n, p).
        inflation: Variance of a mean over that of independent sessions.
    """
    from statsmodels.robust.norms import HuberT
    from statsmodels.robust.robust_linear_model import RLM  # the whole of statsmodels.api takes longer to load

    freedom = len(series.y) - shapes.shape[1]
    scatter = _scatter(series, shapes, freedom)
    weight = 1.0 / np.sqrt(series.y_error**2 + scatter**2)
    design, whitened = shapes * weight[:, None], series.y * weight
    plain = np.linalg.lstsq(design, whitened, rcond=None)[0]
    left = whitened - design @ plain
    scale = float(np.sqrt(np.sum(left**2) / freedom)) if freedom > 0 else 1.0
    if freedom < FEWEST_FOR_HUBER or scale < max(EXACT, ROUNDING * float(np.abs(whitened).max())):
        value, spread = plain, np.linalg.pinv(design.T @ design) * max(1.0, scale) ** 2
    else:
        found = RLM(whitened, design, M=HuberT()).fit()
        value, spread = found.params, found.bcov_scaled * max(1.0, 1.0 / max(found.scale, 1e-3)) ** 2
    return Fit(
        value=np.asarray(value),
        covariance=np.asarray(spread) * inflation,
        freedom=freedom,
        scatter=scatter,
        scale=scale,
    )


def _scatter(series: Series, shapes: Float, freedom: int) -> float:
    """Return the scatter around the model: Paule and Mandel's, the weights and the residuals in turns."""
    scatter = 0.0
    for _ in range(4):
        weight = 1.0 / np.sqrt(series.y_error**2 + scatter**2)
        value = np.linalg.lstsq(shapes * weight[:, None], series.y * weight, rcond=None)[0]
        scatter = residual_scatter(series.y - shapes @ value, series.y_error, freedom)
    return scatter


def relative_size(y: Float | float) -> Float:
    """Return the relative change that a change of a logarithm is; infinite (no limit) beyond all numbers."""
    with np.errstate(over="ignore"):
        return np.asarray(np.expm1(y), dtype=float)


def to_level(y: Coefficient, series: Series) -> Coefficient:
    """Return a level of y in the unit of the coefficient."""
    if not series.logarithmic:
        return y
    with np.errstate(over="ignore"):
        return Coefficient(value=float(np.exp(y.value)), low=float(np.exp(y.low)), high=float(np.exp(y.high)))


def to_relative(change: Coefficient, level: Coefficient, series: Series) -> Coefficient:
    """Return a change of y over the level; NaN where the level is near zero."""
    if series.logarithmic:
        ends = (float(relative_size(end)) for end in (change.value, change.low, change.high))
        return Coefficient(**dict(zip(("value", "low", "high"), ends, strict=True)))
    if is_near_zero(level):
        return UNDETERMINED
    size = abs(level.value)
    return Coefficient(value=change.value / size, low=change.low / size, high=change.high / size)


def to_change(change: Coefficient, level: Coefficient, series: Series) -> Coefficient:
    """Return a change of y in the unit of the coefficient."""
    if not series.logarithmic:
        return change
    ends = (level.value * float(relative_size(end)) for end in (change.value, change.low, change.high))
    return Coefficient(**dict(zip(("value", "low", "high"), ends, strict=True)))


def is_near_zero(level: Coefficient) -> bool:
    """Return whether a level is so uncertain that a change over it means nothing."""
    half = (level.high - level.low) / 2
    return not abs(level.value) > NEAR_ZERO * half
