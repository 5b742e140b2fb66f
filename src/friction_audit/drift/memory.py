"""Autocorrelation of the scatter: sessions in a row that err together look like drift."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.drift.shapes import MAD_TO_SD, Directions, studentise
from friction_audit.joint_log import Float

LEARNED = 1000
"""Random series for each autocorrelation, that tell what it does."""

LEARNED_SESSIONS = 200_000
"""So many sessions of them are enough, where series are long."""

GRID = (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Autocorrelations that it is learned for."""

LAGS = (1, 2, 3)
"""Sessions over which scatter is compared with itself, near ones more: what wanders slowly shows beyond the next."""

FEWEST = 12
"""Fewer sessions do not tell it: what is left of them beside level and shape is autocorrelated by itself."""

CUT = 2.5
"""Robust standard deviations that a session counts at most: a broken estimate says nothing of its neighbours."""

PLAIN = 0.95
"""Less autocorrelation than so many series without any show by chance widens no interval."""

CAUTION = 0.16
"""Probability that the autocorrelation is larger than it is taken for: an upper limit, one standard error away."""

QUANTILE = 0.99
"""Of the largest statistic, about where the test of an arm decides."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Memory:
    """Autocorrelation of the scatter.

    Attributes:
        correlation: Of one session's scatter with the next one's; 0 where chance would do.
        growth: By how much it makes the largest statistic larger, at the upper limit of what it may be.
    """

    correlation: float
    growth: float

    @property
    def inflation(self) -> float:
        """Variance of a mean of many sessions over that of independent ones."""
        return (1.0 + self.correlation) / (1.0 - self.correlation)


INDEPENDENT = Memory(correlation=0.0, growth=1.0)


def find_memory(family: Sequence[Directions], rng: np.random.Generator) -> Memory:
    """Estimate the autocorrelation of series that are alike in it: one coefficient of all joints.

    The best single shape of drift is taken out of each series; the median over the series counts, so that a joint on
    which more happens does not decide. What level and shape take away with them, and what an autocorrelation does to
    the test, is learned from random series in the same places (indirect inference, Gourieroux et al. 1993).

    Args:
        family: The directions of each series.
        rng: For the random series.
    """
    long = [directions for directions in family if len(directions.residual) >= FEWEST]
    if not long:
        return INDEPENDENT
    found = float(np.median([persistence(leftover(own.residual[None, :], own))[0] for own in long]))
    longest = max(long, key=lambda directions: len(directions.residual))
    learned = [_learn(longest, correlation, len(long), rng) for correlation in GRID]
    low, middle, high, largest = (np.maximum.accumulate(column) for column in zip(*learned, strict=True))
    upper = float(np.interp(found, low, GRID))
    return Memory(
        correlation=float(np.interp(found, middle, GRID)) if found > high[0] else 0.0,
        growth=float(np.interp(upper, GRID, largest / largest[0])),
    )


def leftover(series: Float, directions: Directions) -> Float:
    """Return series without level, temperature and the best shape of drift, shape (m, n).

    Args:
        series: Whitened, shape (m, n).
        directions: Of one series of n sessions.
    """
    rest = series - (series @ directions.base) @ directions.base.T
    along = rest @ directions.direction
    best = np.argmax(np.abs(along), axis=1)
    size = np.take_along_axis(along, best[:, None], axis=1)
    return np.asarray(rest - size * directions.direction[:, best].T, dtype=float)


def persistence(rest: Float) -> Float:
    """Return the first autocorrelations of each series, each over its lag, added up, outliers cut, shape (m,).

    Of a long series that forgets at one rate about -log(1 - correlation).

    Args:
        rest: What is left of the series, shape (m, n).
    """
    most = CUT * MAD_TO_SD * np.median(np.abs(rest), axis=1, keepdims=True)
    cut = np.clip(rest, -most, most)
    square = np.sum(cut**2, axis=1) + 1e-300
    products = [np.sum(cut[:, lag:] * cut[:, :-lag], axis=1) / lag for lag in LAGS]
    return np.asarray(np.sum(products, axis=0) / square, dtype=float)


def _learn(
    directions: Directions, correlation: float, together: int, rng: np.random.Generator
) -> tuple[float, float, float, float]:
    """Return what the persistence over so many series is, low, in the middle and high; and the largest statistic."""
    from scipy.signal import lfilter

    length = len(directions.residual)
    count = together * -(-min(LEARNED, LEARNED_SESSIONS // length + LEARNED // 10) // together)
    noise = rng.standard_normal((count, length))
    noise[:, 1:] *= np.sqrt(1.0 - correlation**2)
    series = np.asarray(lfilter([1.0], [1.0, -correlation], noise, axis=1), dtype=float)
    persisting = np.median(persistence(leftover(series, directions)).reshape(-1, together), axis=1)
    low, middle, high = np.quantile(persisting, (CAUTION, 0.5, PLAIN))
    largest = np.max(np.abs(studentise(series, directions)), axis=1)
    return float(low), float(middle), float(high), float(np.quantile(largest, QUANTILE))
