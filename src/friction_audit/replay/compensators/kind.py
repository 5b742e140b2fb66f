"""What a kind of compensator is, and the numbers by which compiled code tells the kinds apart."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

NONE, FIXED, ENERGY, SIGMOID, LUGRE, DISTURBANCE_OBSERVER, TORQUE_REGULATION, JOINT_MODEL = range(8)
"""Values of ``kind`` in the records."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class CompensatorKind:
    """One kind of compensator.

    Attributes:
        name: As in options, tables and documentation; also the field of the records that holds its group.
        summary: One line.
        settings: Frozen dataclass of what it may be told; NoneType where nothing runs.
        code: Value of ``kind`` in the records.
        group: Numbers that only its own law reads; None if it has none.
    """

    name: str
    summary: str
    settings: type[Any]
    code: int
    group: np.dtype[np.void] | None = None


def numbers_of(settings: type[Any]) -> np.dtype[np.void]:
    """Return a record type with the plain numbers of a settings dataclass, by their names."""
    return np.dtype([(item.name, "f8") for item in fields(settings) if item.type is float])
