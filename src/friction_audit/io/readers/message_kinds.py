"""Which message fields are which channel, the values of one message, and which topic and which arm on it to read.

A definition is matched by its fields, not by its type's name: any message that has the fields of a row is readable.
Field names are compared without regard to case, since ROS 2 forced lower case on libfranka's names.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.joint_names import (
    DRIVER_NODES,
    UNNAMED_ARM,
    arm_name,
    arms_in,
    choose_arm,
    namespace,
    numbered_joints,
)
from friction_audit.io.readers.message_decoder import MessageDecoder
from friction_audit.io.readers.message_stream import UndecodableError
from friction_audit.io.readers.reader import SeveralLogsError, Topic
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float

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


_NOT_MEASURED = re.compile(r"desired|command|target|goal|motor_state|external")


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Candidate:
    """A topic whose messages can be read as joint states."""

    topic: str  # its name
    type: str  # its message type
    messages: int  # number of messages
    kind: MessageKind  # which fields are which channel
    decoders: Mapping[int, MessageDecoder]  # key of each connection -> its decoder
    rows: Sequence[Row] = field(default=())  # the first messages, decoded

    @property
    def names(self) -> list[str]:
        """Names of joints in the first messages."""
        return [name for row in self.rows for name in row.names]

    @property
    def arms(self) -> dict[str, tuple[str, ...]]:
        """Prefix of each arm in the messages -> its joints."""
        return arms_in(self.names)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that have content in the first messages, in the order of the kind's table."""
        return tuple(name for name in self.kind.fields if any(name in row.channels for row in self.rows))


def choose_topic(
    path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic], wanted: str | None
) -> tuple[Candidate, tuple[str, ...], tuple[Finding, ...]]:
    """Return the topic to read, the joints of the arm to read, and what to say about the choice.

    SeveralLogsError if the file holds several arms and the user named none.
    """
    if wanted is not None:
        name, _, arm = wanted.partition("#")
        candidate = _named(path, candidates, topics, name)
        return candidate, _arm_joints(path, candidate, arm), ()
    measured = [c for c in candidates if c.arms and not _NOT_MEASURED.search(c.topic.rsplit("/", 1)[-1])]
    if not measured:
        raise InputError(_nothing_to_read(path, candidates, topics))
    namespaces = {namespace(candidate.topic) for candidate in measured} - {""}
    prefixes = {arm for candidate in measured for arm in candidate.arms} - {""}
    if len(namespaces) > 1 or len(prefixes) > 1:
        message = f"{path}: several arms in one log; choose one with {_choices(measured)}"
        raise SeveralLogsError(message, _best_of_each_arm(measured))
    best = min(measured, key=_preference)
    return best, _arm_joints(path, best, ""), _others_finding(best, [c for c in measured if c is not best])


def _preference(candidate: Candidate) -> tuple[bool, int, bool, int]:
    """Torque before none, libfranka's own messages before others, first hand before republished, then the rate."""
    first_hand = bool(DRIVER_NODES & set(candidate.topic.split("/")))
    torque = any(name in candidate.channels for name in TORQUE_CHANNELS)
    return not torque, candidate.kind.rank, not first_hand, -candidate.messages


def _best_of_each_arm(candidates: Sequence[Candidate]) -> list[str]:
    """Return the best topic for each arm, arms distinguished by the names of their joints, else by namespace."""
    found: dict[str, str] = {}
    for candidate in sorted(candidates, key=_preference):
        for arm in candidate.arms:
            found.setdefault(arm_name(arm) or namespace(candidate.topic), _topic(candidate, arm))
    return [found[arm] for arm in sorted(found)]


def _topic(candidate: Candidate, arm: str) -> str:
    return f"{candidate.topic}#{arm or UNNAMED_ARM}" if len(candidate.arms) > 1 else candidate.topic


def _choices(candidates: Sequence[Candidate]) -> str:
    return " or ".join(f"--topic '{_topic(c, arm)}' ({c.messages} messages)" for c in candidates for arm in c.arms)


def _arm_joints(path: Path, candidate: Candidate, wanted: str) -> tuple[str, ...]:
    if not candidate.arms:
        raise InputError(f"{path}: topic {candidate.topic} has no joints in its messages; choose another with --topic")
    return choose_arm(candidate.names, wanted, path=str(path), topic=candidate.topic)


def _named(path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic], wanted: str) -> Candidate:
    for candidate in candidates:
        if candidate.topic.strip("/") == wanted.strip("/"):
            return candidate
    there = next((topic for topic in topics if topic.name.strip("/") == wanted.strip("/")), None)
    if there is not None and there.messages == 0:
        raise InputError(f"{path}: topic {there.name} has no messages; {_listed(topics)}")
    if there is not None:
        raise InputError(
            f"{path}: topic {there.name} of type {there.type} holds no joint state that can be read; expected fields "
            f"q, dq and tau_J, or position, velocity and effort; {_listed(topics)}"
        )
    near = get_close_matches(wanted, [topic.name for topic in topics], cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    raise InputError(f"{path}: no topic {wanted}; {hint}{_listed(topics)}; choose one with --topic")


def _nothing_to_read(path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic]) -> str:
    names = dict.fromkeys(candidate.topic for candidate in candidates)
    if not topics or (names and not any(topic.messages for topic in topics if topic.name in names)):
        return (
            f"{path}: 0 messages on {', '.join(names) or 'any topic'}; expected joint states; {_listed(topics)}; check "
            "that the robot and the recording were running, and record again"
        )
    if broken := next((candidate for candidate in candidates if not candidate.rows), None):
        return (
            f"{path}: the first messages on topic {broken.topic} of type {broken.type} do not fit their definition; "
            f"{_listed(topics)}; choose another one with --topic, or record again"
        )
    return (
        f"{path}: no topic with measured joint states; expected fields q, dq and tau_J, or position, velocity and "
        f"effort; {_listed(topics)}; name the fields with --topic and --map if one of them holds the joints"
    )


def _listed(topics: Sequence[Topic]) -> str:
    listed = ", ".join(f"{topic.name} ({topic.type}, {topic.messages} messages)" for topic in topics)
    return f"topics are {listed}" if topics else "there are no topics"


def _others_finding(best: Candidate, others: Sequence[Candidate]) -> tuple[Finding, ...]:
    if not others:
        return ()
    names = ", ".join(f"{c.topic} ({c.type}, {c.messages} messages)" for c in others)
    own = f"{best.topic} ({best.type}, {best.messages} messages)"
    message = f"{own} was read; also there: {names}; choose with --topic"
    return (Finding(code="topic_chosen", message=message),)
