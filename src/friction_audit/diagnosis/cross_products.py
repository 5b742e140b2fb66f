"""Cross products of response, declared model and candidates: all that a search needs of the samples.

References:
    N. W. Galwey, A new measure of the effective number of tests, Genetic Epidemiology 33 (2009) 559.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.gram import Index, fill_in, places_of, products_within
from friction_audit.diagnosis.groups import Group
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

MIN_FRACTION_LEFT = 1e-8
"""Share of a column's square that must be left after what is in the model: below it, the column is a copy."""


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
        begun: Columns of which an earlier search knew the products with all others that it had, shape (k,).
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
    begun: NDArray[np.bool_]
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
        for begun in (True, False):  # those that lack fewer products by themselves
            if some := [column for column in wanted if self.begun[column] == begun]:
                fill_in(self.gram, self.columns, some, self.kept, self.scale)
                self.filled[some] = True

    def fill_pairs(self, units: Sequence[int]) -> None:
        """Compute the products of the columns of some units with each other."""
        unknown = [unit for unit in units if not self.filled[self.units[unit].columns].all()]
        self.fill(unknown[1:])


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
    gram, begun = _known(columns, earlier)
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite stays so, and is told
        _within_groups(gram, columns, units, kept)
        fill_in(gram, columns, always, kept)
    scale = np.sqrt(np.diag(gram) / (len(y) if kept is None else np.count_nonzero(kept)))
    if not np.all(np.isfinite(scale)):
        raise AnalysisError("search: response, base or candidates hold values that are not finite; leave them out")
    scale[scale == 0.0] = 1.0
    gram /= scale[:, None] * scale
    return CrossProducts(
        gram=gram,
        filled=np.arange(len(gram)) < len(always),
        begun=begun,
        kept=kept,
        scale=scale,
        columns=tuple(columns),
        base=base.shape[1],
        names=tuple(group.name for group in groups),
        units=units,
        trials=tuple(_trials(gram, base.shape[1], own) for own in shapes),
        admissible=tuple(group.admissible for group in groups),
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


def _known(columns: Sequence[Float], earlier: CrossProducts | None) -> tuple[Float, NDArray[np.bool_]]:
    """Products of columns that an earlier search knew, no numbers for others, (k, k); and where it had begun, (k,)."""
    own = places_of(columns)
    gram, begun = np.full((sum(map(len, own)),) * 2, np.nan), np.zeros(sum(map(len, own)), np.bool_)
    if earlier is not None:
        places = {id(column): place for column, place in zip(earlier.columns, places_of(earlier.columns), strict=True)}
        known = [k for k, column in enumerate(columns) if id(column) in places]
        here = np.concatenate([own[k] for k in known])
        there = np.concatenate([places[id(columns[k])] for k in known])
        scale = earlier.scale[there]
        gram[np.ix_(here, here)] = earlier.gram[np.ix_(there, there)] * (scale[:, None] * scale)
        begun[here] = earlier.filled[there]
    return gram, begun


def _within_groups(
    gram: Float, columns: Sequence[Float], units: Sequence[Unit], kept: NDArray[np.bool_] | None
) -> None:
    """Write the products of the columns of each candidate with each other where they are not known."""
    for group in dict.fromkeys(unit.group for unit in units):
        numbers = [k for k, unit in enumerate(units) if unit.group == group]
        own = np.concatenate([units[k].columns for k in numbers])
        gram[np.ix_(own, own)] = products_within([columns[2 + k] for k in numbers], kept, gram[np.ix_(own, own)])


def _trials(gram: Float, base: int, shapes: Sequence[Index]) -> float:
    """How many independent trials neighbouring shapes of one candidate are worth (Galwey 2009), at least 1.

    With the eigenvalues l of the correlation matrix of all columns free of the base they are (sum l^1/2)^2 / sum l
    columns, to be divided by those of one shape.
    """
    every, always = np.concatenate(shapes), np.arange(1, 1 + base)
    inside = eigen_root(gram[np.ix_(always, always)]) @ gram[np.ix_(always, every)]
    free = gram[np.ix_(every, every)] - inside.T @ inside
    left = np.diag(free) > MIN_FRACTION_LEFT * np.diag(gram)[every]
    if not left.any():
        return 1.0
    size = np.sqrt(np.diag(free)[left])
    value = np.clip(np.linalg.eigvalsh(free[np.ix_(left, left)] / size[:, None] / size), 0.0, None)
    columns = float(np.sum(np.sqrt(value)) ** 2 / value.sum())
    return max(1.0, columns * len(shapes) / int(left.sum()))


def eigen_root(gram: Float) -> Float:
    """L with L' L = the pseudoinverse of a matrix of cross products, shape (a, a)."""
    value, vector = np.linalg.eigh(gram)
    good = value > 1e-12 * value[-1]
    root: Float = np.where(good, 1.0 / np.sqrt(np.where(good, value, 1.0)), 0.0)[:, None] * vector.T
    return root
