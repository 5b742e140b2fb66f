"""Mean or median of a measure over seeds, and how well it is known."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from math import isfinite, nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from friction_audit.compensation.comparison.methods import Tuning
from friction_audit.compensation.comparison.trial import Course, Outcome

CONFIDENCE = 0.95


class Interval(NamedTuple):
    """A mean or median and the bounds of its confidence interval; NaN where there are too few values."""

    value: float
    low: float
    high: float


def mean_interval(values: Sequence[float]) -> Interval:
    """Return the mean of independent values and its 95 % interval (Student's t)."""
    from scipy.stats import t

    known = [value for value in values if isfinite(value)]
    if len(known) < 2:  # noqa: PLR2004
        return Interval(known[0] if known else nan, nan, nan)
    mean = float(np.mean(known))
    half = float(t.ppf(0.5 + CONFIDENCE / 2, len(known) - 1) * np.std(known, ddof=1) / sqrt(len(known)))
    return Interval(mean, mean - half, mean + half)


def median_interval(values: Sequence[float]) -> Interval:
    """Return the lower median of values, infinite ones too, and its 95 % interval by order statistics, from six on."""
    from scipy.stats import quantile_test

    if not values:
        return Interval(nan, nan, nan)
    found: Any = quantile_test(values, p=0.5).confidence_interval(CONFIDENCE)
    return Interval(sorted(values)[(len(values) - 1) // 2], float(found.low), float(found.high))


@dataclass(frozen=True, eq=False, kw_only=True)
class Tried:
    """A tuning that was tried by some persons."""

    tuning: Tuning
    outcomes: tuple[Outcome, ...]  # one per seed

    @property
    def losses(self) -> int:
        """Number of seeds that lost the loop."""
        return sum(not outcome.stable for outcome in self.outcomes)

    @property
    def stable_share(self) -> float:
        """Share of the seeds in which the loop held."""
        return 1.0 - self.losses / len(self.outcomes)

    def interval(self, measure: str) -> Interval:
        """Return mean and interval of a measure, by its name, over the seeds in which the loop held."""
        return mean_interval([getattr(outcome, measure) for outcome in self.outcomes if outcome.stable])


@dataclass(frozen=True, eq=False, kw_only=True)
class Point(Tried):
    """One value of a sweep, tried by the persons who are not reported."""

    value: float

    @property
    def stable(self) -> bool:
        """True if no seed lost the loop."""
        return self.losses == 0


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """A sweep that was made."""

    method: str  # name of the method
    label: str  # its label
    name: str  # name of the sweep
    axis: str  # what was varied
    points: tuple[Point, ...]  # from careful to bold

    @property
    def boldest_stable(self) -> float | None:
        """The last value before the first at which the loop was lost; None if it is lost at once."""
        stable = [point.value for point in takewhile(lambda point: point.stable, self.points)]
        return stable[-1] if stable else None


@dataclass(frozen=True, eq=False, kw_only=True)
class Row(Tried):
    """A method with a tuning, tried by all persons."""

    method: str  # name of the method
    label: str  # its label
    role: str  # ``"paper"``, ``"full"``, ``"best"`` or ``"other"``
    # with how many of the persons of the sweeps the loop was lost at the setting that the tuning was chosen by; None if
    # it was not chosen from a sweep
    tuning_losses: int | None
    # factor by which the gain may grow, one per seed for which it was looked for; infinite if more than anybody asks
    # for, 0 if the loop is lost as it is
    margins: tuple[float, ...]
    course: Course  # what figures show of the first seed

    @property
    def margin(self) -> Interval:
        """Median of the stability margins; NaN if none was looked for."""
        return median_interval(self.margins)

    @property
    def lost_s(self) -> tuple[float, ...]:
        """When the loop was lost, of the seeds in which it was. [s]"""
        return tuple(outcome.lost_s for outcome in self.outcomes if isfinite(outcome.lost_s))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Comparison:
    """All methods side by side."""

    scene: str  # name of what they were tried on
    duration_s: float  # length of a trial [s]
    seeds: tuple[int, ...]  # seeds that are reported
    tuning_seeds: tuple[int, ...]  # seeds of the sweeps
    margin_seeds: tuple[int, ...]  # seeds for which stability margins were looked for
    rows: tuple[Row, ...]  # methods and tunings, in the order of the methods
    curves: tuple[Curve, ...]  # the sweeps

    def row(self, method: str, role: str) -> Row | None:
        """Return the row of a method and a role; a method without sweep is at its best as it is."""
        mine = [row for row in self.rows if row.method == method]
        return next((row for row in mine if row.role == role), mine[0] if len(mine) == 1 else None)
