"""Change points of one series: where the steps are, how many, and which single sessions are outliers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from friction_audit.drift import change_test
from friction_audit.drift.change_test import Directions, make_directions
from friction_audit.drift.regression import baseline_columns, holm, ramp_columns, robust_weight, steps_scatter
from friction_audit.drift.report import FEWEST_SESSIONS, DriftSettings
from friction_audit.drift.session import Series
from friction_audit.joint_log import Bool, Float, Int

MOST_CHANGES = 6
SESSIONS_PER_CHANGE = 5
STEP_TIME_95 = 7.35  # likelihood ratio of the time of a step, 95 % (Hansen 2000, -2 log(1 - sqrt(0.95)))

REACH = 2  # sessions on each side that an isolated one is compared with
FAR = 5.0  # standard deviations of a difference of two sessions
FEWEST = 5  # with fewer sessions the outlier is not determined
ODD = 0.01  # probability that a series of normal scatter has an outlier (Bonferroni over the sessions)
# With 8 sessions 15 % of arms on which nothing changes had a false change, without it 5 % (benchmarks/drift).
FEWEST_FOR_SHAPES = 12
SHARE_ODD = 10  # at most one session in so many is an outlier of a change: more of them are no exception
ALIKE = 0.5  # a session whose neighbour in time is off by this share of the same deviation is not alone


@dataclass(frozen=True, kw_only=True, slots=True)
class Step:
    """A step, by places in a series."""

    place: int  # first session after it
    low: int  # first place that is possible
    high: int  # last one
    p_value: float  # among the steps of this series (Holm)


def find_steps(series: Series, settings: DriftSettings, growth: float = 1.0) -> tuple[Step, ...]:
    """Find the steps of a series that is known to drift: at least one.

    One step more is taken as long as a segment shows one by itself (as in Bai and Perron 1998, l + 1 against l), Holm's
    procedure over the segments; the places are those of the best segmentation of all (dynamic programming).
    """
    y, weight = _at_like_temperature(series), robust_weight(series)
    judged = partial(_judge, y, weight, settings=settings, growth=growth)
    most = max(1, min(MOST_CHANGES, len(y) // SESSIONS_PER_CHANGE))
    places = _settle(y, weight, _segmentation(y, 1))
    for count in range(2, most + 1):
        ends = [0, *places, len(y)]
        alone = [judged(a, b).p_value for a, b in pairwise(ends) if b - a >= FEWEST_SESSIONS]
        if not alone or min(holm(alone)) > settings.alpha:
            break
        places = _settle(y, weight, _segmentation(y, count))
    ends = [0, *places, len(y)]
    steps = [judged(*span) for span in zip(ends, ends[2:], strict=False)]
    adjusted = holm([step.p_value for step in steps])
    return tuple(replace(step, p_value=p) for step, p in zip(steps, adjusted, strict=True))


def _segmentation(y: Float, count: int) -> list[int]:
    """Return the places of so many steps that leave the least squares."""
    from ruptures import KernelCPD

    scaled = (y - np.mean(y)) / (np.std(y) or 1.0)
    search = KernelCPD(kernel="linear", min_size=change_test.SHORTEST_SEGMENT).fit(scaled)
    return [int(end) for end in search.predict(count)[:-1]]


def _at_like_temperature(series: Series) -> Float:
    """Return y without the effect of the temperature, fitted jointly with the best single shape, shape (n,)."""
    if series.temperature is None:
        return series.y
    directions = make_directions(series)
    best = int(np.argmax(np.abs(directions.residual @ directions.direction) * directions.factor))
    split, places = directions.split[best], np.arange(len(series.y))
    between = (places >= split) & (places < directions.back[best])
    shape = ramp_columns(series)[:, 0] if split == 0 else between.astype(float)
    base = baseline_columns(series)
    design = np.column_stack([base, shape]) * directions.weight[:, None]
    slope = np.linalg.lstsq(design, series.y * directions.weight, rcond=None)[0][1]
    return np.asarray(series.y - slope * base[:, 1])


def _settle(y: Float, weight: Float, places: Sequence[int]) -> list[int]:
    """Move each step to its best place between its neighbours, by the errors of the sessions."""
    ends = [0, *places, len(y)]
    for k in range(1, len(places) + 1):
        here = _between(y, weight, ends[k - 1], ends[k + 1])
        ends[k] = ends[k - 1] + int(here.split[np.argmax(np.abs(here.residual @ here.direction))])
    return ends[1:-1]


def _between(y: Float, weight: Float, first: int, last: int) -> Directions:
    n = last - first
    splits = change_test.step_places(n)
    return change_test.orthogonal(
        (np.arange(n)[:, None] >= splits[None, :]).astype(float),
        split=splits,
        back=np.full(len(splits), n),
        base=np.ones((n, 1)),
        y=y[first:last],
        weight=weight[first:last],
    )


def _judge(y: Float, weight: Float, first: int, last: int, *, settings: DriftSettings, growth: float) -> Step:
    """Return the best step with its p-value, by the largest statistic of random orders, and its interval of 95 %."""
    from scipy.stats import chi2, f

    directions, length = _between(y, weight, first, last), last - first
    rng = np.random.Generator(np.random.PCG64(settings.seed).advance(settings.permutations * length))
    drawn, _ = change_test.permute([directions], [np.arange(length, dtype=float)], rng, length, settings)
    real = np.abs(change_test.studentise(directions.residual[None, :], directions))[0] / growth
    along = (directions.residual @ directions.direction) ** 2
    best = float(np.max(along))
    freedom = max(directions.freedom, 1)  # of few sessions the variance is uncertain: a bound as of a t-test
    variance = max(float(np.sum(directions.residual**2)) - best, 0.0) / freedom
    bound = float(f.ppf(float(chi2.cdf(STEP_TIME_95, 1)), 1, freedom)) * growth**2
    possible: Int = first + directions.split[best - along <= bound * variance]
    return Step(
        place=first + int(directions.split[np.argmax(real)]),
        low=int(possible[0]),
        high=int(possible[-1]),
        p_value=float((1 + np.count_nonzero(drawn >= np.max(real))) / (1 + len(drawn))),
    )


def find_isolated(y: Float, error: Float) -> Bool:
    """Find the sessions that differ from both neighbours on each side by far more than neighbours usually do.

    A step has alike sessions on both of its sides, a ramp has neighbours on either side: neither is isolated. The
    first and the last session may be: only the next session separates a step from a broken estimate.
    """
    variance, near = error**2 + steps_scatter(y, error) ** 2, np.full(len(y), len(y) < FEWEST)
    for lag in range(1, REACH + 1):
        close = np.abs(y[lag:] - y[:-lag]) <= FAR * np.sqrt(variance[lag:] + variance[:-lag])
        near[lag:] |= close
        near[:-lag] |= close
    return ~near


def leave_outliers_out(series: Series) -> Series:
    """Set the sessions aside that miss the change which all others show, at the ends of the series too."""
    while (odd := _outlier(series.take(series.kept))) is not None:
        places = np.flatnonzero(series.kept)
        series = replace(series, kept=series.kept & (np.arange(len(series.kept)) != places[odd]))
        if np.count_nonzero(~series.kept) >= len(series.kept) // SHARE_ODD:
            break
    return series


def _outlier(series: Series) -> int | None:
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
    direction = found.direction[:, found.back == n]
    left = found.residual[:, None] - direction * (found.residual @ direction)
    free = 1.0 - np.sum(found.base**2, axis=1)[:, None] - direction**2
    without = np.sum(left**2, axis=0) - left**2 / free  # squares that remain without the session
    if freedom < 1 or not np.min(without) > 0.0:
        return None
    allowed = without <= np.min(without, axis=1, keepdims=True) * (1.0 + float(f.ppf(0.95, 1, freedom)) / freedom)
    size = np.where(allowed, np.abs(left) / np.sqrt(free * without / freedom), np.inf)
    odd = int(np.argmax(np.min(size, axis=1)))
    shape = int(np.argmin(size[odd]))
    neighbours = [left[i, shape] / left[odd, shape] for i in (odd - 1, odd + 1) if 0 <= i < n]
    alone = max(neighbours) < ALIKE
    return odd if alone and size[odd, shape] > float(t.isf(ODD / (2 * n), freedom)) else None
