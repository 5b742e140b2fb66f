"""Which effects to add: forward search with exchange and backward deletion, judged by what the samples are worth.

References:
    D. P. Foster, E. I. George, The risk inflation criterion for multiple regression, Annals of Statistics 22 (1994)
    1947: a column must bring more than the best of all those tried brings by chance.
    N. W. Galwey, A new measure of the effective number of tests, Genetic Epidemiology 33 (2009) 559.
    P. Pudil et al., Floating search methods in feature selection, Pattern Recognition Letters 15 (1994) 1119.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.gram import Known, places_of, products_with_all, products_within
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

Index = NDArray[np.int64]
MIN_FRACTION_LEFT = 1e-8
"""Share of a column's square that must be left after what is in the model: below it, the column is a copy."""
PROMISING = 8
"""Candidates that are tried as the first of two in the place of one."""
BY_CHANCE = 0.01
"""Probability that anything enters where nothing is missing, all candidates and shapes together."""
MAX_ROUNDS = 50
"""Rounds of exchange and recombination; each raises the objective, so that only rounding could go on."""


def any_factors(_factors: Float, _shape: int) -> bool:
    """The rule of a candidate whose factors may have any sign and size."""
    return True


def not_zero(columns: Float) -> NDArray[np.bool_]:
    """Which columns, shape (n, p), hold anything but zeros, shape (p,)."""
    # One row mostly tells: thousands of columns are asked.
    there = columns[len(columns) // 2 : len(columns) // 2 + 1].any(axis=0)
    return np.asarray(there if there.all() else columns.any(axis=0))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Group:
    """The columns of one candidate, which enter together.

    Attributes:
        name: Name of the candidate.
        shapes: Columns for each value of the shape, each of shape (n, p).
        admissible: ``admissible(factors, shape)`` with factors (p,) and the index of the shape: physically possible?
        numbers: How many numbers each shape leaves free; none where it is empty.
        tried: Of how many independent trials each shape was the best, where those of all shapes here are fewer; none
            where it is empty.
    """

    name: str
    shapes: tuple[Float, ...]
    admissible: Callable[[Float, int], bool] = any_factors
    numbers: tuple[int, ...] = ()
    tried: tuple[float, ...] = ()

    def keep(self, kept: NDArray[np.bool_]) -> "Group":
        """The same on some of the samples, shape (n,)."""
        places = np.flatnonzero(kept)
        return replace(self, shapes=tuple(shape.T.take(places, axis=1).T for shape in self.shapes))

    def narrow(self, widest: int) -> "Group | None":
        """The same without columns that are zero and without shapes that are wider; None if none is left.

        Factors of the outcome have no names any more, so that it is good for a test, not for a search.
        """
        used = [shape if (there := not_zero(shape)).all() else shape[:, there] for shape in self.shapes]
        kept = tuple(shape for shape in used if 0 < shape.shape[1] <= widest)
        return Group(name=self.name, shapes=kept) if kept else None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Unit:
    """One candidate with one shape: what can enter a model.

    Attributes:
        group: Index of the candidate.
        shape: Index of the shape.
        columns: Columns of the products, shape (p,).
        numbers: How many numbers the shape leaves free.
        tried: Of how many independent trials it was the best, where those of the candidate's shapes are fewer.
    """

    group: int
    shape: int
    columns: Index
    numbers: int = 0
    tried: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class CrossProducts:
    """Cross products of response, base and candidates: all that a search needs of the samples.

    Columns are in the order response, base (b), units, and have a root mean square of 1, so that nothing depends on
    units of measurement. A search looks at those of a candidate's columns with each other, and of the columns of a few
    units with all: most are never asked for, and are no numbers until ``fill`` computes them.

    Attributes:
        gram: Shape (k, k).
        filled: Columns whose products with all others are known, shape (k,).
        kept: Samples that count, all if None, shape (n,).
        scale: Root mean square of each column, shape (k,).
        columns: Response, base and candidates that they are of, shape (n, p) each.
        base: Number of base columns.
        names: Names of the candidates.
        units: All candidates with all their shapes.
        trials: Independent trials that the shapes of each candidate are worth.
        admissible: Rule of each candidate.
    """

    gram: Float
    filled: NDArray[np.bool_]
    kept: NDArray[np.bool_] | None
    scale: Float
    columns: tuple[Float, ...]
    base: int
    names: tuple[str, ...]
    units: tuple[Unit, ...]
    trials: tuple[float, ...]
    admissible: tuple[Callable[[Float, int], bool], ...]

    @property
    def always(self) -> Index:
        """Columns of the base, shape (b,)."""
        return np.arange(1, 1 + self.base)

    def fill(self, units: Sequence[int]) -> None:
        """Compute the products of the columns of some units with all others, as far as they are not known."""
        wanted = [column for unit in units for column in self.units[unit].columns if not self.filled[column]]
        if not wanted:
            return
        rows = products_with_all(self.columns, wanted, self.kept) / (self.scale[wanted, None] * self.scale)
        self.gram[wanted], self.gram[:, wanted] = rows, rows.T
        self.filled[wanted] = True

    def fill_pairs(self, units: Sequence[int]) -> None:
        """Compute the products of the columns of some units with each other."""
        unknown = [unit for unit in units if not self.filled[self.units[unit].columns].all()]
        self.fill(unknown[1:])


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


def cross_products(
    y: Float,
    base: Float,
    groups: Sequence[Group],
    kept: NDArray[np.bool_] | None = None,
    earlier: CrossProducts | None = None,
) -> CrossProducts:
    """Reads the samples once.

    Args:
        y: Response, shape (n,).
        base: Columns that are always in the model, shape (n, b).
        groups: Candidates.
        kept: Samples that count, all if None, shape (n,).
        earlier: Products on the same samples; those of two of its columns are not computed again.

    Raises:
        AnalysisError: A value is not finite.
    """
    columns, units = _columns(y, base, groups)
    shapes = [[unit.columns for unit in units if unit.group == g] for g in range(len(groups))]
    always = list(range(1 + base.shape[1]))
    gram = _within_groups(columns, units, kept, earlier)
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite stays so, and is told
        gram[always] = products_with_all(columns, always, kept)
    gram[:, always] = gram[always].T
    scale = np.sqrt(np.diag(gram) / (len(y) if kept is None else np.count_nonzero(kept)))
    if not np.all(np.isfinite(scale)):
        raise AnalysisError("search: response, base or candidates hold values that are not finite; leave them out")
    scale[scale == 0.0] = 1.0
    gram /= scale[:, None] * scale
    return CrossProducts(
        gram=gram,
        filled=np.arange(len(gram)) < len(always),
        kept=kept,
        scale=scale,
        columns=tuple(columns),
        base=base.shape[1],
        names=tuple(group.name for group in groups),
        units=units,
        trials=tuple(_trials(gram, base.shape[1], own) for own in shapes),
        admissible=tuple(group.admissible for group in groups),
    )


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
    state = Ranking(products, n_eff)
    active: list[int] = []
    while (best := state.best_addition(active)) is not None:
        settled = state.settle([*active, best])
        # What came in may make impossible what was there: no search ends with less than it had.
        if not state.is_better(settled, active):
            break
        active = settled
    return state.result(active)


class Ranking:
    """Scores of sets of units."""

    def __init__(self, products: CrossProducts, n_eff: float) -> None:
        self.products = products
        self.gram = products.gram
        self.n_eff = n_eff
        self.diagonal = np.diag(self.gram)
        self.by_width = _by_width(products.units)
        self.group = np.array([unit.group for unit in products.units], dtype=np.int64)
        # A term may have more factors than one of its shapes uses; columns that are zero cost nothing.
        self.width = np.array([np.count_nonzero(self.diagonal[unit.columns]) for unit in products.units])
        self.penalty = _by_chance(products, self.width)
        self.additions: dict[frozenset[int], int | None] = {}
        self.objectives: dict[frozenset[int], float] = {}

    def columns(self, active: Sequence[int]) -> Index:
        """Columns of the base and of some units."""
        return np.concatenate([self.products.always, *(self.products.units[u].columns for u in active)])

    def factors(self, active: Sequence[int]) -> Float:
        """Factors of all columns fitted together, of columns with a root mean square of 1."""
        self.products.fill_pairs(active)
        cols = self.columns(active)
        solved: Float = np.linalg.lstsq(self.gram[np.ix_(cols, cols)], self.gram[cols, 0], rcond=1e-12)[0]
        return solved

    def rss(self, active: Sequence[int]) -> float:
        """Residual sum of squares of the scaled response."""
        cols = self.columns(active)
        return max(float(self.gram[0, 0] - self.gram[cols, 0] @ self.factors(active)), 1e-14 * float(self.gram[0, 0]))

    def objective(self, active: Sequence[int]) -> float:
        """What the search makes large: n_eff ln(1 / RSS) less what chance gives each."""
        # Exchange and deletion come by the same sets again and again.
        known = self.objectives.get(key := frozenset(active))
        if known is None:
            known = float(-self.n_eff * np.log(self.rss(active)) - self.penalty[list(active)].sum())
            self.objectives[key] = known
        return known

    def admissible(self, active: Sequence[int], unit: int) -> bool:
        """Whether one unit's factors are possible with everything fitted together."""
        entry = self.products.units[unit]
        return self.products.admissible[entry.group](self.unit_factors(active, unit), entry.shape)

    def unit_factors(self, active: Sequence[int], unit: int) -> Float:
        """Factors of one unit in its own unit of measurement, shape (p,)."""
        cols = self.products.units[unit].columns
        place = np.searchsorted(np.sort(self.columns(active)), cols)
        ordered = self.factors(active)[np.argsort(self.columns(active))][place]
        return np.asarray(ordered * self.products.scale[0] / self.products.scale[cols])

    def reductions(self, active: Sequence[int]) -> Float:
        """By how much each unit alone would lower the residual sum of squares, shape (m,); 0 for copies."""
        return self._joined(active)[0]

    def _joined(self, active: Sequence[int]) -> tuple[Float, Float]:
        """The same, and each unit's factors once it is added, of columns with a root mean square of 1, shape (m, p).

        With the residualised products R = W'M W and r = W'M y they are r' R^-1 r and R^-1 r (Frisch and Waugh 1933).
        """
        self.products.fill(active)
        cols = self.columns(active)
        left, projected = _eigen_root(self.gram[np.ix_(cols, cols)]), self.gram[cols]
        inside = left @ projected
        outcome = np.zeros(len(self.products.units))
        factors = np.zeros((len(outcome), max((table.shape[1] for _, table in self.by_width), default=0)))
        for where, table in self.by_width:
            outcome[where], factors[where, : table.shape[1]] = self._joined_of(table, inside)
        return outcome, factors

    def _joined_of(self, table: Index, inside: Float) -> tuple[Float, Float]:
        """The same for units of one width, columns (m, p)."""
        taken = inside[:, table]
        r = self.gram[table, 0] - np.einsum("amp,a->mp", taken, inside[:, 0])
        R = self.gram[table[:, :, None], table[:, None, :]] - np.einsum("amp,amq->mpq", taken, taken)
        own = self.diagonal[table]
        norm = np.sqrt(np.where(own > 0, own, 1.0))
        R = R / (norm[:, :, None] * norm[:, None, :])
        value, vector = np.linalg.eigh(R)
        good = value > MIN_FRACTION_LEFT
        along = np.einsum("mpe,mp->me", vector, r / norm)
        solved = np.where(good, along / np.where(good, value, 1.0), 0.0)
        return np.sum(along * solved, axis=1), np.einsum("mpe,me->mp", vector, solved) / norm

    def scores(self, active: Sequence[int]) -> Float:
        """Score of adding each unit, shape (m,); minus infinity for candidates already in."""
        return self.tried(active)[0]

    def tried(self, active: Sequence[int]) -> tuple[Float, Callable[[int], bool]]:
        """The same, and whether a unit's factors are possible once it is added."""
        rss = self.rss(active)
        reductions, factors = self._joined(active)
        left = np.maximum(rss - reductions, 1e-14 * float(self.gram[0, 0]))
        score: Float = self.n_eff * np.log(rss / left) - self.penalty
        score[np.isin(self.group, [self.group[u] for u in active])] = -np.inf

        def possible(unit: int) -> bool:
            entry, scale = self.products.units[unit], self.products.scale
            own = factors[unit, : len(entry.columns)] * scale[0] / scale[entry.columns]
            return self.products.admissible[entry.group](own, entry.shape)

        return score, possible

    def best_addition(self, active: Sequence[int]) -> int | None:
        """The unit with the highest score above 0 whose factors are possible; None if there is none."""
        key = frozenset(active)
        if key not in self.additions:
            score, possible = self.tried(active)
            ordered = np.argsort(-score, kind="stable").tolist()
            self.additions[key] = next((u for u in ordered[: np.count_nonzero(score > 0.0)] if possible(u)), None)
        return self.additions[key]

    def nearly(self, active: Sequence[int], lacking: float) -> list[tuple[str, int]]:
        """Names and best possible shapes of candidates that lack less than so much to come in, the best first."""
        score, possible = self.tried(active)
        best: dict[str, int] = {}
        for unit in np.argsort(-score, kind="stable").tolist():
            entry = self.products.units[unit]
            name = self.products.names[entry.group]
            if score[unit] > -lacking and name not in best and possible(unit):
                best[name] = entry.shape
        return list(best.items())

    def settle(self, active: list[int]) -> list[int]:
        """Deletes, exchanges and recombines until nothing raises the objective."""
        active = self._delete(active)
        for _ in range(MAX_ROUNDS):
            kept = self._best([self._exchange(active)], active) or self._best(self._recombined(active), active)
            if kept is None:
                break
            active = kept
        return active

    def is_better(self, trial: Sequence[int], active: Sequence[int]) -> bool:
        """Whether one set has the higher objective, by more than rounding."""
        return self.objective(trial) > self.objective(active) + 1e-9 * self.n_eff

    def _best(self, trials: Sequence[list[int]], active: list[int]) -> list[int] | None:
        """The best of some sets, less what is impossible or worthless in it; None where none is better than another.

        A set may look better only by an effect that is impossible without a companion that is worth nothing.
        """
        for trial in sorted(trials, key=self.objective, reverse=True):
            if not self.is_better(trial, active):
                break
            if self.is_better(kept := self._delete(trial), active):
                return kept
        return None

    def _recombined(self, active: list[int]) -> list[list[int]]:
        """Sets with one effect replaced by two, or two by one."""
        return [*self._one_by_two(active), *self._two_by_one(active)]

    def _one_by_two(self, active: list[int]) -> Iterator[list[int]]:
        """Sets in which two units stand in the place of one; the first of the two among the most promising."""
        for place in range(len(active)):
            others = active[:place] + active[place + 1 :]
            promising = self._best_of_groups(others)
            self.products.fill(promising)  # at once, for each time all samples are read
            for first in promising:
                second = self.best_addition([*others, first])
                if second is not None and self.admissible([*others, first, second], first):
                    yield [*others, first, second]

    def _two_by_one(self, active: list[int]) -> Iterator[list[int]]:
        """Sets in which one unit stands in the place of two."""
        for pair in combinations(active, 2):
            others = [u for u in active if u not in pair]
            best = self.best_addition(others)
            if best is not None:
                yield [*others, best]

    def _best_of_groups(self, others: list[int]) -> list[int]:
        """The best shape of each of the candidates with the highest scores."""
        score = self.scores(others)
        best: dict[int, int] = {}
        for unit in np.argsort(-score, kind="stable"):
            if np.isfinite(score[unit]):
                best.setdefault(self.products.units[int(unit)].group, int(unit))
        return list(best.values())[:PROMISING]

    def _exchange(self, active: list[int]) -> list[int]:
        """Replaces each effect by what serves better in its place."""
        for place in range(len(active)):
            others = active[:place] + active[place + 1 :]
            best = self.best_addition(others)
            if best is None or best == active[place]:
                continue
            trial = [*active[:place], best, *active[place + 1 :]]
            if self.is_better(trial, active):
                active = trial
        return active

    def _delete(self, active: list[int]) -> list[int]:
        """Removes, the worst first, effects that are not worth their penalty or are impossible among the others."""
        while active:
            worth = [self.worth(active, u) if self.admissible(active, u) else -np.inf for u in active]
            worst = int(np.argmin(worth))
            if worth[worst] > 0:
                break
            active = active[:worst] + active[worst + 1 :]
        return active

    def worth(self, active: Sequence[int], unit: int) -> float:
        """Score of one effect given all the others."""
        return self.objective(active) - self.objective([u for u in active if u != unit])

    def result(self, active: list[int]) -> Search:
        """The outcome in the units of the columns."""
        chosen = [self._chosen(active, u) for u in active]
        scale = self.products.scale
        return Search(
            chosen=tuple(sorted(chosen, key=lambda c: -c.score)),
            rss=self.rss(active) * float(scale[0]) ** 2,
        )

    def _chosen(self, active: list[int], unit: int) -> Chosen:
        entry = self.products.units[unit]
        return Chosen(
            name=self.products.names[entry.group],
            unit=unit,
            shape=entry.shape,
            factors=tuple(float(f) for f in self.unit_factors(active, unit)),
            score=self.worth(active, unit),
        )


def _columns(y: Float, base: Float, groups: Sequence[Group]) -> tuple[list[Float], tuple[Unit, ...]]:
    """All columns, shape (n, p) each or (n,), and where each unit's are."""
    columns, units, start = [y, base], [], 1 + base.shape[1]
    for g, group in enumerate(groups):
        for s, shape in enumerate(group.shapes):
            columns.append(shape)
            columns_of_shape = np.arange(start, start + shape.shape[1])
            numbers = group.numbers[s] if group.numbers else 0
            tried = group.tried[s] if group.tried else 0.0
            units.append(Unit(group=g, shape=s, columns=columns_of_shape, numbers=numbers, tried=tried))
            start += shape.shape[1]
    return columns, tuple(units)


def _within_groups(
    columns: Sequence[Float], units: Sequence[Unit], kept: NDArray[np.bool_] | None, earlier: CrossProducts | None
) -> Float:
    """Products of the columns of each candidate with each other, no numbers for the others, shape (k, k)."""
    known = None if earlier is None else _known(earlier)
    gram = np.full((sum(map(len, places_of(columns))),) * 2, np.nan)
    for group in dict.fromkeys(unit.group for unit in units):
        numbers = [k for k, unit in enumerate(units) if unit.group == group]
        own = np.concatenate([units[k].columns for k in numbers])
        with np.errstate(invalid="ignore", over="ignore"):  # what is not finite stays so, and is told
            gram[np.ix_(own, own)] = products_within([columns[2 + k] for k in numbers], kept, known)
    return gram


def _known(products: CrossProducts) -> Known:
    """Products of each candidate's columns with each other, of the columns as they were."""
    places = {id(column): unit.columns for column, unit in zip(products.columns[2:], products.units, strict=True)}
    return Known(gram=products.gram, scale=products.scale, places=places)


def _trials(gram: Float, base: int, shapes: Sequence[Index]) -> float:
    """How many independent trials neighbouring shapes of one candidate are worth (Galwey 2009), at least 1.

    With the eigenvalues l of the correlation matrix of all columns free of the base they are (sum l^1/2)^2 / sum l
    columns, to be divided by those of one shape.
    """
    every, always = np.concatenate(shapes), np.arange(1, 1 + base)
    inside = _eigen_root(gram[np.ix_(always, always)]) @ gram[np.ix_(always, every)]
    free = gram[np.ix_(every, every)] - inside.T @ inside
    left = np.diag(free) > MIN_FRACTION_LEFT * np.diag(gram)[every]
    if not left.any():
        return 1.0
    size = np.sqrt(np.diag(free)[left])
    value = np.clip(np.linalg.eigvalsh(free[np.ix_(left, left)] / size[:, None] / size), 0.0, None)
    columns = float(np.sum(np.sqrt(value)) ** 2 / value.sum())
    return max(1.0, columns * len(shapes) / int(left.sum()))


def _by_chance(products: CrossProducts, width: Index) -> Float:
    """What each unit is allowed to bring by chance, shape (m,)."""
    from scipy.special import chdtri

    own = np.array([max(products.trials[unit.group], unit.tried) for unit in products.units])
    trials = len(products.names) * own
    quantile: Float = chdtri(np.maximum(width, 1), BY_CHANCE / np.maximum(trials, 1.0))
    return quantile


def _by_width(units: Sequence[Unit]) -> list[tuple[Index, Index]]:
    """Units of equal width together: their numbers (m,) and their columns (m, p)."""
    width = np.array([len(unit.columns) for unit in units], dtype=np.int64)
    numbers = [np.flatnonzero(width == p) for p in np.unique(width)]
    return [(where, np.stack([units[int(u)].columns for u in where])) for where in numbers]


def _eigen_root(gram: Float) -> Float:
    """L with L' L = the pseudoinverse of a matrix of cross products, shape (a, a)."""
    value, vector = np.linalg.eigh(gram)
    good = value > 1e-12 * value[-1]
    root: Float = np.where(good, 1.0 / np.sqrt(np.where(good, value, 1.0)), 0.0)[:, None] * vector.T
    return root
