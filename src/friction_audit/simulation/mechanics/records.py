"""Settings of joints -> records of numbers that compiled code reads by name."""

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.frictional_lag import LAG_MEMORY
from friction_audit.simulation.effects.presliding import BRISTLES

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


(
    OUTER,
    OUTER_SPEED,
    INNER,
    SPEED,
    ACCELERATION,
    PORT,
    SUPPORT,
    FRICTION,
    COMPENSATION,
    PASSIVITY,
    UNLOGGED,
    DISSIPATED,
    WARMTH,
) = range(13)
ROWS = 13
"""What is kept of every tick: positions, velocities, torques, energy and warmth of each joint."""


class Clock(NamedTuple):
    """The controller's clock.

    Attributes:
        dt: Time from tick to tick. [s]
        substeps: Steps of the integration in half a tick.
        duration: Length of the recording. [s]
    """

    dt: float
    substeps: int
    duration: float


class Loop(NamedTuple):
    """The compensator in the loop and what it sees.

    Attributes:
        settings: Records of the compensators, shape (n,).
        memory: What they remember, shape (n,); changed.
        torque_noise: Error of the torque as read, shape (ticks + 1, n). [N m]
        velocity_noise: Error of the velocity as read, shape (ticks + 1, n). [rad/s]
        position_noise: Error of the position as read, shape (ticks + 1, n); no compensator looks at it. [rad]
        torque_step: Resolution of the torque, shape (n,). [N m]
        velocity_step: Resolution of the velocity, shape (n,). [rad/s]
    """

    settings: Any
    memory: Any
    torque_noise: Float
    velocity_noise: Float
    position_noise: Float
    torque_step: Float
    velocity_step: Float


class Parts(NamedTuple):
    """What the loops work on, all of it changed in place but the joints and the clock."""

    joints: Any
    """Records of the joints, shape (n,)."""
    states: Any
    """What they remember, shape (n,)."""
    events: Float
    """Contact events, shape (n, m, 3)."""
    body: Any
    """Coordinates and matrices."""
    loop: Loop
    """The compensators and what they see."""
    clock: Clock
    """The controller's clock."""
