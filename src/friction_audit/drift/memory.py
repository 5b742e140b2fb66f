"""Autocorrelation of the scatter: sessions in a row that err together look like drift."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.drift.shapes import Directions, studentise
from friction_audit.joint_log import Float

LEARNED = 300
"""Random series that tell what the search for drift leaves of an autocorrelation."""

GRID = (0.0, 0.2, 0.4, 0.6, 0.75, 0.9)
"""Autocorrelations that it is learned for."""

LAGS = 0.8
"""So many times the square root of the number of sessions: the autocorrelations that are added up."""

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


def find_memory(family: Sequence[Directions], nulls: Sequence[Float], rng: np.random.Generator) -> Memory:
    """Estimate the autocorrelation around the best shape of each series, the median over the series.

    The search for the best shape takes autocorrelation away, the more the fewer sessions there are. How much is learned
    from random series that went through the same search (indirect inference, Gourieroux et al. 1993).

    Args:
        family: The directions of each series.
        nulls: Its residuals in random orders, shape (orders, n) each.
        rng: For the random series.
    """
    found = np.median([_beyond(directions, null) for directions, null in zip(family, nulls, strict=True)])
    widest = max(family, key=lambda directions: len(directions.residual))
    left, largest = zip(*(_learn(widest, correlation, rng) for correlation in GRID), strict=True)
    rising = np.maximum.accumulate(np.array(left) - left[0])
    correlation = float(np.interp(found, rising, GRID))
    growth = float(np.interp(correlation, GRID, np.maximum.accumulate(np.array(largest) / largest[0])))
    return Memory(correlation=correlation, growth=growth)


def _beyond(directions: Directions, null: Float) -> float:
    real = summed_autocorrelation(directions.residual[None, :], directions)[0]
    return float(real - np.mean(summed_autocorrelation(null[:LEARNED], directions)))


def _learn(directions: Directions, correlation: float, rng: np.random.Generator) -> tuple[float, float]:
    """Return the mean summed autocorrelation that is left and the largest statistic, at its quantile."""
    from scipy.signal import lfilter

    noise = rng.standard_normal((LEARNED, len(directions.residual)))
    noise[:, 1:] *= np.sqrt(1.0 - correlation**2)
    series = np.asarray(lfilter([1.0], [1.0, -correlation], noise, axis=1), dtype=float)
    largest = np.max(np.abs(studentise(series, directions)), axis=1)
    return float(np.mean(summed_autocorrelation(series, directions))), float(np.quantile(largest, QUANTILE))


def summed_autocorrelation(residual: Float, directions: Directions) -> Float:
    """Return the sum of the autocorrelations (Bartlett's weights) around the best direction, shape (orders,)."""
    left = residual - (residual @ directions.base) @ directions.base.T
    along = left @ directions.direction
    best = np.argmax(np.abs(along), axis=1)
    left = left - along[np.arange(len(left)), best][:, None] * directions.direction[:, best].T
    square = np.sum(left**2, axis=1)
    lags = max(1, round(LAGS * np.sqrt(left.shape[1])))
    total = sum(
        (1.0 - lag / (lags + 1.0)) * np.sum(left[:, lag:] * left[:, :-lag], axis=1) for lag in range(1, lags + 1)
    )
    return np.asarray(np.divide(total, square, out=np.zeros(len(left)), where=square > 0), dtype=float)
