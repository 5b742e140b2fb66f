"""Group: the columns of one candidate, for every value of its shape."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float


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
