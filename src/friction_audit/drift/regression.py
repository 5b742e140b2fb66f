"""A model of the drift of one coefficient, fitted: weights with the scatter between sessions, Huber's loss."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.session import NORMAL_95, Series, Session
from friction_audit.drift.shapes import base_shapes, ramp_shapes, residual_scatter, robust_weight
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


STRONG_EVIDENCE = 6.0
"""Difference of the information criteria from which one model is said to describe better (Kass and Raftery 1995)."""

PLACE_AND_SIZE = 2
"""What a step is free to choose; a ramp chooses its size."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Model:
    """Columns of a model and what is asked of it.

    Attributes:
        columns: Levels and slope first, the temperature last where it is used, shape (n, p).
        level: Combination that is the reference's level, shape (p,).
        change: Combination that is the change from the reference to the last sessions, shape (p,).
        free: What the model chose for itself.
    """

    columns: Float
    level: Float
    change: Float
    free: int


def steps_model(series: Series, places: Sequence[int], reference: Collection[int]) -> Model:
    """Return a level for each segment."""
    segment = np.searchsorted(np.asarray(places), np.arange(len(series.y)), side="right")
    return _levels(series, segment, reference, free=PLACE_AND_SIZE * len(places))


def ends_model(series: Series, reference: Collection[int]) -> Model:
    """Return a level for the reference, for as many last sessions, and for the others."""
    inside = np.isin(series.session, list(reference))
    later = np.flatnonzero(~inside)[-max(int(np.count_nonzero(inside)), 1) :]
    segment = np.where(inside, 0, 1)
    segment[later] = 2
    return _levels(series, np.unique(segment, return_inverse=True)[1], reference, free=0)


def _levels(series: Series, segment: NDArray[np.int64], reference: Collection[int], free: int) -> Model:
    levels = (segment[:, None] == np.arange(int(np.max(segment)) + 1)[None, :]).astype(float)
    return _ask(series, levels, reference, free)


def ramp_model(series: Series, reference: Collection[int]) -> Model:
    """Return a straight change, over the sessions or over the days, whichever describes better."""
    ramps = ramp_shapes(series)
    models = [_ask(series, np.column_stack([np.ones(len(series.y)), ramp]), reference, 1) for ramp in ramps.T]
    return min(models, key=lambda model: criterion(series, model))


def _ask(series: Series, columns: Float, reference: Collection[int], free: int) -> Model:
    inside = np.isin(series.session, list(reference))
    level = np.mean(columns[inside], axis=0) if np.any(inside) else columns[0]
    change = columns[-1] - level
    if series.temperature is not None:
        warmth = series.temperature - np.mean(series.temperature)
        columns = np.column_stack([columns, warmth])
        level, change = np.append(level, 0.0), np.append(change, 0.0)
    return Model(columns=columns, level=level, change=change, free=free)


def criterion(series: Series, model: Model) -> float:
    """Return the information criterion (Schwarz 1978) of a model, without what all models share."""
    weight = robust_weight(series)
    design, y = model.columns * weight[:, None], (series.y - np.mean(series.y)) * weight
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    n = len(y)
    return n * float(np.log(np.sum(left**2) / n + 1e-12)) + model.free * float(np.log(n))


def tell_apart(steps: float, ramp: float, count: int) -> str:
    """Return the shape that the criteria of steps and a ramp speak for."""
    if steps <= ramp - STRONG_EVIDENCE:
        return "step" if count == 1 else "steps"
    return "ramp" if ramp <= steps - STRONG_EVIDENCE else "step_or_ramp"


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


ROUNDS = 4
"""Mean and scatter in turns; they settle at once."""


def change_within(sessions: Sequence[Session], joint: int, coefficient: str) -> Coefficient:
    """Return the relative change of a coefficient within a session, the mean over the sessions that tell it.

    A random-effects mean with the interval of Hartung and Knapp (2001), never narrower than the sessions' own allow.
    """
    from scipy.stats import t

    told = [
        summary.within[coefficient]
        for session in sessions
        for summary in session.joints
        if summary.joint == joint and coefficient in summary.within
    ]
    rows = np.array(
        [(c.value, c.low, c.high) for c in told if np.isfinite(c.value + c.low + c.high) and c.high > c.low]
    )
    if not len(rows):
        return UNDETERMINED
    if len(rows) == 1:
        return Coefficient(value=float(rows[0, 0]), low=float(rows[0, 1]), high=float(rows[0, 2]))
    error, freedom = (rows[:, 2] - rows[:, 1]) / (2 * NORMAL_95), len(rows) - 1
    scatter = 0.0
    for _ in range(ROUNDS):
        weight = 1.0 / (error**2 + scatter**2)
        mean = float(np.average(rows[:, 0], weights=weight))
        scatter = residual_scatter(rows[:, 0] - mean, error, freedom)
    spread = float(np.sum(weight * (rows[:, 0] - mean) ** 2)) / freedom
    half = float(t.ppf(0.975, freedom)) * float(np.sqrt(max(spread, 1.0) / np.sum(weight)))
    return Coefficient(value=mean, low=mean - half, high=mean + half)
