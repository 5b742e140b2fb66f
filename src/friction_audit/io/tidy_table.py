"""TidyTable: a result as columns with units in their names, joint by joint; what becomes a file, a topic or a frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

Column = NDArray[Any] | Sequence[Any]  # numbers (NaN where there is none), flags, or words


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointRows:
    """The rows of one joint."""

    joint: int  # number for people
    name: str  # name in the log
    columns: Mapping[str, Column]  # by name, all of one length

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TidyTable:
    """A table: one row per joint and the quantity of its name."""

    name: str  # what a file of it is called
    summary: str  # what a row is, in a line
    types: Mapping[str, type]  # what is in each column: str, int, float or bool
    time: str | None  # the column that says when a row was known [s], None for what the whole log says
    rows: tuple[JointRows, ...]  # joint after joint
