"""What effects are worth, alone and together, by what the samples are worth.

References:
    D. P. Foster, E. I. George, The risk inflation criterion for multiple regression, Annals of Statistics 22 (1994)
    1947: a column must bring more than the best of all those tried brings by chance.
"""

from collections.abc import Callable, Sequence

import numpy as np

from friction_audit.diagnosis.cross_products import MIN_FRACTION_LEFT, CrossProducts, Unit, eigen_root
from friction_audit.diagnosis.gram import Index
from friction_audit.joint_log import Float

BY_CHANCE = 0.01
"""Probability that anything enters where nothing is missing, all candidates and shapes together."""


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
        left, projected = eigen_root(self.gram[np.ix_(cols, cols)]), self.gram[cols]
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

    def is_better(self, trial: Sequence[int], active: Sequence[int]) -> bool:
        """Whether one set has the higher objective, by more than rounding."""
        return self.objective(trial) > self.objective(active) + 1e-9 * self.n_eff

    def worth(self, active: Sequence[int], unit: int) -> float:
        """Score of one effect given all the others."""
        return self.objective(active) - self.objective([u for u in active if u != unit])


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
