"""Shapes of what a search found, and of what comes near it, made sharper: between the points of the grid."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.alternatives import name_effects
from friction_audit.diagnosis.cross_products import CrossProducts
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.jointly import EVERYWHERE, NEARBY, Effort, fit_jointly
from friction_audit.diagnosis.library import Library
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.diagnosis.refine import refine
from friction_audit.diagnosis.search import Search
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

NEAR, HALF = 60.0, 0.5
"""Difference in BIC up to which a rival may win once its shape is as good as that of what was found: so much, or so
much of all that speaks for what was found."""
FAR = 0.75
"""The same share for a rival whose misfit has many valleys, narrower than the steps of any grid: the best width of a
play lies between its points, and where flanks strike out of time most of what it explains is lost."""
CROWD = 3
"""So many effects for one gap: a play or a spring may be behind them all, though none of the grid comes near it."""
MOST_RIVALS = 2
NEARLY = 10.0
"""What a candidate may lack to come in and still do so once its shape is refined between the points of the grid."""
MOST_NEARLY = 2


class Sharper(NamedTuple):
    """A shape between the points of the grid.

    Attributes:
        name: Of the candidate.
        shape: The shape.
        columns: Its columns on the rows, shape (m, p).
        baseline: The declared model, if it was fitted together with the shape.
    """

    name: str
    shape: Nonlinear
    columns: Float
    baseline: Nominal | None = None


def columns_of(library: Library, outcome: Search) -> list[Float]:
    """Columns of what was found on the rows, shape (m, p) each."""
    return [library.entry(chosen.name).group.shapes[chosen.shape] for chosen in outcome.chosen]


def sharpened(
    ground: Ground, library: Library, outcome: Search, products: CrossProducts, n_eff: float
) -> Iterator[Sharper]:
    """Refined shapes of the effects found, of rivals that come near them and of what nearly came in, with columns."""
    columns, ranking = columns_of(library, outcome), Ranking(products, n_eff)
    for k, (chosen, naming) in enumerate(zip(outcome.chosen, name_effects(products, outcome, n_eff, {}), strict=True)):
        others = [*columns[:k], *columns[k + 1 :]]
        own, nearest = (chosen.name, chosen.shape), max(NEAR, HALF * chosen.score)
        near = [(rival.name, rival.shape) for rival in naming.rivals if rival.delta_bic < nearest][:MOST_RIVALS]
        far = [(rival.name, rival.shape) for rival in naming.rivals if rival.delta_bic < FAR * chosen.score]
        for name, at in (own, *near):
            yield from _sharper(ground, library, name, at, others)
        for name, at in (own, *far):
            yield from _jointly(ground, library, name, at, others)
    if len(columns) > 1:
        yield from _alone(ground, library, outcome, ranking)
    for name, at in ranking.nearly([chosen.unit for chosen in outcome.chosen], NEARLY)[:MOST_NEARLY]:
        yield from _sharper(ground, library, name, at, columns)


def _alone(ground: Ground, library: Library, outcome: Search, ranking: Ranking) -> Iterator[Sharper]:
    """The effects found, each without the others, and what may be behind them all where they are many.

    Beside companions that only mend its coarse shape none would ever become sharp enough to need none.
    """
    there = {chosen.name for chosen in outcome.chosen}
    for name, at in ranking.nearly([], np.inf):
        if name in there:
            yield from _sharper(ground, library, name, at, [])
        if name in there or len(there) >= CROWD:
            yield from _jointly(ground, library, name, at, [])
        if len(there) >= CROWD and library.entry(name).candidate.hidden_ranges(ground.data):
            yield from _jointly(ground, library, name, at, [], EVERYWHERE)


def _jointly(
    ground: Ground, library: Library, name: str, at: int, others: Sequence[Float], effort: Effort = NEARBY
) -> Iterator[Sharper]:
    """One shape of the grid, and plainer ones, fitted together with what is behind the effect, if anything is."""
    entry = library.entry(name)
    candidate, shape, beside = entry.candidate, entry.shapes[at], np.hstack([np.zeros((len(ground.y), 0)), *others])
    for one in (shape, *candidate.simpler(shape)):
        fitted = fit_jointly(candidate, one, entry.columns[at], ground, beside, effort)
        if fitted is not None:
            yield Sharper(name, fitted.shape, fitted.columns, fitted.baseline)


def _sharper(ground: Ground, library: Library, name: str, at: int, others: Sequence[Float]) -> Iterator[Sharper]:
    """One shape of the grid refined beside other effects, with its columns; nothing where the grid has the best.

    What leans on the declared model leans on it as fitted beside this very effect: beside a rival that stands in for
    it, inertia and friction are wrong.
    """
    entry = library.entry(name)
    baseline = ground.baseline(*others, entry.columns[at])
    base = np.hstack([ground.base, *others])
    shape = refine(entry.candidate, entry.shapes[at], entry.shapes, ground, baseline, base)
    if shape != entry.shapes[at] or entry.candidate.needs_nominal:
        yield Sharper(name, shape, ground.rows.of(entry.candidate.regressor(ground.data, baseline, shape)))
