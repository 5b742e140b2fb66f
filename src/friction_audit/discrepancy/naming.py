"""Which effects are missing: search on the working cycles, refine, and keep what holds on the locked ones."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.discrepancy.alternatives import ALIKE, Naming, name_effects
from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.confirmation import LEAST_GAIN, confirm, rms_gain
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.library import Library, extend_library, rebuild_library
from friction_audit.discrepancy.refine import refine
from friction_audit.discrepancy.search import CycleProducts, Search, cycle_products, search
from friction_audit.joint_log import Float

MOST_ROUNDS = 4
"""Of search and counting what the rows are worth; the memory of the residual shrinks as effects are found."""
SETTLED = 0.05
NEAR = 60.0
"""Difference in BIC up to which a rival may win once its shape is as good as that of what was found."""
MOST_RIVALS = 2
LEAST_SHARE = 0.2
"""An effect that is smaller than this share of a larger one may be what that one's formula does not get right."""


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

    candidate: Candidate
    shape: Shape
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
    """

    found: tuple[Found, ...]
    library: Library
    baseline: Baseline


def find_names(
    ground: Ground, candidates: Sequence[Candidate], library: Library, alpha: float, rng: np.random.Generator
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
    """
    baseline = ground.baseline()
    products, outcome, n_eff = search_library(ground, library)
    if outcome.chosen:
        baseline = ground.baseline(*_columns(library, outcome))
        library = rebuild_library(library, ground.data, baseline, ground.rows)
        library = extend_library(library, _sharpened(ground, library, outcome, products, n_eff, baseline))
        products, outcome, n_eff = search_library(ground, library)
    same = {candidate.name: candidate.same_as for candidate in candidates}
    namings = name_effects(products, outcome, n_eff, same)
    found = _refined(ground, library, outcome, namings, baseline)
    return Names(found=_accept(ground, found, alpha, rng), library=library, baseline=baseline)


def worth(ground: Ground, *effects: Float) -> float:
    """What the working rows are worth: their number over the memory of the noise."""
    return float(ground.working.sum()) / ground.memory(*effects)


def search_library(ground: Ground, library: Library) -> tuple[CycleProducts, Search, float]:
    """Search on the working cycles until what they are worth is settled; products, outcome and that number."""
    w = ground.working
    groups = [entry.group.keep(w) for entry in library.entries]
    products = cycle_products(ground.y[w], ground.base[w], groups, ground.rows.cycle[w])
    n_eff = worth(ground)
    outcome = search(products, n_eff)
    for _ in range(MOST_ROUNDS):
        better = worth(ground, *_columns(library, outcome))
        if abs(better - n_eff) < SETTLED * n_eff:
            break
        n_eff = better
        outcome = search(products, n_eff)
    return products, outcome, n_eff


def _columns(library: Library, outcome: Search) -> list[Float]:
    return [library.entry(chosen.name).group.shapes[chosen.shape] for chosen in outcome.chosen]


def _sharpened(
    ground: Ground, library: Library, outcome: Search, products: CycleProducts, n_eff: float, baseline: Baseline
) -> Iterator[tuple[str, Shape, Float]]:
    """Refined shapes of the effects found and of the rivals that come near them, with their columns."""
    columns = _columns(library, outcome)
    for k, (chosen, naming) in enumerate(zip(outcome.chosen, name_effects(products, outcome, n_eff, {}), strict=True)):
        base = np.hstack([ground.base, *columns[:k], *columns[k + 1 :]])
        near = [r for r in naming.rivals if r.correlation > ALIKE and r.delta_bic < NEAR][:MOST_RIVALS]
        for name, at in ((chosen.name, chosen.shape), *((rival.name, rival.shape) for rival in near)):
            entry = library.entry(name)
            shape = refine(entry.candidate, entry.shapes[at], entry.shapes, ground, baseline, base)
            if shape != entry.shapes[at]:
                yield name, shape, ground.rows.of(entry.candidate.columns(ground.data, baseline, shape))


def _refined(
    ground: Ground, library: Library, outcome: Search, namings: Sequence[Naming], baseline: Baseline
) -> list[Found]:
    """The effects found, their shapes refined one after the other, the strongest first."""
    columns = _columns(library, outcome)
    found = []
    for k, (chosen, naming) in enumerate(zip(outcome.chosen, namings, strict=True)):
        entry = library.entry(chosen.name)
        base = np.hstack([ground.base, *columns[:k], *columns[k + 1 :]])
        shape = refine(entry.candidate, entry.shapes[chosen.shape], entry.shapes, ground, baseline, base)
        columns[k] = ground.rows.of(entry.candidate.columns(ground.data, baseline, shape))
        found.append(Found(candidate=entry.candidate, shape=shape, columns=columns[k], naming=naming, p_value=1.0))
    return found


def _accept(ground: Ground, found: list[Found], alpha: float, rng: np.random.Generator) -> tuple[Found, ...]:
    """Drop, the weakest first, what does not hold on the locked cycles or is small beside the others."""
    while found:
        judged, gains, sizes = _judge(ground, found, rng)
        fails = [
            f.p_value > alpha or gain < LEAST_GAIN or size < LEAST_SHARE * sizes.max()
            for f, gain, size in zip(judged, gains, sizes, strict=True)
        ]
        if not any(fails):
            return tuple(judged)
        weakest = min((k for k, fail in enumerate(fails) if fail), key=lambda k: gains[k])
        found = judged[:weakest] + judged[weakest + 1 :]
    return ()


def _judge(ground: Ground, found: list[Found], rng: np.random.Generator) -> tuple[list[Found], Float, Float]:
    """P-value of each effect on locked cycles, the share of the root mean square that it removes, and its size."""
    locked = ground.locked
    columns = [f.columns for f in found]
    p = confirm(ground, columns, rng)
    after = float(np.sum(ground.residual(*columns)[locked] ** 2))
    without = [ground.residual(*(g.columns for g in found if g is not f)) for f in found]
    before = np.array([np.sum(r[locked] ** 2) for r in without])
    gains = np.array([rms_gain(float(one), after) for one in before])
    sizes = np.sqrt(np.maximum(before - after, 0.0) / locked.sum())
    return [replace(f, p_value=float(one)) for f, one in zip(found, p, strict=True)], gains, sizes
