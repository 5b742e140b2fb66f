"""Which effects are missing: search on the working cycles, refine, and keep what holds on the locked ones."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.alternatives import ALIKE, Naming, best_shapes, name_effects, preferred, with_wholes
from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.confirmation import confirm
from friction_audit.diagnosis.cross_products import CrossProducts, cross_products
from friction_audit.diagnosis.driving import driving
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.groups import Group, not_zero
from friction_audit.diagnosis.library import Entry, Library, extend_library, plainer, rebuild_library
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.diagnosis.refine import refine
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from friction_audit.diagnosis.search import Search, result_of, search
from friction_audit.diagnosis.sharpen import columns_of, sharpened
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

MOST_ROUNDS = 4
"""Of search and counting what the rows are worth; the memory of the residual shrinks as effects are found."""
SETTLED = 0.05
LEAST_SHARE = 0.2
"""An effect that is smaller than this share of a larger one may be what that one's formula does not get right: not of
an offset, which is right or not there."""
UNTOLD = 6.0
"""Of n_eff ln(RSS / RSS_best): the 95 % quantile of chi squared for a moment and a length."""
ADDS = 0.05
"""Of what a plainer shape explains, what a richer one of the same effect must explain besides. The moments of inertia
of a link that is wrong, which its first moments lack, come to a twentieth of its weight: 0.1 m, 5 rad/s^2, over g."""


Searched = tuple[CrossProducts, Search, float]
"""Products of a library, what a search took of it, and what the rows are worth."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Found:
    """An effect that a search found.

    Attributes:
        candidate: The effect.
        shape: Its shape.
        columns: Its columns on the rows, shape (m, p).
        naming: What it may be instead.
        p_value: Family-wise p-value of its improvement on locked cycles.
    """

    candidate: Effect
    shape: Nonlinear
    columns: Float
    naming: Naming
    p_value: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Names:
    """What a joint misses.

    Attributes:
        found: Accepted effects, the strongest first.
        library: What was looked for.
        baseline: The declared model as fitted beside the effects.
        disproved: Names of what was found and does not hold on the locked cycles or cannot be, with nothing in its
            place.
    """

    found: tuple[Found, ...]
    library: Library
    baseline: Nominal
    disproved: tuple[str, ...] = ()


def find_names(
    ground: Ground,
    candidates: Sequence[Effect],
    library: Library,
    alpha: float,
    rng: np.random.Generator,
    searched: Searched | None = None,
    *,
    rejected: bool = True,
) -> Names:
    """Search, refine what was found and what comes near it, search again with these shapes, and accept.

    What leans on the declared model is built again with its better fit in between. Close rivals are refined too, for
    a name must not win by the luck of the grid.

    Args:
        ground: The joint.
        candidates: Effects that may be named.
        library: Those that the log can show, built on the declared model alone.
        alpha: Family-wise error on the locked cycles.
        rng: Source of randomness.
        searched: What a search of this library found, None where there was none.
        rejected: Whether the test of whether anything is missing says so; if not, a name must be plain by itself.
    """
    library, (products, outcome, n_eff) = _plainly(ground, library, searched or search_library(ground, library))
    baseline = ground.baseline(*columns_of(library, outcome))
    library = rebuild_library(library, ground.data, baseline, ground.rows)
    sharper = tuple(sharpened(ground, library, outcome, products, n_eff))
    library = extend_library(library, ((one.name, one.shape, one.columns) for one in sharper))
    jointly = [(one.shape, one.baseline) for one in sharper if one.baseline is not None]
    library = with_scanned_orders(ground, library, *columns_of(library, outcome)) if outcome.chosen else library
    library, (products, outcome, n_eff) = _plainly(ground, library, search_library(ground, library, products))
    everything, worth_of_all = _on_all_cycles(ground, library, products, outcome, n_eff)
    outcome = preferred(everything, outcome, worth_of_all)
    baseline = _fitted_with(library, outcome, jointly) or ground.baseline(*columns_of(library, outcome))
    same = {candidate.name: candidate.indistinguishable for candidate in candidates}
    namings = name_effects(everything, outcome, worth_of_all, same)
    found = _refined(ground, library, outcome, namings, baseline, jointly)
    ranking = Ranking(everything, worth_of_all)
    within = dict(_within(library, ranking, outcome, namings, same))
    price = {chosen.name: float(ranking.penalty[chosen.unit]) for chosen in outcome.chosen}
    price |= {f.candidate.name: float(ranking.penalty[unit]) for f, unit in within.values()}
    simpler = {name: f for name, (f, _) in within.items()}
    accepted, disproved = _accept(ground, found, simpler, price, alpha, rng, rejected=rejected)
    part_of = {candidate.name: candidate.part_of for candidate in candidates}
    told = _with_wholes(_named_anew(accepted, outcome, ranking, same), part_of)
    return Names(found=told, library=library, baseline=baseline, disproved=disproved)


def _fitted_with(library: Library, outcome: Search, jointly: Sequence[tuple[Nonlinear, Nominal]]) -> Nominal | None:
    """The declared model that one of the effects found was fitted with; None if none was."""
    shapes = [library.entry(chosen.name).shapes[chosen.shape] for chosen in outcome.chosen]
    return next((baseline for own, baseline in jointly if any(own is shape for shape in shapes)), None)


def _named_anew(
    accepted: tuple[Found, ...], outcome: Search, ranking: Ranking, same: Mapping[str, Sequence[str]]
) -> tuple[Found, ...]:
    """The accepted effects with what they may be instead, where others were dropped: those may be among it."""
    units = {chosen.name: chosen.unit for chosen in outcome.chosen}
    names = [f.candidate.name for f in accepted]
    if len(names) == len(units) or not units.keys() >= set(names):
        return accepted
    kept = result_of(ranking, [units[name] for name in names])
    namings = {one.name: one for one in name_effects(ranking.products, kept, ranking.n_eff, same)}
    return tuple(replace(f, naming=namings[f.candidate.name]) for f in accepted)


def _with_wholes(found: tuple[Found, ...], part_of: Mapping[str, Sequence[str]]) -> tuple[Found, ...]:
    """The accepted effects, among the alternatives of each those of them that it may be a part of."""
    namings = with_wholes([f.naming for f in found], part_of)
    return tuple(replace(f, naming=naming) for f, naming in zip(found, namings, strict=True))


def _within(
    library: Library, ranking: Ranking, outcome: Search, namings: Sequence[Naming], same: Mapping[str, Sequence[str]]
) -> Iterator[tuple[str, tuple[Found, int]]]:
    """The name of each effect with an alternative that it holds or that has fewer numbers, with that one and its unit.

    What working cycles made of four waves of a drift may mislead where an offset alone would not.
    """
    units = [chosen.unit for chosen in outcome.chosen]
    numbers = [len(unit.columns) + unit.numbers for unit in ranking.products.units]
    for k, naming in enumerate(namings):
        alone = set(naming.alternatives).difference(*naming.together)
        alike = (r for r in naming.rivals if r.name in alone and r.correlation > ALIKE)
        rival = next((r for r in alike if r.held or numbers[r.unit] < numbers[units[k]]), None)
        if rival is None or any(rival.name == chosen.name for chosen in outcome.chosen):
            continue
        swapped = result_of(ranking, [*units[:k], rival.unit, *units[k + 1 :]])
        naming_of = {one.name: one for one in name_effects(ranking.products, swapped, ranking.n_eff, same)}
        entry = library.entry(rival.name)
        effect = Found(
            candidate=entry.candidate,
            shape=entry.shapes[rival.shape],
            columns=entry.columns[rival.shape],
            naming=naming_of[rival.name],
            p_value=1.0,
        )
        yield naming.name, (effect, rival.unit)


def with_moments_of_all_cycles(ground: Ground, names: Names) -> tuple[Found, ...]:
    """The accepted effects, the numbers of those that are functions of time refined once more, on all cycles.

    What happens at one moment may happen in a locked cycle: the others only tell that it was between them. For the
    numbers that are told, not for the proof.
    """
    every = replace(ground, working=np.ones_like(ground.working))
    found = list(names.found)
    for k, f in enumerate(found):
        if f.candidate.axis != "time" or not f.shape:
            continue
        base = np.hstack([ground.base, *(g.columns for g in found if g is not f)])
        shape = refine(f.candidate, f.shape, f.candidate.grid(ground.data), every, names.baseline, base)
        columns = ground.rows.of(f.candidate.regressor(ground.data, names.baseline, shape))
        found[k] = replace(f, shape=shape, columns=columns)
    return tuple(found)


def on_rows(ground: Ground, names: Names) -> Names:
    """The names with their columns on the rows of a joint: on all of them, or as they were measured."""
    fine = (f.candidate.regressor(ground.data, names.baseline, f.shape) for f in names.found)
    found = tuple(replace(f, columns=ground.rows.of(torque)) for f, torque in zip(names.found, fine, strict=True))
    return replace(names, found=found)


def worth(ground: Ground, *effects: Float) -> float:
    """What the working rows are worth: their number over the memory of the noise."""
    return float(ground.working.sum()) / ground.memory(*effects)


def search_library(ground: Ground, library: Library, earlier: CrossProducts | None = None) -> Searched:
    """Search on the working cycles until what they are worth is settled; products, outcome and that number.

    Args:
        ground: The joint.
        library: What is looked for.
        earlier: Products of an earlier search on the same cycles.
    """
    groups = [replace(entry.group, numbers=free_numbers(entry.shapes)) for entry in library.entries]
    products = cross_products(ground.y, ground.base, groups, ground.working, earlier)
    n_eff = worth(ground)
    outcome = search(products, n_eff)
    for _ in range(MOST_ROUNDS):
        better = worth(ground, *columns_of(library, outcome))
        if abs(better - n_eff) < SETTLED * n_eff:
            break
        n_eff = better
        outcome = search(products, n_eff)
    return products, outcome, n_eff


def _on_all_cycles(
    ground: Ground, library: Library, products: CrossProducts, outcome: Search, n_eff: float
) -> tuple[CrossProducts, float]:
    """What was found and the best shape of each rival, on all cycles, and what these are worth.

    The cycles on which a name was chosen flatter it before its rivals. Columns of all other units are zero.
    """
    active = [chosen.unit for chosen in outcome.chosen]
    if not active:
        return products, n_eff
    ranking = Ranking(products, n_eff)
    asked = dict.fromkeys(active)
    for unit in active:
        asked |= dict.fromkeys(best_shapes(ranking, [u for u in active if u != unit]).values())
    units = [products.units[u] for u in asked]
    groups = [
        Group(name=name, shapes=(library.entry(name).group.shapes[unit.shape],))
        for unit in units
        for name in (products.names[unit.group],)
    ]
    few = cross_products(ground.y, ground.base, groups)
    place = np.concatenate([[0], products.always, *(unit.columns for unit in units)])
    gram, scale = np.zeros_like(products.gram), np.ones_like(products.scale)
    few.fill(range(len(few.units)))
    gram[np.ix_(place, place)], scale[place] = few.gram, few.scale
    worth_of_all = len(ground.y) / ground.memory(*columns_of(library, outcome))
    return replace(products, gram=gram, filled=np.ones(len(gram), bool), kept=None, scale=scale), worth_of_all


def _plainly(ground: Ground, library: Library, searched: Searched) -> tuple[Library, Searched]:
    """A library and what was found, both without a richer shape that hardly adds to a plainer one of its candidate.

    What it adds may be what the plainer one's formula does not get right.
    """
    products, outcome, n_eff = searched
    ranking = Ranking(products, n_eff)
    for chosen in outcome.chosen:
        entry = library.entry(chosen.name)
        if not entry.candidate.needs_gain(entry.shapes[chosen.shape]):
            continue
        others = [one.unit for one in outcome.chosen if one is not chosen]
        rivals = [
            [*others, u]
            for u, unit in enumerate(products.units)
            if unit.group == products.units[chosen.unit].group
            and not entry.candidate.needs_gain(entry.shapes[unit.shape])
        ]
        without, with_it = ranking.rss(others), ranking.rss([*others, chosen.unit])
        plain = min((ranking.rss(units) for units in rivals if ranking.admissible(units, units[-1])), default=without)
        if plain - with_it < ADDS**2 * (without - plain):
            library = plainer(library, chosen.name)
            return library, search_library(ground, library, products)
    return library, searched


def unknowns(names: Names) -> int:
    """How many factors and numbers of shapes were fitted; which link it is, and the like, is a choice."""
    return sum(_unknowns(names.library, found) for found in names.found)


def _unknowns(library: Library, found: Found) -> int:
    shapes = library.entry(found.candidate.name).shapes
    choices = {parameter.name for parameter in found.candidate.nonlinear if parameter.whole}
    free = {name for name in found.shape if len({shape[name] for shape in shapes if name in shape}) > 1}
    return int(not_zero(found.columns).sum()) + len(free - choices)


def free_numbers(shapes: Sequence[Nonlinear]) -> tuple[int, ...]:
    """How many numbers each shape leaves free: those that differ among the shapes that have them."""
    values: dict[str, set[float]] = {}
    for shape in shapes:
        for name, value in shape.items():
            values.setdefault(name, set()).add(value)
    return tuple(sum(len(values[name]) > 1 for name in shape) for shape in shapes)


def _refined(
    ground: Ground,
    library: Library,
    outcome: Search,
    namings: Sequence[Naming],
    baseline: Nominal,
    jointly: Sequence[tuple[Nonlinear, Nominal]],
) -> list[Found]:
    """The effects found, their shapes refined one after the other, the strongest first.

    What was fitted together with the declared model stays: beside others it would make room for them.
    """
    columns = columns_of(library, outcome)
    found = []
    for k, (chosen, naming) in enumerate(zip(outcome.chosen, namings, strict=True)):
        entry = library.entry(chosen.name)
        base, shape = np.hstack([ground.base, *columns[:k], *columns[k + 1 :]]), entry.shapes[chosen.shape]
        if not any(shape is own for own, _ in jointly):
            shape = refine(entry.candidate, shape, entry.shapes, ground, baseline, base)
        if entry.candidate.moment:
            shape = _placed(ground, entry, shape, baseline, base)
        columns[k] = ground.rows.of(entry.candidate.regressor(ground.data, baseline, shape))
        found.append(Found(candidate=entry.candidate, shape=shape, columns=columns[k], naming=naming, p_value=1.0))
    return found


def _placed(ground: Ground, entry: Entry, shape: Nonlinear, baseline: Nominal, base: Float) -> Nonlinear:
    """The shape with its moment where all cycles have it, of those that the working ones do not tell from it.

    They put a moment that lies in a locked cycle anywhere in there.
    """
    w = ground.working
    own = ground.rows.of(entry.candidate.regressor(ground.data, baseline, shape))
    working, whole = Beside(base[w], ground.y[w]), Beside(base, ground.y)
    most = working.fit(own[w])[1] * float(np.exp(UNTOLD / worth(ground, base, own)))
    place, least = shape, whole.fit(own)[1]
    for other, columns in zip(entry.shapes, entry.columns, strict=True):
        if working.fit(columns[w])[1] <= most and (left := whole.fit(columns)[1]) < least:
            place, least = other, left
    every = replace(ground, working=np.ones_like(w))
    return refine(entry.candidate, place, entry.shapes, every, baseline, base)


def _largest_beside(small: Found, found: Sequence[Found], size: Float) -> float:
    """Size of the largest effect whose formula may lack what another one seems to be."""
    inexact = [not f.candidate.exact and small.candidate.may_absorb_error_of(f.candidate) for f in found]
    return float(size[inexact].max(initial=0.0))


def _accept(
    ground: Ground,
    found: list[Found],
    simpler: Mapping[str, Found],
    price: Mapping[str, float],
    alpha: float,
    rng: np.random.Generator,
    *,
    rejected: bool,
) -> tuple[tuple[Found, ...], tuple[str, ...]]:
    """Drop, the weakest first, what does not hold on the locked cycles, cannot be or is small beside the others.

    An effect gives way to an alternative that it holds within it or that has fewer numbers. Where the test over cycles
    does not see it, rows alone speak for it: then they are worth no more than the longest memory allows. What was
    dropped for anything but its size, with nothing in its place, is named beside what is left.
    """
    disproved: list[str] = []
    while found:
        proof = confirm(ground, [f.columns for f in found], rng)
        possible = [
            f.candidate.admissible(own, f.shape) or f.candidate.admissible(near, f.shape)
            for f, own, near in zip(found, proof.factors, proof.tolerated, strict=True)
        ]
        if (driver := driving(ground, [f.columns for f in found])) is not None:
            possible[driver] = False
        prices = np.array([price[f.candidate.name] for f in found])
        fails = ~(proof.proven(alpha) | proof.shown(prices)) | proof.misleads | ~np.array(possible)
        fails |= (proof.least_evidence <= prices) & (not rejected)
        small = proof.size < LEAST_SHARE * np.array([_largest_beside(f, found, proof.size) for f in found])
        fails, disproves = fails | small, fails
        if not fails.any():
            held = tuple(replace(f, p_value=float(p)) for f, p in zip(found, proof.p_value, strict=True))
            return held, tuple(disproved)
        weakest = int(np.argmin(np.where(fails, proof.gain, np.inf)))
        instead = simpler.get(found[weakest].candidate.name)
        there = {f.candidate.name for f in found}
        place = [instead] if instead is not None and instead.candidate.name not in there else []
        disproved += [found[weakest].candidate.name] if disproves[weakest] and not place else []
        found = [*found[:weakest], *place, *found[weakest + 1 :]]
    return (), tuple(disproved)
