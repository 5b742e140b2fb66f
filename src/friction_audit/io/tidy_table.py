"""TidyTable: a result as columns with units in their names, joint by joint; what becomes a file, a topic or a frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Column = NDArray[Any] | Sequence[Any]
"""Numbers (NaN where there is none), flags, or words."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointRows:
    """The rows of one joint.

    Attributes:
        joint: Number for people.
        name: Name in the log.
        columns: By name, all of one length.
    """

    joint: int
    name: str
    columns: Mapping[str, Column]

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(next(iter(self.columns.values())))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TidyTable:
    """A table: one row per joint and the quantity of its name.

    Attributes:
        name: What a file of it is called.
        summary: What a row is, in a line.
        types: What is in each column: ``str``, ``int``, ``float`` or ``bool``.
        time: The column that says at which moment of the log a row was known [s], or None for what the whole log says.
        rows: The rows, joint after joint.
    """

    name: str
    summary: str
    types: Mapping[str, type]
    time: str | None
    rows: tuple[JointRows, ...]

    def __len__(self) -> int:
        """Return how many rows there are."""
        return sum(map(len, self.rows))


def as_column(values: Sequence[Any], kind: type) -> Column:
    """Return values as a column: numbers as an array, NaN for None."""
    if kind is float:
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return list(values)
