"""The test of an arm: is there drift in any coefficient of any joint?

Every coefficient is asked along all shapes of drift (a step at each session, a ramp); the largest studentised
statistic counts. Its distribution without drift comes from the same sessions in random orders, one order for all
joints at a time, and the step-down maximum over the coefficients of the arm (Westfall and Young 1993) keeps the
probability of any false one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.memory import Memory, find_memory
from friction_audit.drift.shapes import Directions, studentise, studentise_orders
from friction_audit.joint_log import Float

FEWEST_TO_PERMUTE = 12
"""With fewer sessions, the rarest order (both sessions after a late step at the end) is not rare enough; the scatter is
then taken for normal."""

AT_ONCE = 250_000
"""Sessions times orders."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class FamilyTest:
    """What the test of an arm says of each of its s series.

    Attributes:
        p_value: Of the largest statistic, family-wise, shape (s,).
        ramp_p_value: Of the ramps alone, family-wise, shape (s,).
        best: Which direction is the largest, shape (s,).
        critical: Score that is exceeded without drift with probability alpha, in any series.
        memory: Autocorrelation of its scatter, of each series.
    """

    p_value: Float
    ramp_p_value: Float
    best: tuple[int, ...]
    critical: float
    memory: tuple[Memory, ...]


def judge_family(
    family: Sequence[Directions],
    places: Sequence[Float],
    kinds: Sequence[str],
    *,
    alpha: float,
    permutations: int,
    seed: int,
) -> FamilyTest:
    """Test all series of an arm for drift.

    Args:
        family: The directions of each series.
        places: Places of its sessions among those compared, for one order of the sessions to hold in all series.
        kinds: What each series is of; series of one kind scatter alike.
        alpha: Probability of a false drift.
        permutations: Random orders.
        seed: Of the orders.
    """
    rng = np.random.default_rng(seed)
    keys = rng.random((permutations, 1 + max(int(np.max(place)) for place in places)))
    found = [np.abs(studentise(directions.residual[None, :], directions)) for directions in family]
    memory = _memories(family, kinds, rng)
    observed, drawn, ramp, ramp_drawn = [], [], [], []
    for directions, real, place, growth in zip(family, found, places, (one.growth for one in memory), strict=True):
        largest, largest_ramp = _draw_largest(directions, keys, place.astype(int), rng)
        observed.append(score(np.max(real) / growth, directions.freedom))
        drawn.append(score(largest, directions.freedom))
        ramp.append(score(np.max(real[:, directions.ramps], initial=0.0) / growth, directions.freedom))
        ramp_drawn.append(score(largest_ramp, directions.freedom))
    maxima = np.column_stack(drawn)
    return FamilyTest(
        p_value=step_down(np.array(observed), maxima),
        ramp_p_value=step_down(np.array(ramp), np.column_stack(ramp_drawn)),
        best=tuple(int(np.argmax(real)) for real in found),
        critical=float(np.quantile(np.max(maxima, axis=1), 1.0 - alpha)),
        memory=memory,
    )


def _memories(family: Sequence[Directions], kinds: Sequence[str], rng: np.random.Generator) -> tuple[Memory, ...]:
    """Return the autocorrelation of each series, found from all of its kind."""
    of_kind = {
        kind: find_memory([own for own, its in zip(family, kinds, strict=True) if its == kind], rng)
        for kind in dict.fromkeys(kinds)
    }
    return tuple(of_kind[kind] for kind in kinds)


def _draw_largest(
    directions: Directions, keys: Float, place: NDArray[np.int64], rng: np.random.Generator
) -> tuple[Float, Float]:
    """Return the largest statistic without drift in each order, of all shapes and of the ramps, shape (orders,) each.

    A few orders at a time: many sessions must not take much memory.
    """
    parts = np.array_split(keys, -(-keys.shape[0] * len(place) // AT_ONCE))
    drawn = (draw_statistics(directions, part[:, place], rng) for part in parts)
    largest = [(np.max(one, axis=1), np.max(one[:, directions.ramps], axis=1, initial=0.0)) for one in drawn]
    return np.concatenate([one for one, _ in largest]), np.concatenate([ramp for _, ramp in largest])


def draw_statistics(directions: Directions, keys: Float, rng: np.random.Generator) -> Float:
    """Return the size of the statistics without drift, shape (orders, k).

    Args:
        directions: Of one series, n sessions.
        keys: Random numbers whose order is the order of the sessions, shape (orders, n).
        rng: For normal scatter, where the sessions are too few for random orders.
    """
    if len(directions.residual) < FEWEST_TO_PERMUTE:
        return np.abs(studentise(rng.standard_normal(keys.shape), directions))
    return np.abs(studentise_orders(directions, np.argsort(keys, axis=1)))


def score(statistic: Float | float, freedom: int) -> Float:
    """Return minus the logarithm of the probability of |t|, by which series of unlike lengths are compared."""
    from scipy.stats import t

    return -np.asarray(t.logsf(statistic, max(freedom, 1)), dtype=float)


def statistic_of(value: float, freedom: int) -> float:
    """Return the |t| of a score."""
    from scipy.stats import t

    return float(t.isf(np.exp(-value), max(freedom, 1)))


def step_down(observed: Float, null: Float) -> Float:
    """Return family-wise p-values by the step-down maximum (Westfall and Young 1993, algorithm 4.1), shape (s,).

    Args:
        observed: Scores, shape (s,).
        null: Scores without drift, of all series in the same order of the sessions, shape (orders, s).
    """
    order = np.argsort(-observed, kind="stable")
    maxima = np.maximum.accumulate(null[:, order[::-1]], axis=1)[:, ::-1]
    p = (1.0 + np.sum(maxima >= observed[order], axis=0)) / (1.0 + len(null))
    adjusted = np.empty(len(p))
    adjusted[order] = np.maximum.accumulate(p)
    return adjusted
