"""The test of an arm: is there drift in any coefficient of any joint?

Every coefficient is asked along all shapes of drift (a step at each session, a ramp); the largest studentised
statistic counts. Its distribution without drift comes from the same sessions in random orders, one order for all
joints at a time, and the step-down maximum over the coefficients of the arm (Westfall and Young 1993) keeps the
probability of any false one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

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
    width = 1 + max(int(np.max(place)) for place in places)
    rng = past_keys(permutations, width, seed)
    found = [np.abs(studentise(directions.residual[None, :], directions)) for directions in family]
    memory = _memories(family, kinds, rng)
    maxima, ramp_maxima = _draw_largest(family, places, rng, permutations=permutations, width=width, seed=seed)
    observed, ramp = [], []
    for k, (directions, real) in enumerate(zip(family, found, strict=True)):
        growth, freedom = memory[k].growth, directions.freedom
        observed.append(score(np.max(real) / growth, freedom))
        ramp.append(score(np.max(real[:, directions.ramps], initial=0.0) / growth, freedom))
        maxima[:, k], ramp_maxima[:, k] = score(maxima[:, k], freedom), score(ramp_maxima[:, k], freedom)
    return FamilyTest(
        p_value=step_down(np.array(observed), maxima),
        ramp_p_value=step_down(np.array(ramp), ramp_maxima),
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
    family: Sequence[Directions],
    places: Sequence[Float],
    rng: np.random.Generator,
    *,
    permutations: int,
    width: int,
    seed: int,
) -> tuple[Float, Float]:
    """Return the largest statistic without drift in each order, of all shapes and of the ramps, shape (orders, s) each.

    Args:
        family: The directions of each series.
        places: Places of its sessions among those compared.
        rng: For normal scatter, where the sessions are too few for random orders.
        permutations: Random orders.
        width: How many places there are.
        seed: Of the orders.
    """
    largest, largest_ramp = np.empty((permutations, len(family))), np.empty((permutations, len(family)))

    def keep(rows: slice, k: int, drawn: Float) -> None:
        largest[rows, k] = np.max(drawn, axis=1)
        largest_ramp[rows, k] = np.max(drawn[:, family[k].ramps], axis=1, initial=0.0)

    long = [k for k, directions in enumerate(family) if len(directions.residual) >= FEWEST_TO_PERMUTE]
    for k in sorted(set(range(len(family))).difference(long)):
        keep(slice(None), k, draw_normal(family[k], permutations, rng))
    most = max((len(places[k]) for k in long), default=1)
    for rows, keys in key_lots(permutations, width, most, seed):
        place, order = np.zeros(0), np.zeros((0, 0), dtype=np.int64)
        for k in long:
            if not np.array_equal(places[k], place):  # mostly all series have their sessions in the same places
                place, order = places[k], np.argsort(keys[:, places[k].astype(np.int64)], axis=1)
            keep(rows, k, np.abs(studentise_orders(family[k], order)))
    return largest, largest_ramp


def key_lots(orders: int, width: int, sessions: int, seed: int) -> Iterator[tuple[slice, Float]]:
    """Yield random numbers whose order is the order of the sessions, some orders at a time, shape (orders, width).

    Many sessions must not take much memory.
    """
    rng = np.random.default_rng(seed)
    first = 0
    for rows in np.array_split(np.arange(orders), -(-orders * sessions // AT_ONCE)):
        yield slice(first, first + len(rows)), rng.random((len(rows), width))
        first += len(rows)


def past_keys(orders: int, width: int, seed: int) -> np.random.Generator:
    """Return the generator that comes after all keys."""
    return np.random.Generator(np.random.PCG64(seed).advance(orders * width))


def draw_normal(directions: Directions, orders: int, rng: np.random.Generator) -> Float:
    """Return the size of the statistics of normal scatter, shape (orders, k)."""
    return np.abs(studentise(rng.standard_normal((orders, len(directions.residual))), directions))


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
