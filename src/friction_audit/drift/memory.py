"""Autocorrelation of the scatter: sessions in a row that err together look like drift."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.drift.shapes import Directions, studentise
from friction_audit.joint_log import Float

LEARNED = 200
"""Random series that tell what an autocorrelation does."""

GRID = (0.0, 0.2, 0.4, 0.6, 0.75, 0.9)
"""Autocorrelations that it is learned for."""

LAGS = (2, 3, 4)
"""Differences over so many sessions are compared with those of neighbours."""

PLAIN = 0.9
"""Less autocorrelation than so many random orders show by chance is none."""

QUANTILE = 0.95


@dataclass(frozen=True, kw_only=True, slots=True)
class Memory:
    """Autocorrelation of the scatter.

    Attributes:
        correlation: Of one session's scatter with the next one's.
        growth: By how much that makes the largest statistic larger.
    """

    correlation: float
    growth: float

    @property
    def inflation(self) -> float:
        """Variance of a mean of many sessions over that of independent ones."""
        return (1.0 + self.correlation) / (1.0 - self.correlation)


INDEPENDENT = Memory(correlation=0.0, growth=1.0)


def find_memory(family: Sequence[Directions], nulls: Sequence[Float], rng: np.random.Generator) -> Memory:
    """Estimate the autocorrelation of the scatter from how differences grow with the lag, the median over the series.

    Steps are in few of the differences and a ramp is the same in all, so that neither is taken for autocorrelation.
    What it does is learned from random series in the same places (indirect inference, Gourieroux et al. 1993).

    Args:
        family: The directions of each series.
        nulls: Its residuals in random orders, shape (orders, n) each.
        rng: For the random series.
    """
    longest = max(family, key=lambda directions: len(directions.residual))
    if len(longest.residual) <= 2 * max(LAGS):
        return INDEPENDENT
    long = [i for i, directions in enumerate(family) if len(directions.residual) > 2 * max(LAGS)]
    found = float(np.median([growth_with_lag(family[i].residual[None, :])[0] for i in long]))
    chance = np.median([growth_with_lag(nulls[i][:LEARNED]) for i in long], axis=0)
    if found <= float(np.quantile(chance, PLAIN)):
        return INDEPENDENT
    grown, largest = zip(*(_learn(longest, correlation, rng) for correlation in GRID), strict=True)
    correlation = float(np.interp(found, np.maximum.accumulate(grown), GRID))
    growth = float(np.interp(correlation, GRID, np.maximum.accumulate(np.array(largest) / largest[0])))
    return Memory(correlation=correlation, growth=growth)


def growth_with_lag(residual: Float) -> Float:
    """Return the logarithm of the spread of distant differences over that of neighbours', shape (orders,).

    Median absolute deviations; 0 on average without autocorrelation.

    Args:
        residual: Whitened residuals in the order of the sessions, shape (orders, n).
    """
    near = _spread(residual[:, 1:] - residual[:, :-1])
    far = np.mean([np.log(_spread(residual[:, lag:] - residual[:, :-lag])) for lag in LAGS], axis=0)
    return np.asarray(far - np.log(near), dtype=float)


def _spread(difference: Float) -> Float:
    middle = np.median(difference, axis=1, keepdims=True)
    return np.asarray(np.median(np.abs(difference - middle), axis=1) + 1e-12, dtype=float)


def _learn(directions: Directions, correlation: float, rng: np.random.Generator) -> tuple[float, float]:
    """Return the median growth with the lag and the largest statistic, at its quantile."""
    from scipy.signal import lfilter

    noise = rng.standard_normal((LEARNED, len(directions.residual)))
    noise[:, 1:] *= np.sqrt(1.0 - correlation**2)
    series = np.asarray(lfilter([1.0], [1.0, -correlation], noise, axis=1), dtype=float)
    largest = np.max(np.abs(studentise(series, directions)), axis=1)
    return float(np.median(growth_with_lag(series))), float(np.quantile(largest, QUANTILE))
