"""Which message fields are which channel: the table of joint state messages, and the values of one message.

A definition is matched by its fields, not by its type's name: any message that has the fields of a row is readable.
Field names are compared without regard to case, since ROS 2 forced lower case on libfranka's names.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from friction_audit.io.readers.joint_names import numbered_joints
from friction_audit.io.readers.message_stream import UndecodableError
from friction_audit.joint_log import Float

LATEST_TIME_NS = 2**63 - 1
# Spellings of seconds and nanoseconds: ROS 2, foxglove JSON, ROS 1, protobuf.
_STAMP_FIELDS = (("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("seconds", "nanos"))


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageKind:
    """One family of joint state messages."""

    rank: int  # preference when a file holds several; the smallest wins
    fields: Mapping[str, str]  # channel -> dotted path of its array
    required: tuple[str, ...]  # channels of which a definition must have all
    names: str | None = None  # path of the joint names, if the message carries them
    robot_time: str | None = None  # path of the robot's own clock [s]
    stamps: tuple[str, ...] = ("header.stamp",)  # paths of the source's time stamp, the first one present is taken
    elements: str | None = None  # path of a list with one entry per joint; the other paths then lie within an entry

    @property
    def stamp_paths(self) -> tuple[str, ...]:
        """Paths of the seconds and nanoseconds of a ROS message's stamp, none if it has no stamp."""
        return (f"{self.stamps[0]}.sec", f"{self.stamps[0]}.nanosec") if self.stamps else ()


_JOINT_STATE = {"q": "position", "dq": "velocity", "tau_J": "effort"}
_STATE = ("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered", "gravity", "tau_interaction", "tau_compensation",
          "tau_passivity", "temperature")  # fmt: skip
KINDS: tuple[MessageKind, ...] = (  # in the order in which a definition is tried
    MessageKind(  # nested FrankaRobotState
        rank=0,
        fields={
            "q": "measured_joint_state.position",
            "dq": "measured_joint_state.velocity",
            "tau_J": "measured_joint_state.effort",
            "tau_J_d": "desired_joint_state.effort",
            "tau_ext_hat_filtered": "tau_ext_hat_filtered.effort",
        },
        required=("q", "dq", "tau_J"),
        names="measured_joint_state.name",
        robot_time="time",
    ),
    MessageKind(  # FrankaState
        rank=0,
        fields={name: name for name in _STATE},
        required=("q", "dq"),
        names="name",
        robot_time="time",
        stamps=("header.stamp", "stamp"),
    ),
    MessageKind(  # sensor_msgs/JointState
        rank=1,
        fields=_JOINT_STATE,
        required=("q", "dq", "tau_J"),
        names="name",
        stamps=("header.stamp", "timestamp", "stamp"),
    ),
    MessageKind(  # foxglove.JointStates
        rank=1, fields=_JOINT_STATE, required=(), names="name", stamps=("timestamp",), elements="joints"
    ),
)


def match_kind(paths: Iterable[str]) -> MessageKind | None:
    """Find the kind that a message with these fields belongs to, its paths spelled as the message spells them."""
    spelled = {path.lower(): path for path in paths}
    for kind in KINDS:
        if kind.elements:
            if kind.elements.lower() in spelled:
                return kind
        elif all(kind.fields[channel].lower() in spelled for channel in kind.required):
            return replace(
                kind,
                fields={c: spelled[path.lower()] for c, path in kind.fields.items() if path.lower() in spelled},
                names=spelled.get((kind.names or "").lower()),
                robot_time=spelled.get((kind.robot_time or "").lower()),
                stamps=tuple(spelled[path] for path in kind.stamps if path in spelled),
            )
    return None


@dataclass(frozen=True, eq=False, slots=True)
class Row:
    """Joint values of one message."""

    names: tuple[str, ...]  # Joint names, in the order of the message; joint1..n if it carries none
    channels: dict[str, Float]  # channel -> values, one per joint; only channels with content
    stamp: int | None  # time stamp of the source [ns]
    robot_time: float | None  # the robot's own clock [s]


def row_of(message: object, kind: MessageKind) -> Row:
    """Take the joint values out of a decoded message; UndecodableError if a field holds no numbers."""
    try:
        if kind.elements:
            entries: list[object] = list(value_at(message, kind.elements) or ())  # type: ignore[call-overload]
            columns = {channel: [value_at(entry, path) for entry in entries] for channel, path in kind.fields.items()}
            names = _strings([value_at(entry, kind.names or "") for entry in entries])
            channels = {c: _numbers(column) for c, column in columns.items() if any(v is not None for v in column)}
        else:
            names = _strings(value_at(message, kind.names) if kind.names else None)
            values = {channel: _numbers(value_at(message, path)) for channel, path in kind.fields.items()}
            channels = {channel: array for channel, array in values.items() if array.size}
        robot_time: Any = value_at(message, kind.robot_time) if kind.robot_time else None
        if robot_time is not None:  # some messages give it as a time stamp
            stamp = _nanoseconds(robot_time)
            robot_time = float(robot_time) if stamp is None else stamp / 1e9
        return Row(
            names or numbered_joints(max(map(len, channels.values()), default=0)),
            channels,
            next((ns for path in kind.stamps if (ns := _nanoseconds(value_at(message, path))) is not None), None),
            robot_time,
        )
    except (TypeError, ValueError, OverflowError) as error:
        raise UndecodableError(str(error)) from error


def value_at(message: object, path: str) -> object | None:
    """Return the value of a field by its dotted path, or None if the message does not have it."""
    value: object | None = message
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else _attribute(value, name)
        if value is None:
            return None
    return value


def _attribute(message: object, name: str) -> object | None:
    """Return an attribute; an optional protobuf field that was not set is None, not its default."""
    descriptor = getattr(message, "DESCRIPTOR", None)
    if descriptor is not None:
        field = descriptor.fields_by_name.get(name)
        if field is None or (field.has_presence and not message.HasField(name)):  # type: ignore[attr-defined]
            return None
    return getattr(message, name, None)


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


def _nanoseconds(stamp: object) -> int | None:
    for seconds, nanoseconds in _STAMP_FIELDS:
        whole, part = value_at(stamp, seconds), value_at(stamp, nanoseconds)
        if whole is not None and part is not None:
            time: int = int(whole) * 10**9 + int(part)  # type: ignore[call-overload]
            if abs(time) > LATEST_TIME_NS:
                raise OverflowError(f"a time stamp of {whole} s")
            return time
    return None
