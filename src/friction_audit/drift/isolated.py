"""Isolated sessions: an estimate that fits neither its neighbours nor the change that the others show is no drift."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.scatter import steps_scatter
from friction_audit.drift.series import Series
from friction_audit.drift.shapes import make_directions
from friction_audit.joint_log import Float

REACH = 2
"""So many sessions on each side are asked."""

FAR = 5.0
"""Standard deviations of a difference of two sessions."""

FEWEST = 5
"""With fewer sessions nobody can tell which one is the odd one."""

ODD = 0.01
"""Probability that a series of normal scatter has a session set aside (Bonferroni over the sessions)."""

FEWEST_FOR_SHAPES = 12
"""With fewer sessions a change of the others is not known well enough to say which session misses it: with 8, 15 % of
arms where nothing changes had a false change, without it 5 % (`benchmarks/drift/summaries.md`, "8 sessions")."""

SHARE_ODD = 10
"""At most one session in so many is set aside by ``leave_odd_out``: more of them are no exception."""

ALIKE = 0.5
"""A session whose neighbour in time is off by at least this share of the same deviation is not alone."""


def find_isolated(y: Float, error: Float) -> NDArray[np.bool_]:
    """Find the sessions that differ from both neighbours on each side by far more than neighbours use to.

    A step has alike sessions on both of its sides, a ramp has neighbours on either side: neither is isolated. The
    first and the last session may be: one session after a step is told from a broken estimate by the next one.

    Args:
        y: Estimates in the order of the sessions, shape (n,).
        error: Their standard errors, shape (n,).
    """
    n = len(y)
    if n < FEWEST:
        return np.zeros(n, dtype=np.bool_)
    variance = error**2 + steps_scatter(y, error) ** 2
    near = np.zeros(n, dtype=np.bool_)
    for lag in range(1, REACH + 1):
        close = np.abs(y[lag:] - y[:-lag]) <= FAR * np.sqrt(variance[lag:] + variance[:-lag])
        near[lag:] |= close
        near[:-lag] |= close
    return ~near


def leave_odd_out(series: Series) -> Series:
    """Set the sessions aside that miss the change which all others show, at the ends of the series too."""
    while (odd := _most_odd(series.counted())) is not None:
        places = np.flatnonzero(series.kept)
        series = replace(series, kept=series.kept & (np.arange(len(series.kept)) != places[odd]))
        if np.count_nonzero(~series.kept) >= len(series.kept) // SHARE_ODD:
            break
    return series


def _most_odd(series: Series) -> int | None:
    """Return the place of the session with the largest externally studentised residual, or None if none is an outlier.

    The residual is taken around every step and ramp that describes the other sessions about as well as the best one
    does (profile likelihood, 95 %); the smallest counts. Sessions in a row that are off alike are a change.
    """
    from scipy.stats import f, t

    n = len(series.y)
    if n < FEWEST_FOR_SHAPES:
        return None
    found = make_directions(series)
    freedom = found.freedom - 1  # one session less
    direction = found.direction[:, ~found.episodes]
    left = found.residual[:, None] - direction * (found.residual @ direction)
    free = 1.0 - np.sum(found.base**2, axis=1)[:, None] - direction**2
    without = np.sum(left**2, axis=0) - left**2 / free  # squares that remain without the session
    if freedom < 1 or not np.min(without) > 0.0:
        return None
    allowed = without <= np.min(without, axis=1, keepdims=True) * (1.0 + float(f.ppf(0.95, 1, freedom)) / freedom)
    size = np.where(allowed, np.abs(left) / np.sqrt(free * without / freedom), np.inf)
    odd = int(np.argmax(np.min(size, axis=1)))
    shape = int(np.argmin(size[odd]))
    beside = [left[i, shape] / left[odd, shape] for i in (odd - 1, odd + 1) if 0 <= i < n]
    alone = max(beside) < ALIKE
    return odd if alone and size[odd, shape] > float(t.isf(ODD / (2 * n), freedom)) else None
