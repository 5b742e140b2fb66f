"""Mean or median of a measure over seeds, and how well it is known."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

CONFIDENCE = 0.95


class Interval(NamedTuple):
    """A mean or median and the bounds of its confidence interval; NaN where there are too few values."""

    value: float
    low: float
    high: float


def mean_interval(values: Sequence[float]) -> Interval:
    """Return the mean of independent values and its 95 % interval (Student's t)."""
    from scipy.stats import t

    known = np.array([value for value in values if np.isfinite(value)])
    if not len(known):
        return Interval(np.nan, np.nan, np.nan)
    mean = float(known.mean())
    if len(known) == 1:
        return Interval(mean, np.nan, np.nan)
    half = float(t.ppf(0.5 + CONFIDENCE / 2, len(known) - 1) * known.std(ddof=1) / np.sqrt(len(known)))
    return Interval(mean, mean - half, mean + half)


def median_interval(values: Sequence[float]) -> Interval:
    """Return the median of independent values, the lower of the middle two, and its 95 % interval.

    The bounds are order statistics, so that values may be infinite; six values are the fewest that have them.
    """
    from scipy.stats import binom

    ranked = sorted(values)
    if not ranked:
        return Interval(np.nan, np.nan, np.nan)
    rank = int(binom.ppf((1 - CONFIDENCE) / 2, len(ranked), 0.5))
    low, high = (ranked[rank - 1], ranked[-rank]) if rank else (np.nan, np.nan)
    return Interval(ranked[(len(ranked) - 1) // 2], low, high)
