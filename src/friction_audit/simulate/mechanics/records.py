"""Settings of joints -> records of numbers that compiled code reads by name."""

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any, get_type_hints

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulate.effects.frictional_lag import LAG_MEMORY
from friction_audit.simulate.effects.presliding import BRISTLES

STATE = np.dtype(
    [
        ("driven", "?"),  # the motor is on the outer side of the sensor
        ("start_rad", "f8"),  # where the joint was at the start
        ("rest_s", "f8"),  # time since the joint came to rest
        ("speed_seen", "f8"),  # speed that the velocity-dependent part of friction sees
        ("warmth", "f8"),  # 0 cold, 1 warm
        ("port_nm", "f8"),  # torque through the sensor, lagging by one step
        ("compensation_nm", "f8"),  # torque of compensator and passivity controller, held from tick to tick
        ("passivity_nm", "f8"),  # the passivity controller's part of it
        ("unlogged_nm", "f8"),  # torque of a compensator that no log names, held likewise
        ("dissipated_j", "f8"),  # what friction has taken so far
        ("bristles", "f8", (BRISTLES,)),
        ("lag", "f8", (LAG_MEMORY,)),
    ],
    align=True,
)
"""What a joint remembers, apart from position and velocity."""


def record_type(group: type[Any]) -> np.dtype[Any]:
    """Return the record type of a dataclass of numbers and of such dataclasses."""
    hints = get_type_hints(group)
    return np.dtype([(item.name, _field_type(hints[item.name])) for item in fields(group)], align=True)


def _field_type(hint: Any) -> Any:  # noqa: ANN401 - a type
    return (
        record_type(hint)
        if isinstance(hint, type) and is_dataclass(hint)
        else {float: "f8", int: "i8", bool: "?"}[hint]
    )


def pack(settings: Sequence[Any]) -> np.ndarray[Any, Any]:
    """Return the records of dataclasses of one type, one row each."""
    rows = np.zeros(len(settings), record_type(type(settings[0])))
    for row, item in zip(rows, settings, strict=True):
        _fill(row, item)
    return rows


def _fill(row: Any, item: Any) -> None:  # noqa: ANN401
    for entry in fields(item):
        value = getattr(item, entry.name)
        if is_dataclass(value):
            _fill(row[entry.name], value)
        else:
            row[entry.name] = value


def pad_events(tables: Sequence[Float]) -> Float:
    """Put the tables of contact events, shape (m_j, 3), into one array (j, m, 3); what is missing never begins."""
    rows = max(len(table) for table in tables)
    padded = np.full((len(tables), rows, 3), np.inf)
    padded[:, :, 1:] = 0.0
    for place, table in enumerate(tables):
        padded[place, : len(table)] = table
    return padded
