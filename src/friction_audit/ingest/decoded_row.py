"""One decoded message of any library -> the joint values in it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_audit.ingest.joint_messages import MessageKind
from friction_audit.ingest.joint_order import numbered_joints
from friction_audit.ingest.message_decoder import UndecodableError, value_at
from friction_audit.joint_log import Float

STAMP_FIELDS = (("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("seconds", "nanos"))
"""Spellings of seconds and nanoseconds: ROS 2, foxglove JSON, ROS 1, protobuf."""


LATEST_TIME_NS = 2**63 - 1


@dataclass(frozen=True, eq=False, slots=True)
class Row:
    """Joint values of one message.

    Attributes:
        names: Joint names, in the order of the message; joint1..n if it carries none.
        channels: Channel -> values, one per joint; only channels with content.
        stamp: Time stamp of the source. [ns]
        robot_time: The robot's own clock. [s]
    """

    names: tuple[str, ...]
    channels: dict[str, Float]
    stamp: int | None
    robot_time: float | None


def row_of(message: object, kind: MessageKind) -> Row:
    """Take the joint values out of a decoded message.

    Raises:
        UndecodableError: If a field holds something else than numbers.
    """
    try:
        names, channels = _entries(message, kind) if kind.elements else _arrays(message, kind)
        robot_time = value_at(message, kind.robot_time) if kind.robot_time else None
        return Row(
            names or numbered_joints(max(map(len, channels.values()), default=0)),
            channels,
            next((ns for path in kind.stamps if (ns := _nanoseconds(value_at(message, path))) is not None), None),
            _seconds(robot_time),
        )
    except (TypeError, ValueError, OverflowError) as error:
        raise UndecodableError(str(error)) from error


def _arrays(message: object, kind: MessageKind) -> tuple[tuple[str, ...], dict[str, Float]]:
    names = value_at(message, kind.names) if kind.names else None
    values = {channel: _numbers(value_at(message, path)) for channel, path in kind.fields.items()}
    return _strings(names), {channel: array for channel, array in values.items() if array.size}


def _entries(message: object, kind: MessageKind) -> tuple[tuple[str, ...], dict[str, Float]]:
    entries: list[object] = list(value_at(message, kind.elements or "") or ())  # type: ignore[call-overload]
    columns = {channel: [value_at(entry, path) for entry in entries] for channel, path in kind.fields.items()}
    names = _strings([value_at(entry, kind.names or "") for entry in entries])
    return names, {name: _numbers(column) for name, column in columns.items() if any(v is not None for v in column)}


def _strings(names: object) -> tuple[str, ...]:
    """Return joint names, or nothing if there are none."""
    if not isinstance(names, Sequence) or isinstance(names, str):
        return ()
    return tuple(map(str, names)) if any(names) else ()


def _numbers(values: object) -> Float:
    if values is None:
        return np.empty(0)
    if isinstance(values, np.ndarray):
        return values.astype(np.float64)
    entries: list[Any] = list(values) if isinstance(values, Iterable) else [values]
    return np.array([np.nan if value is None else float(value) for value in entries], np.float64)


def _seconds(time: Any) -> float | None:  # noqa: ANN401
    """Return a clock's value, which some messages give as a time stamp."""
    if time is None:
        return None
    stamp = _nanoseconds(time)
    return float(time) if stamp is None else stamp / 1e9


def _nanoseconds(stamp: object) -> int | None:
    for seconds, nanoseconds in STAMP_FIELDS:
        whole, part = value_at(stamp, seconds), value_at(stamp, nanoseconds)
        if whole is not None and part is not None:
            time: int = int(whole) * 10**9 + int(part)  # type: ignore[call-overload]
            if abs(time) > LATEST_TIME_NS:
                raise OverflowError(f"a time stamp of {whole} s")
            return time
    return None
