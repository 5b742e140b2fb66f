"""Two effects that one name may stand for.

An effect of several numbers may run like two of one number each: along a sine the inertia is a line over the position,
and with an offset of the sensor it is a weight.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

from friction_audit.diagnosis.evidence import evidence
from friction_audit.diagnosis.ranking import Ranking


def two_for_one(ranking: Ranking, active: Sequence[int], unit: int, beaten_by: float) -> tuple[tuple[str, str], ...]:
    """Names of the pairs for which, in the place of one effect, about as much speaks.

    Args:
        ranking: Of all that was looked for.
        active: Units of the accepted effects.
        unit: That of the one.
        beaten_by: How much more must speak for it.
    """
    others = [u for u in active if u != unit]
    if ranking.width[unit] + ranking.products.units[unit].numbers < 2:  # noqa: PLR2004 (it takes two)
        return ()
    least = evidence(ranking, others, unit) - beaten_by
    pairs = combinations(_simple(ranking, active), 2)
    return tuple(
        (_name(ranking, one), _name(ranking, two))
        for one, two in pairs
        if evidence(ranking, others, one, two) > least and _needed(ranking, others, one, two)
    )


def _simple(ranking: Ranking, active: Sequence[int]) -> Iterator[int]:
    """Units of one factor and no shape, of candidates that are not in the model; of zeros there is no factor."""
    taken = {ranking.products.units[u].group for u in active}
    for u, entry in enumerate(ranking.products.units):
        if ranking.width[u] == 1 and not entry.numbers and entry.group not in taken:
            yield u


def _needed(ranking: Ranking, others: Sequence[int], one: int, two: int) -> bool:
    """Whether both of a pair are possible and bring more than chance."""
    both = [*others, one, two]
    return all(ranking.admissible(both, u) and ranking.worth(both, u) > 0.0 for u in (one, two))


def _name(ranking: Ranking, unit: int) -> str:
    return ranking.products.names[ranking.products.units[unit].group]
