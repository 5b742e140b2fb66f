"""Which other names would explain an effect as well.

References:
    G. E. Mizon, J.-F. Richard, The encompassing principle and its application to testing non-nested hypotheses,
    Econometrica 54 (1986) 657: a model is better than another only if it tells something beside it.
    R. E. Kass, A. E. Raftery, Bayes factors, Journal of the American Statistical Association 90 (1995) 773: a
    difference of 6 in BIC is strong evidence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.cross_products import CrossProducts
from friction_audit.diagnosis.evidence import evidence, evidence_of
from friction_audit.diagnosis.gram import Index
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.diagnosis.search import Search, result_of
from friction_audit.diagnosis.two_for_one import two_for_one
from friction_audit.joint_log import Float

CLEARLY = 1e-6
"""Difference in BIC that is no rounding."""
BEATEN_BY = 6.0
"""Difference in BIC from which one effect beats another (Kass and Raftery 1995)."""
WRONG_NAME = 0.01
"""Probability that, of all that run alike, one wins a name by chance that fits better than what is there."""
ALIKE = 0.7
"""Correlation, free of all else in the model, above which two effects look the same."""
ADDS = 0.05
"""Of what an effect explains, what a form of it with more numbers must explain besides to be another name."""
HARDLY_LEFT = 1e-6
"""Share of a column's square that is left beside columns that hold it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Rival:
    """Another candidate in the place of an accepted effect, with its best admissible shape, all else kept.

    Attributes:
        name: Name of the candidate.
        shape: Index of its shape.
        unit: Index in the units of the products.
        delta_bic: How much more the rival's evidence is against it than the effect's own, on the effective number of
            samples, as a difference in BIC (:func:`evidence`); above 0 it is worse.
        correlation: Of the two effects' torques free of all else in the model, 0..1.
        held: Whether the effect's own columns hold those of the rival, as a spring's preload holds an offset.
        ahead: By how much the effect fits better: n_eff ln(RSS with the rival / RSS with the effect).
        brings: What the effect brings beside the rival: n_eff ln(RSS with the rival / RSS with both).
        idle: Whether its columns hold the effect's own, and all that they add is less than a twentieth (rms) of what
            the effect explains, and no more than chance brings.
    """

    name: str
    shape: int
    unit: int
    delta_bic: float
    correlation: float
    held: bool = False
    ahead: float = 0.0
    brings: float = 0.0
    idle: bool = False

    def beaten(self, by_chance: float) -> bool:
        """Whether the log decides against it: by its numbers, or by its fit.

        Where the effect fits better, what it brings must be more than it would by chance if the rival were the truth.
        """
        return self.delta_bic >= BEATEN_BY and (self.ahead <= 0.0 or self.brings >= by_chance)


@dataclass(frozen=True, kw_only=True, slots=True)
class Naming:
    """An accepted effect and what it may be instead.

    Attributes:
        name: Name of the effect.
        rivals: All other candidates that could take its place, the best first.
        alternatives: Names of those that this log does not tell apart from it.
        together: Pairs of them that may be it only together.
    """

    name: str
    rivals: tuple[Rival, ...]
    alternatives: tuple[str, ...]
    together: tuple[tuple[str, str], ...] = ()


def name_effects(
    products: CrossProducts,
    found: Search,
    n_eff: float,
    same_as: Mapping[str, Sequence[str]],
) -> tuple[Naming, ...]:
    """For every accepted effect the set of names that fit.

    An alternative runs alike, its torque, free of all else in the model, correlates above 0.7 with that of the effect,
    and it is not beaten: not by a difference of 6 in BIC on the effective number of samples; or it fits worse, but what
    the effect brings beside it is what chance brings to one of all that run alike in one of a hundred logs in which the
    rival is the truth (an encompassing test: Mizon and Richard 1986). A rival that the effect holds
    within it (an offset in the preload of a spring) is never better: it belongs to the set where it alone gives most of
    the torque, for it may be there beside something smaller. One that holds the effect, and adds next to nothing to it,
    is no other name: a spring so weak that only its preload shows is an offset. Names that no motion of this kind
    tells apart always belong to the set, be it from the effect or from an alternative.

    Args:
        products: Cross products of the data.
        found: The accepted effects.
        n_eff: Number of independent samples that the data are worth.
        same_as: For each name those that are the same in any log of this kind.

    Returns:
        One entry for each effect, in the order of the search.
    """
    taken, ranking = {chosen.name for chosen in found.chosen}, Ranking(products, n_eff)
    entries = []
    for chosen in found.chosen:
        rivals = _rivals(products, [c.unit for c in found.chosen], chosen.unit, n_eff)
        alike = [rival for rival in rivals if rival.correlation > ALIKE]
        by_chance = _by_chance(products, chosen.unit, len(alike))
        close = [r.name for r in alike if r.held or not (r.idle or r.beaten(by_chance))]
        same = [name for one in (chosen.name, *close) for name in same_as.get(one, ()) if name not in taken]
        pairs = two_for_one(ranking, [c.unit for c in found.chosen], chosen.unit, BEATEN_BY)
        together = tuple(pair for pair in pairs if not {*close, *same} & set(pair))
        names = dict.fromkeys([*close, *same, *(name for pair in together for name in pair)])
        entries.append(Naming(name=chosen.name, rivals=rivals, alternatives=tuple(names), together=together))
    return tuple(entries)


def with_wholes(namings: Sequence[Naming], part_of: Mapping[str, Sequence[str]]) -> tuple[Naming, ...]:
    """The same, each with those accepted effects among its alternatives that it may be a part of.

    A drift that is older than the recording has a level where that starts, and no motion tells it from an offset. Where
    none was found an offset is no drift: that would have gone on.

    Args:
        namings: The accepted effects.
        part_of: For each name those that it may be a part of; be it the effect or an alternative.
    """
    accepted = [naming.name for naming in namings]
    entries = []
    for naming in namings:
        names = (naming.name, *naming.alternatives)
        wholes = [whole for one in names for whole in part_of.get(one, ()) if whole in accepted]
        more = [whole for whole in dict.fromkeys(wholes) if whole not in names]
        entries.append(replace(naming, alternatives=(*naming.alternatives, *more)))
    return tuple(entries)


def _by_chance(products: CrossProducts, unit: int, rivals: int) -> float:
    """What a unit brings by chance beside the truth, with all its numbers, so many rivals counted."""
    from scipy.special import chdtri

    entry = products.units[unit]
    return float(chdtri(len(entry.columns) + entry.numbers, WRONG_NAME / max(rivals, 1)))


def preferred(products: CrossProducts, found: Search, n_eff: float) -> Search:
    """The same with rivals that run alike and for which more speaks in the place of effects, as a search finds others.

    A search lets in what brings more than chance does; of two that both bring plenty, the one that had to be fitted
    less is the better name.
    """
    active = [chosen.unit for chosen in found.chosen]
    ranking = Ranking(products, n_eff)
    for place in range(len(active)):
        taken = {products.units[u].group for u in active}
        better = [
            rival
            for rival in _rivals(products, active, active[place], n_eff)
            if rival.delta_bic < -CLEARLY
            and rival.correlation > ALIKE
            and products.units[rival.unit].group not in taken
        ]
        if better:
            active[place] = min(better, key=lambda rival: rival.delta_bic).unit
    return result_of(ranking, active)


def _rivals(products: CrossProducts, active: list[int], unit: int, n_eff: float) -> tuple[Rival, ...]:
    """Every other candidate in the place of one effect, with that possible shape for which most speaks."""
    others = [u for u in active if u != unit]
    ranking = Ranking(products, n_eff)
    best = best_shapes(ranking, others)
    group = products.units[unit].group
    own = max(evidence(ranking, others, unit), evidence(ranking, others, best.get(group, unit)))
    return tuple(_rival(ranking, others, unit, u, own) for g, u in best.items() if g != group)


def best_shapes(ranking: Ranking, others: list[int]) -> dict[int, int]:
    """The possible shape of each candidate for which most speaks beside others: its unit by its group.

    Not the one that fits best: a bent spring that fits a little better than a straight one may speak less for springs.
    """
    scores, possible = ranking.tried(others)
    units = ranking.products.units
    worth = evidence_of(scores + ranking.penalty, ranking.width + np.array([unit.numbers for unit in units]))
    best: dict[int, int] = {}
    for u in np.argsort(-worth, kind="stable").tolist():
        there = ranking.width[u] > 0 and np.isfinite(scores[u])
        if there and units[u].group not in best and possible(u):
            best[units[u].group] = u
    return best


def _rival(ranking: Ranking, others: list[int], unit: int, rival: int, own: float) -> Rival:
    """One rival of a unit, its name's evidence given."""
    entry = ranking.products.units[rival]
    correlation, held, holds = _likeness(ranking, others, unit, rival)
    nothing, alone, beside, both = (ranking.rss([*others, *more]) for more in ((), (unit,), (rival,), (unit, rival)))
    adds, chance = ranking.n_eff * float(np.log(alone / beside)), _by_chance(ranking.products, rival, 1)
    hardly = adds < chance and alone - beside < ADDS**2 * (nothing - alone)
    return Rival(
        name=ranking.products.names[entry.group],
        shape=entry.shape,
        unit=rival,
        delta_bic=own - evidence(ranking, others, rival),
        correlation=correlation,
        held=held,
        ahead=-adds,
        brings=ranking.n_eff * float(np.log(beside / both)),
        idle=holds and not held and hardly,
    )


def _likeness(ranking: Ranking, others: list[int], unit: int, rival: int) -> tuple[float, bool, bool]:
    """Correlation of the torques that two units would each explain, free of base and other effects.

    And whether the one's columns hold the rival's, and the rival's the one's.
    """
    ranking.products.fill([unit])
    one, two = (ranking.products.units[u].columns for u in (unit, rival))
    cols = ranking.columns(others)
    every = np.concatenate([[0], one, two])
    lean = np.linalg.lstsq(ranking.gram[np.ix_(cols, cols)], ranking.gram[np.ix_(cols, every)], rcond=1e-12)[0]
    free = ranking.gram[np.ix_(every, every)] - ranking.gram[np.ix_(every, cols)] @ lean
    a, b = np.arange(1, 1 + len(one)), np.arange(1 + len(one), len(every))
    first = np.linalg.lstsq(free[np.ix_(a, a)], free[a, 0], rcond=1e-8)[0]
    second = np.linalg.lstsq(free[np.ix_(b, b)], free[b, 0], rcond=1e-8)[0]
    size = (first @ free[np.ix_(a, a)] @ first) * (second @ free[np.ix_(b, b)] @ second)
    correlation = float(abs(first @ free[np.ix_(a, b)] @ second) / np.sqrt(size)) if size > 0 else 0.0
    return correlation, _holds(free, a, b), _holds(free, b, a)


def _holds(free: Float, a: Index, b: Index) -> bool:
    """Whether columns a hold columns b, from products of what of them is free of all else.

    Not by what is left of whole columns: a curve that is hardly bent is nearly the line that is fitted anyway.
    """
    inside = np.linalg.lstsq(free[np.ix_(a, a)], free[np.ix_(a, b)], rcond=1e-12)[0]
    left = np.diag(free[np.ix_(b, b)] - free[np.ix_(b, a)] @ inside)
    return bool(np.all(left <= HARDLY_LEFT * np.diag(free)[b]))
