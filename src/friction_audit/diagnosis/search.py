"""Which effects to add: forward search with exchange and backward deletion.

References:
    P. Pudil et al., Floating search methods in feature selection, Pattern Recognition Letters 15 (1994) 1119.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from friction_audit.diagnosis.cross_products import CrossProducts
from friction_audit.diagnosis.ranking import Ranking

PROMISING = 8
"""Candidates that are tried as the first of two in the place of one."""
MAX_ROUNDS = 50
"""Rounds of exchange and recombination; each raises the objective, so that only rounding could go on."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Chosen:
    """One effect in the model.

    Attributes:
        name: Name of the candidate.
        unit: Index in the units of the products.
        shape: Index of its shape.
        factors: Its factors with everything fitted together, in the units of its columns.
        score: n_eff ln(RSS without / RSS with) less what chance gives.
    """

    name: str
    unit: int
    shape: int
    factors: tuple[float, ...]
    score: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Search:
    """Outcome of a search.

    Attributes:
        chosen: Effects in the model, the strongest first.
        rss: Residual sum of squares of the model, in the square of the response's unit.
    """

    chosen: tuple[Chosen, ...]
    rss: float


def search(products: CrossProducts, n_eff: float) -> Search:
    """Adds effects while the score allows it; after each, exchanges and deletes.

    A candidate enters with all its p columns and its best admissible shape if ``n_eff ln(RSS0 / RSS1)`` is larger than
    the best of everything tried is by chance: than the quantile of chi squared with p degrees of freedom that is
    exceeded with probability 1 % / (candidates x independent trials of this one). So each candidate has the same chance
    to enter by accident, however many shapes and columns it has. Then every effect is exchanged for whatever takes
    its place better, its own other shapes included, and those that the others made superfluous or impossible leave
    (floating search, Pudil 1994). Where nothing moves singly, one effect may give way to two and two to one, so that a
    stand-in for two real effects does not stay because it came first. All factors are always fitted together.

    Args:
        products: Cross products of the data.
        n_eff: Number of independent samples that the data are worth.

    Returns:
        The effects found.
    """
    ranking = Ranking(products, n_eff)
    active: list[int] = []
    while (best := ranking.best_addition(active)) is not None:
        settled = settle(ranking, [*active, best])
        # What came in may make impossible what was there: no search ends with less than it had.
        if not ranking.is_better(settled, active):
            break
        active = settled
    return result_of(ranking, active)


def settle(ranking: Ranking, active: list[int]) -> list[int]:
    """Deletes, exchanges and recombines until nothing raises the objective."""
    active = _delete(ranking, active)
    for _ in range(MAX_ROUNDS):
        kept = _best(ranking, [_exchange(ranking, active)], active)
        kept = kept or _best(ranking, _recombined(ranking, active), active)
        if kept is None:
            break
        active = kept
    return active


def _best(ranking: Ranking, trials: Sequence[list[int]], active: list[int]) -> list[int] | None:
    """The best of some sets, less what is impossible or worthless in it; None where none is better than another.

    A set may look better only by an effect that is impossible without a companion that is worth nothing.
    """
    for trial in sorted(trials, key=ranking.objective, reverse=True):
        if not ranking.is_better(trial, active):
            break
        if ranking.is_better(kept := _delete(ranking, trial), active):
            return kept
    return None


def _recombined(ranking: Ranking, active: list[int]) -> list[list[int]]:
    """Sets with one effect replaced by two, or two by one."""
    return [*_one_by_two(ranking, active), *_two_by_one(ranking, active)]


def _one_by_two(ranking: Ranking, active: list[int]) -> Iterator[list[int]]:
    """Sets in which two units stand in the place of one; the first of the two among the most promising."""
    for place in range(len(active)):
        others = active[:place] + active[place + 1 :]
        promising = _best_of_groups(ranking, others)
        ranking.products.fill(promising)  # at once, for each time all samples are read
        for first in promising:
            second = ranking.best_addition([*others, first])
            if second is not None and ranking.admissible([*others, first, second], first):
                yield [*others, first, second]


def _two_by_one(ranking: Ranking, active: list[int]) -> Iterator[list[int]]:
    """Sets in which one unit stands in the place of two."""
    for pair in combinations(active, 2):
        others = [u for u in active if u not in pair]
        best = ranking.best_addition(others)
        if best is not None:
            yield [*others, best]


def _best_of_groups(ranking: Ranking, others: list[int]) -> list[int]:
    """The best shape of each of the candidates with the highest scores."""
    score = ranking.scores(others)
    best: dict[int, int] = {}
    for unit in np.argsort(-score, kind="stable"):
        if np.isfinite(score[unit]):
            best.setdefault(ranking.products.units[int(unit)].group, int(unit))
    return list(best.values())[:PROMISING]


def _exchange(ranking: Ranking, active: list[int]) -> list[int]:
    """Replaces each effect by what serves better in its place."""
    for place in range(len(active)):
        others = active[:place] + active[place + 1 :]
        best = ranking.best_addition(others)
        if best is None or best == active[place]:
            continue
        trial = [*active[:place], best, *active[place + 1 :]]
        if ranking.is_better(trial, active):
            active = trial
    return active


def _delete(ranking: Ranking, active: list[int]) -> list[int]:
    """Removes, the worst first, effects that are not worth their penalty or are impossible among the others."""
    while active:
        worth = [ranking.worth(active, u) if ranking.admissible(active, u) else -np.inf for u in active]
        worst = int(np.argmin(worth))
        if worth[worst] > 0:
            break
        active = active[:worst] + active[worst + 1 :]
    return active


def result_of(ranking: Ranking, active: list[int]) -> Search:
    """The outcome in the units of the columns."""
    chosen = [_chosen(ranking, active, u) for u in active]
    scale = ranking.products.scale
    return Search(
        chosen=tuple(sorted(chosen, key=lambda c: -c.score)),
        rss=ranking.rss(active) * float(scale[0]) ** 2,
    )


def _chosen(ranking: Ranking, active: list[int], unit: int) -> Chosen:
    entry = ranking.products.units[unit]
    return Chosen(
        name=ranking.products.names[entry.group],
        unit=unit,
        shape=entry.shape,
        factors=tuple(float(f) for f in ranking.unit_factors(active, unit)),
        score=ranking.worth(active, unit),
    )
