"""JointLog -> serialised ROS messages: one is serialised by the library, the others are copies with other numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.export.ros_types import MessageType
from friction_audit.export.tables import NANOSECONDS, stamps_ns
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

BLOCK = 4096
"""Messages made at once."""

STAMP = np.array([0x12345678, 0x0BADF00D], dtype="<u4")
"""Seconds and nanoseconds that mark the place of the stamp in a serialised message."""

MARK = 7.654321e-210
"""Unlikely number; its multiples mark the places of the arrays."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Form:
    """A serialised message whose numbers are to be filled in.

    Attributes:
        payload: The bytes, shape (size,).
        arrays: Channel -> byte at which its array begins.
        stamp: Byte at which the header's stamp begins.
        robot_time: Byte of the robot's clock, or None.
    """

    payload: NDArray[np.uint8]
    arrays: dict[str, int]
    stamp: int
    robot_time: int | None


def encode(log: JointLog, message: MessageType, types: "Typestore") -> Iterator[tuple[int, bytes]]:
    """Yield (time [ns], serialised message) for every sample; a channel that was not recorded is NaN or empty."""
    form = _make_form(log, message, types)
    stamps = stamps_ns(log)
    for first in range(0, len(stamps), BLOCK):
        rows = slice(first, first + BLOCK)
        filled = _fill(form, log, stamps[rows], rows).tobytes()
        size = len(form.payload)
        for row, stamp in enumerate(stamps[rows].tolist()):
            yield stamp, filled[row * size : (row + 1) * size]


def _fill(form: Form, log: JointLog, stamps: NDArray[np.int64], rows: slice) -> NDArray[np.uint8]:
    """Return copies of the form with the numbers of some samples, shape (m, size)."""
    copies = np.repeat(form.payload[np.newaxis], len(stamps), axis=0)
    clock = np.column_stack(np.divmod(stamps, NANOSECONDS)).astype("<u4")
    _put(copies, form.stamp, clock)
    if form.robot_time is not None:
        _put(copies, form.robot_time, log.t[rows, np.newaxis])
    channels = log.channels()
    for name, place in form.arrays.items():
        _put(copies, place, channels[name][rows])
    return copies


def _put(copies: NDArray[np.uint8], place: int, numbers: NDArray[Any]) -> None:
    """Write rows of numbers into the copies, from a byte on."""
    data = np.ascontiguousarray(numbers).view(np.uint8)
    copies[:, place : place + data.shape[1]] = data


def _make_form(log: JointLog, message: MessageType, types: "Typestore") -> Form:
    """Serialise a message full of marks and find them in its bytes."""
    recorded = log.channels()
    sample = _blank(types, message.name)
    sample.header.stamp = types.types["builtin_interfaces/msg/Time"](sec=int(STAMP[0]), nanosec=int(STAMP[1]))
    for path in message.names:
        _set(sample, path, list(log.joint_names))
    marks = {name: MARK * (np.arange(len(log.joint_names)) + 100.0 * k) for k, name in enumerate(recorded, start=1)}
    for path, name in message.fields.items():
        if name in recorded:
            _set(sample, path, marks[name])
    if message.robot_time is not None:
        _set(sample, message.robot_time, MARK)
    serialise = types.serialize_ros1 if message.ros == 1 else types.serialize_cdr
    payload = bytes(serialise(sample, message.name))
    return Form(
        payload=np.frombuffer(payload, dtype=np.uint8),
        arrays={name: payload.index(marks[name].tobytes()) for name in message.fields.values() if name in recorded},
        stamp=payload.index(STAMP.tobytes()),
        robot_time=None if message.robot_time is None else payload.index(np.float64(MARK).tobytes()),
    )


def _set(sample: Any, path: str, value: object) -> None:  # noqa: ANN401
    """Set a field given by its dotted path."""
    *parents, name = path.split(".")
    for parent in parents:
        sample = getattr(sample, parent)
    setattr(sample, name, value)


def _blank(types: "Typestore", name: str) -> Any:  # noqa: ANN401
    """Return a message that says nothing: numbers NaN or 0, lists empty."""
    _, fields = types.fielddefs[name]
    return types.types[name](**{field: _blank_field(types, kind) for field, kind in fields})


def _blank_field(types: "Typestore", kind: Any) -> Any:  # noqa: ANN401
    from rosbags.interfaces import Nodetype

    node, detail = kind
    if node == Nodetype.NAME:
        return _blank(types, detail)
    if node == Nodetype.BASE:
        return _blank_base(detail[0])
    (element, (base, *_)), length = detail
    if element == Nodetype.NAME or base == "string":
        return [_blank_field(types, detail[0]) for _ in range(length if node == Nodetype.ARRAY else 0)]
    return np.full(length if node == Nodetype.ARRAY else 0, _blank_base(base), dtype=base)


def _blank_base(base: str) -> str | bool | int | float:
    if base == "string":
        return ""
    return float("nan") if base.startswith("float") else 0
