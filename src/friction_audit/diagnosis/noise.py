"""How much a sample of a residual is worth: its memory.

Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473: initial positive sequence.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Index = NDArray[np.int64]
FEWEST_PAIRS = 0.1
"""Lags for which less than this share of the samples has a partner are not looked at."""
LONGEST_MEMORY = 500


def runs_of(used: NDArray[np.bool_], cycle: Index) -> Index:
    """Number the unbroken stretches of used samples of one cycle, -1 elsewhere, shape (n,)."""
    begins = used & (np.append(True, ~used[:-1]) | np.append(True, cycle[1:] != cycle[:-1]))
    return np.where(used, np.cumsum(begins) - 1, -1)


def autocovariance(residual: Float, run: Index, lags: int) -> tuple[Float, Index]:
    """Sum the products of samples of one run, about a mean of zero.

    Args:
        residual: Shape (n,).
        run: From ``runs_of``, shape (n,).
        lags: Largest lag.

    Returns:
        Sums of products and numbers of pairs for lags 0 to ``lags``, shape (lags + 1,) each.
    """
    sums, pairs = np.zeros(lags + 1), np.zeros(lags + 1, np.int64)
    kept = np.where(run >= 0, residual, 0.0)
    for lag in range(min(lags, len(residual) - 1) + 1):
        sums[lag], pairs[lag] = _at_lag(kept, run, lag)
    return sums, pairs


def _at_lag(kept: Float, run: Index, lag: int) -> tuple[float, int]:
    same = (run[lag:] == run[: len(run) - lag]) & (run[lag:] >= 0)
    return float(np.dot(kept[lag:] * same, kept[: len(run) - lag])), int(np.count_nonzero(same))


def integral_time(residual: Float, run: Index) -> float:
    """Samples that are worth one: 1 + 2 sum of the autocorrelations, at least 1 (initial positive sequence).

    Args:
        residual: Shape (n,).
        run: From ``runs_of``, shape (n,).
    """
    _, lengths = np.unique(run[run >= 0], return_counts=True)
    if not len(lengths):
        return 1.0
    kept = np.where(run >= 0, residual, 0.0)
    size, samples = _at_lag(kept, run, 0)
    enough, longest = max(FEWEST_PAIRS * samples, 2), int(min(lengths.max() - 1, LONGEST_MEMORY))
    pair_sums: list[float] = []
    # Two lags after two, no further than they count: most memories end long before the longest.
    for lag in range(0, longest, 2):
        (first, one), (second, other) = _at_lag(kept, run, lag), _at_lag(kept, run, lag + 1)
        if size <= 0.0 or other < enough or (pair := (first / one + second / other) / (size / samples)) <= 0.0:
            break
        pair_sums.append(pair)
    return max(2.0 * float(np.sum(pair_sums)) - 1.0, 1.0)
