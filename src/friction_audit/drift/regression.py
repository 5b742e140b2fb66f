"""Regression of one coefficient over the sessions: a random effect of each session, Huber's loss, robust intervals."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.drift.session import NORMAL_95, Series, Session
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

MAD_TO_SD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
FEWEST_FOR_HUBER = 8  # fewer sessions do not separate an outlier from the others: plain weighted least squares
EXACT = 1e-6  # residuals so far below their errors are those of a made-up series, which has no outliers
ROUNDING = 1e-13  # residuals of this share of the values are rounding, however small the errors are stated
NEAR_ZERO = 2.0  # half intervals; a level that is not larger has no relative change
STRONG_EVIDENCE = 6.0  # difference of information criteria that prefers one model (Kass and Raftery 1995)
PLACE_AND_SIZE = 2  # parameters of a step; a ramp has one, its size
COLLINEAR = 1e4  # condition number beyond which a slope over sessions and one over temperature are confounded
SETTLED = 4  # rounds of mean and scatter in turns; they converge at once


def steps_scatter(y: Float, error: Float) -> float:
    """Return the scatter between sessions beyond their errors (n,), from differences of neighbours."""
    if len(y) <= 1:
        return 0.0
    spread = (MAD_TO_SD * float(np.median(np.abs(np.diff(y))))) ** 2
    own = float(np.median(error[1:] ** 2 + error[:-1] ** 2))  # of the difference it is 2 tau^2 + s_i^2 + s_{i+1}^2
    return float(np.sqrt(max(spread - own, 0.0) / 2))


def residual_scatter(residual: Float, error: Float, freedom: int) -> float:
    """Return tau such that sum r_i^2 / (s_i^2 + tau^2) equals the degrees of freedom (Paule and Mandel 1982), or 0."""
    from scipy.optimize import brentq

    def excess(tau: float) -> float:
        return float(np.sum(residual**2 / (error**2 + tau**2))) - freedom

    if freedom < 1 or excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, float(np.sqrt(np.sum(residual**2) / freedom)) + 1e-300, xtol=1e-12))


def baseline_columns(series: Series) -> Float:
    """Return what is no drift: the level and, where it can be used, the temperature, shape (n, b)."""
    columns = [np.ones(len(series.place))]
    if series.temperature is not None:
        columns.append(series.temperature - np.mean(series.temperature))
    return np.column_stack(columns)


def ramp_columns(series: Series) -> Float:
    """Return straight changes from 0 at the first session to 1 at the last, over sessions and days, shape (n, r)."""
    clocks = [series.place] if series.day is None else [series.place, series.day]
    spans = [(clock - clock[0]) / (clock[-1] - clock[0]) for clock in clocks if clock[-1] > clock[0]]
    return np.column_stack(spans) if spans else np.zeros((len(series.place), 0))


def robust_weight(series: Series) -> Float:
    """Return one over the standard error, the scatter between neighbouring sessions included, shape (n,)."""
    y = series.y
    if series.temperature is not None:
        base = baseline_columns(series)
        y = y - base @ np.linalg.lstsq(base, y, rcond=None)[0]
    return 1.0 / np.sqrt(series.y_error**2 + steps_scatter(y, series.y_error) ** 2)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Fit:
    """A linear model of y over the sessions."""

    value: Float  # coefficients of the model, shape (p,)
    covariance: Float  # of them, autocorrelation included, shape (p, p)
    freedom: int  # sessions minus parameters
    scatter: float  # standard deviation between sessions beyond the errors of the estimates
    scale: float  # standard deviation of the whitened residuals; 1 if errors and scatter are right

    def interval(self, weights: Float) -> Coefficient:
        """Return a combination of the coefficients with its 95 % interval."""
        from scipy.stats import t

        value, quantile = float(weights @ self.value), float(t.ppf(0.975, self.freedom or np.nan))
        half = quantile * float(np.sqrt(np.maximum(weights @ self.covariance @ weights, 0.0)))
        return Coefficient.around(value, half)

    def p_value(self, weights: Float) -> float:
        """Return the p-value of a combination: at most 5 % where its interval excludes zero."""
        from scipy.stats import t

        variance = float(np.maximum(weights @ self.covariance @ weights, 1e-300))
        return 2.0 * float(t.sf(abs(weights @ self.value) / variance**0.5, self.freedom or np.nan))


def fit_model(series: Series, columns: Float, inflation: float = 1.0) -> Fit:
    """Fit y by columns (n, p); ``inflation`` is the variance of a mean over that of independent sessions."""
    from statsmodels.robust.norms import HuberT
    from statsmodels.robust.robust_linear_model import RLM  # the whole of statsmodels.api takes longer to load

    freedom = len(series.y) - columns.shape[1]
    value: Float = np.zeros(columns.shape[1])
    scatter = 0.0
    for turn in range(SETTLED + 1):
        if turn:
            scatter = residual_scatter(series.y - columns @ value, series.y_error, freedom)
        weight = 1.0 / np.sqrt(series.y_error**2 + scatter**2)
        design, whitened = columns * weight[:, None], series.y * weight
        value = np.asarray(np.linalg.lstsq(design, whitened, rcond=None)[0], dtype=float)
    left = whitened - design @ value
    scale = float(np.sqrt(np.sum(left**2) / freedom)) if freedom > 0 else 1.0
    if freedom < FEWEST_FOR_HUBER or scale < max(EXACT, ROUNDING * float(np.abs(whitened).max())):
        covariance = np.linalg.pinv(design.T @ design) * max(1.0, scale) ** 2
    else:
        robust = RLM(whitened, design, M=HuberT()).fit()
        value, covariance = robust.params, robust.bcov_scaled * max(1.0, 1.0 / max(robust.scale, 1e-3)) ** 2
    spread = np.asarray(covariance) * inflation
    return Fit(value=np.asarray(value), covariance=spread, freedom=freedom, scatter=scatter, scale=scale)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Model:
    """Columns of a model of the drift and what is asked of it."""

    columns: Float  # levels and slope first, the temperature last where it is used, shape (n, p)
    level: Float  # combination that is the reference's level, shape (p,)
    change: Float  # combination that is the change from the reference to the last sessions, shape (p,)
    free: int  # parameters that were chosen by the data (places and sizes of steps, size of a ramp)


def ends_model(series: Series, reference: Collection[int]) -> Model:
    """Return a level for the reference, for as many last sessions, and for the others."""
    segment = np.where(np.isin(series.session, list(reference)), 0, 1)
    segment[np.flatnonzero(segment)[-max(int(np.count_nonzero(segment == 0)), 1) :]] = 2
    return make_model(series, (segment[:, None] == np.unique(segment)).astype(float), reference, free=0)


def make_model(series: Series, columns: Float, reference: Collection[int], free: int) -> Model:
    """Return the model of some columns, such as a level per segment, with the temperature last where it is used."""
    inside = np.isin(series.session, list(reference))
    level = np.mean(columns[inside], axis=0) if np.any(inside) else columns[0]
    change, warmth = columns[-1] - level, baseline_columns(series)[:, 1:]
    level, change = (np.append(one, np.zeros(warmth.shape[1])) for one in (level, change))
    return Model(columns=np.column_stack([columns, warmth]), level=level, change=change, free=free)


def criterion(series: Series, model: Model) -> float:
    """Return the information criterion (Schwarz 1978) of a model, without what all models share."""
    weight = robust_weight(series)
    design, y = model.columns * weight[:, None], (series.y - np.mean(series.y)) * weight
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    n = len(y)
    return n * float(np.log(np.sum(left**2) / n + 1e-12)) + model.free * float(np.log(n))


def slope_over(series: Series, clock: Float | None, inflation: float) -> Coefficient:
    """Return the slope of the coefficient over a clock (n,), the temperature in the model; NaN where it has none."""
    if clock is None:
        return UNDETERMINED
    columns = np.column_stack([baseline_columns(series), clock - np.mean(clock)])
    unit = columns / np.linalg.norm(columns, axis=0).clip(1e-300)
    if len(clock) <= columns.shape[1] or np.linalg.cond(unit) > COLLINEAR:
        return UNDETERMINED
    fit = fit_model(series, columns, inflation)
    first, last = np.eye(columns.shape[1])[[0, -1]]
    level = to_level(fit.interval(first), series).value if series.logarithmic else 1.0
    return fit.interval(last).each(lambda end: level * end)


def to_level(y: Coefficient, series: Series) -> Coefficient:
    """Return a level of y in the unit of the coefficient."""
    with np.errstate(over="ignore"):
        return y.each(np.exp) if series.logarithmic else y


def to_change(change: Coefficient, level: Coefficient, series: Series) -> tuple[Coefficient, Coefficient]:
    """Return a change of y in the unit of the coefficient, and over the level: NaN where the level is near zero."""
    if series.logarithmic:
        with np.errstate(over="ignore"):  # infinite, no limit, beyond all numbers
            relative = change.each(np.expm1)
        return relative.each(lambda end: level.value * end), relative
    return change, UNDETERMINED if is_near_zero(level) else change.each(lambda end: end / abs(level.value))


def relative_change(first: Coefficient, last: Coefficient) -> Coefficient:
    """Return (last - first) / first, of a first one surely above zero, with its interval by Fieller's theorem."""
    (f, off), (g, far) = ((one.value, one.high - one.value) for one in (first, last))
    middle, half, square = f * g, float(np.sqrt(f**2 * far**2 + g**2 * off**2 - off**2 * far**2)), f**2 - off**2
    return Coefficient(value=g / f - 1.0, low=(middle - half) / square - 1.0, high=(middle + half) / square - 1.0)


def is_near_zero(level: Coefficient) -> bool:
    """Return whether a level is so uncertain that a change over it means nothing."""
    return not abs(level.value) > NEAR_ZERO * (level.high - level.low) / 2


def change_within(sessions: Sequence[Session], joint: int, coefficient: str) -> Coefficient:
    """Return the relative change of a coefficient within a session, the random-effects mean of those that have one."""
    from scipy.stats import t

    summaries = [one for session in sessions for one in session.joints if one.joint == joint]
    known = [one.within[coefficient] for one in summaries if coefficient in one.within]
    finite = [c for c in known if np.isfinite(c.value + c.low + c.high) and c.high > c.low]
    if len(finite) <= 1:
        return finite[0] if finite else UNDETERMINED
    value, low, high = np.array([(c.value, c.low, c.high) for c in finite]).T
    mean, variance, _ = random_effects(value, ((high - low) / (2 * NORMAL_95)) ** 2)
    half = float(t.ppf(0.975, len(finite) - 1)) * variance**0.5
    return Coefficient.around(mean, half)


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values adjusted by Holm's procedure."""
    from statsmodels.stats.multitest import multipletests

    return [float(p) for p in multipletests(p_values, method="holm")[1]]


def random_effects(value: Float, variance: Float) -> tuple[float, float, float]:
    """Return the DerSimonian-Laird mean, its variance (Hartung and Knapp's where larger), and that between the values.

    Few values estimate the variance between them poorly; Student's t with k - 1 degrees of freedom allows for that
    (C. Roever, G. Knapp, T. Friede, BMC Medical Research Methodology 15:99, 2015).
    """
    from statsmodels.stats.meta_analysis import combine_effects

    with np.errstate(all="ignore"):  # statsmodels does not cut the variance between the values at zero
        found = combine_effects(value, variance, method_re="dl")
    kind = "re" if found.tau2 > 0.0 else "fe"
    error = max(getattr(found, f"sd_eff_w_{kind}"), getattr(found, f"sd_eff_w_{kind}_hksj"))
    return float(getattr(found, f"mean_effect_{kind}")), float(error**2), max(float(found.tau2), 0.0)
