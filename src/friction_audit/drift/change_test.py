"""The test of an arm: does any coefficient of any joint change over the sessions?

Every coefficient is tested along a step at each session, changes that come and go, and a ramp; the largest studentised
statistic counts. Its distribution without drift comes from the same sessions in random orders, the same for all joints,
and the step-down maximum over the coefficients (Westfall and Young 1993) keeps the probability of any false change.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from friction_audit.drift.regression import MAD_TO_SD, baseline_columns, ramp_columns, robust_weight
from friction_audit.drift.report import DriftSettings
from friction_audit.drift.session import Series
from friction_audit.joint_log import Float, Int

SHORTEST_SEGMENT = 2  # sessions before and after a step
MOST_STEPS = 80  # places of a step that are tried; more cost time, and neighbours give nearly the same
SHORTEST_EPISODE = 10  # sessions of a change that comes and goes: shorter ones resemble autocorrelated scatter
MOST_PLACES = 32  # places of a step that are paired to changes that come and go
EPISODE_FACTOR = 0.7  # on the statistic of such a change: they are many, and must not hide the single steps
COLLINEAR = 1e-6  # a direction with a smaller part of its square left given the temperature is none
ROUNDING = 1e-4  # if no session is off by this share of its error, only the last digits change

# Of fewer sessions no order is rare enough, and they do not determine an autocorrelation: normal scatter is assumed.
FEWEST_TO_PERMUTE = 12
AT_ONCE = 250_000  # sessions times orders that are held in memory

LEARNED = 1000  # random series for each autocorrelation
LEARNED_SESSIONS = 200_000  # sessions of them that are enough where series are long
GRID = (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)  # autocorrelations that are simulated
LAGS = (1, 2, 3)  # what wanders slowly shows beyond the next session
CUT = 2.5  # robust standard deviations that a session counts at most: a broken estimate has no neighbours
PLAIN = 0.95  # a smaller autocorrelation than this share of series without any show by chance widens no interval
CAUTION = 0.16  # probability that the autocorrelation is larger than the upper limit, one standard error away
QUANTILE = 0.99  # of the largest statistic, about where the test of an arm decides


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Directions:
    """What the tests look along, whitened: every session's error is 1."""

    split: Int  # first session after the step, shape (k,); 0 for a ramp
    back: Int  # first session after the step back, shape (k,); n where there is none
    direction: Float  # unit vectors, orthogonal to level and temperature, shape (n, k); 0 where nothing is left of one
    base: Float  # orthonormal basis of level and temperature, shape (n, b)
    residual: Float  # what level and temperature leave of y, shape (n,)
    weight: Float  # one over the standard error with scatter, shape (n,)
    ramp: Float  # ramps as they are, shape (n, r); the last r of the directions
    factor: Float  # on the statistic of each direction, below 1 for changes that come and go, shape (k,)
    freedom: int  # degrees of freedom given level, temperature and one direction

    def studentised(self, along: Float, square: Float) -> Float:
        """Return t of each direction, from the projections (m, k) and squared lengths of the series (m, 1)."""
        rest = np.maximum(square - along**2, 1e-12 * square + 1e-300)
        return np.asarray(along * self.factor * np.sqrt(max(self.freedom, 1) / rest), dtype=float)


def make_directions(series: Series) -> Directions:
    """Return the directions of change for at least three sessions, all of which count; steps first."""
    n, ramps = len(series.place), ramp_columns(series)
    steps = step_places(n)
    chosen = steps[np.unique(np.linspace(0, len(steps) - 1, min(len(steps), MOST_PLACES)).astype(np.int64))]
    there, again = chosen[np.array(np.triu_indices(len(chosen), 1))]
    long = again - there >= SHORTEST_EPISODE
    split, back = np.append(steps, there[long]), np.append(np.full(len(steps), n), again[long])
    between = (np.arange(n)[:, None] >= split) & (np.arange(n)[:, None] < back)
    none = np.zeros(ramps.shape[1], dtype=np.int64)
    return orthogonal(
        np.column_stack([between.astype(float), ramps]),
        split=np.append(split, none),
        back=np.append(back, none + n),
        base=baseline_columns(series),
        y=series.y,
        weight=robust_weight(series),
    )


def orthogonal(shapes: Float, *, split: Int, back: Int, base: Float, y: Float, weight: Float) -> Directions:
    """Whiten shapes, base and y, and take the base out of the others."""
    basis, _ = np.linalg.qr(base * weight[:, None])
    whitened = shapes * weight[:, None]
    left = whitened - basis @ (basis.T @ whitened)
    square, whole = np.sum(left**2, axis=0), np.sum(whitened**2, axis=0)
    length = np.where(square > COLLINEAR * whole, np.sqrt(square), 0.0)
    scaled = (y - np.average(y, weights=weight**2)) * weight
    residual = scaled - basis @ (basis.T @ scaled)
    if np.max(np.abs(residual), initial=0.0) < ROUNDING:
        residual = np.zeros_like(residual)
    return Directions(
        split=split,
        back=back,
        direction=np.divide(left, length, out=np.zeros_like(left), where=length > 0),
        base=basis,
        residual=residual,
        weight=weight,
        ramp=shapes[:, split == 0],
        factor=np.where(back < len(y), EPISODE_FACTOR, 1.0),
        freedom=len(y) - basis.shape[1] - 1,
    )


def step_places(sessions: int) -> Int:
    """Return the sessions that a step is tried before, all of them or densely near both ends, shape (k,)."""
    places = np.arange(SHORTEST_SEGMENT, sessions - SHORTEST_SEGMENT + 1)
    if len(places) <= MOST_STEPS:
        return places
    share = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, MOST_STEPS)))
    return places[np.unique(np.round(share * (len(places) - 1)).astype(np.int64))]


def studentise(rows: Float, directions: Directions) -> Float:
    """Return t of each direction for whitened series (m, n), shape (m, k)."""
    square = np.sum(rows**2, axis=1) - np.sum((rows @ directions.base) ** 2, axis=1)
    return directions.studentised(rows @ directions.direction, square[:, None])


def _studentise_orders(directions: Directions, order: Int) -> Float:
    """Return t of each direction with the sessions, and their errors, in other orders (m, n), shape (m, k)."""
    steps = directions.split > 0

    def along(rows: Float, ramp: Float) -> Float:
        before = np.cumsum(np.insert(rows, 0, 0.0, axis=1), axis=1)
        return np.column_stack([before[:, directions.back[steps]] - before[:, directions.split[steps]], rows @ ramp])

    weight = directions.weight[order]
    inner = along(directions.residual[order] * weight, directions.ramp)
    whole = along(weight**2, directions.ramp**2)
    square = whole.copy()
    for base in directions.base.T:
        square -= along(base[order] * weight, directions.ramp) ** 2
    length = np.sqrt(np.maximum(square, 0.0))
    unit = np.divide(inner, length, out=np.zeros_like(inner), where=square > COLLINEAR * whole)
    return directions.studentised(unit, np.asarray(np.sum(directions.residual**2)))


class Autocorrelation(NamedTuple):
    """Of the scatter: sessions in a row that err together look like drift."""

    first: float = 0.0  # correlation of one session's scatter with the next one's; 0 where chance would do
    growth: float = 1.0  # how much larger it makes the largest statistic, at its upper limit


def estimate_autocorrelation(family: Sequence[Directions], rng: np.random.Generator) -> Autocorrelation:
    """Estimate the autocorrelation of series that are alike in it: one coefficient of all joints.

    The best single shape of change is taken out of each series; the median over the series counts, so that a joint on
    which more happens does not decide. What level and shape take away with them, and what an autocorrelation does to
    the test, is learned from random series in the same places (indirect inference, Gourieroux et al. 1993).
    """
    long = [directions for directions in family if len(directions.residual) >= FEWEST_TO_PERMUTE]
    if not long:
        return Autocorrelation()
    found = float(np.median([lagged_sum(detrend(own.residual[None, :], own))[0] for own in long]))
    longest = max(long, key=lambda directions: len(directions.residual))
    simulated = [_simulate(longest, correlation, len(long), rng) for correlation in GRID]
    low, middle, high, largest = (np.maximum.accumulate(column) for column in zip(*simulated, strict=True))
    upper = float(np.interp(found, low, GRID))
    return Autocorrelation(
        first=float(np.interp(found, middle, GRID)) if found > high[0] else 0.0,
        growth=float(np.interp(upper, GRID, largest / largest[0])),
    )


def detrend(rows: Float, directions: Directions) -> Float:
    """Return whitened series (m, n) without level, temperature and the best shape of change."""
    rest = rows - (rows @ directions.base) @ directions.base.T
    along = rest @ directions.direction
    best = np.argmax(np.abs(along), axis=1)
    size = np.take_along_axis(along, best[:, None], axis=1)
    return np.asarray(rest - size * directions.direction[:, best].T, dtype=float)


def lagged_sum(rest: Float) -> Float:
    """Return the sum of the autocorrelations of each series (m, n), each over its lag, outliers cut, shape (m,)."""
    most = CUT * MAD_TO_SD * np.median(np.abs(rest), axis=1, keepdims=True)
    cut = np.clip(rest, -most, most)
    square = np.sum(cut**2, axis=1) + 1e-300
    products = [np.sum(cut[:, lag:] * cut[:, :-lag], axis=1) / lag for lag in LAGS]
    return np.asarray(np.sum(products, axis=0) / square, dtype=float)


def _simulate(
    directions: Directions, correlation: float, together: int, rng: np.random.Generator
) -> tuple[float, float, float, float]:
    """Return low, median and high lagged sum over so many series, and a quantile of the largest statistic."""
    from scipy.signal import lfilter

    length = len(directions.residual)
    count = together * -(-min(LEARNED, LEARNED_SESSIONS // length + LEARNED // 10) // together)
    noise = rng.standard_normal((count, length))
    noise[:, 1:] *= np.sqrt(1.0 - correlation**2)
    rows = np.asarray(lfilter([1.0], [1.0, -correlation], noise, axis=1), dtype=float)
    sums = np.median(lagged_sum(detrend(rows, directions)).reshape(-1, together), axis=1)
    low, middle, high = np.quantile(sums, (CAUTION, 0.5, PLAIN))
    largest = np.max(np.abs(studentise(rows, directions)), axis=1)
    return float(low), float(middle), float(high), float(np.quantile(largest, QUANTILE))


class Verdict(NamedTuple):
    """What the test of an arm says of one series."""

    p_value: float  # of the largest statistic, family-wise
    ramp_p_value: float  # of the ramps alone, family-wise
    p_without_temperature: float  # as if no temperature were known; the same as ``p_value`` where none is used
    critical: float  # score that is exceeded without drift with probability alpha, in any series
    scatter: Autocorrelation


def judge_family(family: Sequence[Series], settings: DriftSettings) -> list[Verdict]:
    """Test all series of an arm for drift; all of their sessions count."""
    every = [make_directions(series) for series in family]
    orders, width = settings.permutations, 1 + max(int(np.max(series.place)) for series in family)
    rng = np.random.Generator(np.random.PCG64(settings.seed).advance(orders * width))  # it comes after all keys
    kinds = [series.coefficient for series in family]  # series of one kind scatter alike
    of_kind = {
        kind: estimate_autocorrelation([own for own, its in zip(every, kinds, strict=True) if its == kind], rng)
        for kind in dict.fromkeys(kinds)
    }
    maxima, ramp_maxima = permute(every, [series.place for series in family], rng, width, settings)
    observed, ramp = np.empty(len(family)), np.empty(len(family))
    for k, (directions, kind) in enumerate(zip(every, kinds, strict=True)):
        real, freedom = np.abs(studentise(directions.residual[None, :], directions)), directions.freedom
        growth = of_kind[kind].growth
        observed[k] = score(np.max(real) / growth, freedom)
        ramp[k] = score(np.max(real[:, directions.split == 0], initial=0.0) / growth, freedom)
        maxima[:, k], ramp_maxima[:, k] = score(maxima[:, k], freedom), score(ramp_maxima[:, k], freedom)
    critical = float(np.quantile(np.max(maxima, axis=1), 1.0 - settings.alpha))
    p_values = zip(step_down(observed, maxima).tolist(), step_down(ramp, ramp_maxima).tolist(), kinds, strict=True)
    return [Verdict(p, q, p_without_temperature=p, critical=critical, scatter=of_kind[kind]) for p, q, kind in p_values]


def permute(
    family: Sequence[Directions], places: Sequence[Float], rng: np.random.Generator, width: int, settings: DriftSettings
) -> tuple[Float, Float]:
    """Return the largest statistic without drift in each order, of all shapes and of ramps, shape (orders, s) each."""
    orders = settings.permutations
    largest, largest_ramp = np.empty((2, orders, len(family)))

    def keep(rows: Int, k: int, drawn: Float) -> None:
        largest[rows, k] = np.max(drawn, axis=1)
        largest_ramp[rows, k] = np.max(drawn[:, family[k].split == 0], axis=1, initial=0.0)

    long = [k for k, directions in enumerate(family) if len(directions.residual) >= FEWEST_TO_PERMUTE]
    for k in sorted(set(range(len(family))).difference(long)):
        normal = rng.standard_normal((orders, len(family[k].residual)))
        keep(np.arange(orders), k, np.abs(studentise(normal, family[k])))
    most = max((len(places[k]) for k in long), default=1)
    draw = np.random.default_rng(settings.seed)
    for rows in np.array_split(np.arange(orders), -(-orders * most // AT_ONCE)):  # as many as memory bears
        keys = draw.random((len(rows), width))  # whose order is that of the sessions
        place, order = np.zeros(0), np.zeros((0, 0), dtype=np.int64)
        for k in long:
            if not np.array_equal(places[k], place):  # mostly all series have their sessions in the same places
                place, order = places[k], np.argsort(keys[:, places[k].astype(np.int64)], axis=1)
            keep(rows, k, np.abs(_studentise_orders(family[k], order)))
    return largest, largest_ramp


def score(statistic: Float | float, freedom: int) -> Float:
    """Return minus the logarithm of the probability of |t|, by which series of unlike lengths are compared."""
    from scipy.stats import t

    return -np.asarray(t.logsf(statistic, max(freedom, 1)), dtype=float)


def step_down(observed: Float, null: Float) -> Float:
    """Return family-wise p-values of scores (s,), given those without drift (orders, s), by the step-down maximum."""
    order = np.argsort(-observed, kind="stable")
    maxima = np.maximum.accumulate(null[:, order[::-1]], axis=1)[:, ::-1]
    p = (1.0 + np.sum(maxima >= observed[order], axis=0)) / (1.0 + len(null))
    adjusted = np.empty(len(p))
    adjusted[order] = np.maximum.accumulate(p)
    return adjusted
