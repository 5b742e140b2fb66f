"""Joint states in messages: which fields hold them, which topic and arm to read, their values block by block."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, near_misses
from friction_audit.io.readers.channel_names import (
    DRIVER_NODES,
    UNNAMED_ARM,
    arm_name,
    arms_in,
    choose_arm,
    namespace,
    parse_name,
    ranks,
)
from friction_audit.io.readers.clocks import Times
from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.message_decoder import Layout, MessageDecoder, Records
from friction_audit.io.readers.message_stream import Block, BrokenError
from friction_audit.io.readers.reader import SeveralLogsError, Topic
from friction_audit.joint_log import JOINT_CHANNELS, TORQUE_CHANNELS, Finding, Float

LATEST_TIME_NS = 2**63 - 1
# Spellings of seconds and nanoseconds: ROS 2, foxglove JSON, ROS 1, protobuf.
_STAMP_FIELDS = (("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("seconds", "nanos"))


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageKind:
    """Which field of a message is what; in a path ``list[].field`` is the field in all entries of a list."""

    rank: int  # preference when a file holds several; the smallest wins
    fields: Mapping[str, str]  # channel -> dotted path of its array
    names: str | None = None  # path of the joint names, if the message carries them
    robot_time: str | None = None  # path of the robot's own clock [s]
    stamps: tuple[str, ...] = ()  # paths of the source's time stamp, the first one is taken


JOINT_STATE = {"q": "position", "dq": "velocity", "tau_J": "effort"}
ROBOT_STATE = {channel: f"measured_joint_state.{field}" for channel, field in JOINT_STATE.items()}  # FrankaRobotState
ROBOT_STATE |= {"tau_J_d": "desired_joint_state.effort", "tau_ext_hat_filtered": "tau_ext_hat_filtered.effort"}
# Rank by the path of the position: a robot's own state, sensor_msgs/JointState and foxglove.JointStates, any other one.
RANKS = {"q": 0, ROBOT_STATE["q"]: 0, JOINT_STATE["q"]: 1, f"joints[].{JOINT_STATE['q']}": 1}


def kind_of(paths: Sequence[str]) -> MessageKind | None:
    """Take a message whose fields have names of a position and of a torque, as columns of tables have them."""
    named = {path: name for path in paths if (name := parse_name(path)) and name.index is None and name.joint is None}
    rank_of, found = ranks(named.values()), dict[str, str]()
    for path in sorted(named, key=lambda path: rank_of(named[path])):
        found.setdefault(named[path].channel, path)
    if "q" not in found or not (found.keys() & {*TORQUE_CHANNELS} or {"q", "dq"} <= {*found.values()}):
        return None
    head, rank = found["q"].rpartition(".")[0], RANKS.get(found["q"].lower(), 2)
    names = [path for path in paths if path.split(".")[-1] in ("name", "names", "joint_names")]
    return MessageKind(
        rank=rank,
        fields={channel: found[channel] for channel in JOINT_CHANNELS if channel in found},
        names=min(names, key=lambda path: path.rpartition(".")[0] != head, default=None),
        robot_time="time" if rank == 0 and "time" in paths else None,
        stamps=tuple(path for path in ("header.stamp", "stamp", "timestamp") if path in paths),
    )


class Row(NamedTuple):
    """Joint values of one message."""

    names: tuple[str, ...]  # Joint names, in the order of the message; joint1..n if it carries none
    channels: dict[str, Float]  # channel -> values, one per joint; only channels with content
    stamp: int | None  # time stamp of the source [ns]
    robot_time: float | None  # the robot's own clock [s]


def rows_of(block: Block, decoder: MessageDecoder, kind: MessageKind) -> Iterator[Row | None]:
    """Yield the joint values in messages; None for one that cannot be decoded, or whose fields hold no numbers."""
    wrong: tuple[type[Exception], ...] = (TypeError, ValueError, OverflowError, *decoder.errors)
    for payload in block.payloads():
        try:
            message = decoder.decode(payload)
            names = _value_at(message, kind.names)
            values = {channel: _numbers(_value_at(message, path)) for channel, path in kind.fields.items()}
            robot_time = _value_at(message, kind.robot_time)
            if robot_time is not None:  # some messages give it as a time stamp
                stamp = _nanoseconds(robot_time)
                robot_time = float(robot_time) if stamp is None else stamp / 1e9
            stamps = [_nanoseconds(_value_at(message, path)) for path in kind.stamps]
        except wrong:
            yield None
            continue
        names = tuple(map(str, names)) if isinstance(names, list | tuple) and any(names) else ()
        channels = {channel: array for channel, array in values.items() if array.size}
        names = names or tuple(f"joint{k + 1}" for k in range(max(map(len, channels.values()), default=0)))
        yield Row(names, channels, next((stamp for stamp in stamps if stamp is not None), None), robot_time)


def _value_at(message: object, path: str | None) -> Any:  # noqa: ANN401
    """Return the value of a field by its path, or None if the message does not have it."""
    if isinstance(message, dict) and path in message:  # JSON, in a fraction of the time
        return message[path]
    if path is None:
        return None
    head, entries, inner = path.partition("[].")
    value: Any = message
    for name in head.split("."):
        if isinstance(value, Mapping):
            value = value.get(name)
        else:  # an optional protobuf field that was not set is None, not its default
            field = value.DESCRIPTOR.fields_by_name.get(name) if hasattr(value, "DESCRIPTOR") else None
            is_unset = field is not None and field.has_presence and not value.HasField(name)
            value = None if is_unset else getattr(value, name, None)
        if value is None:
            return None
    return [_value_at(entry, inner) for entry in value] if entries else value


def _numbers(values: Any) -> Float:  # noqa: ANN401
    if isinstance(values, np.ndarray):
        return values.astype(np.float64)
    entries = list(values) if isinstance(values, Iterable) else [values]
    is_empty = all(value is None for value in entries)
    return np.array([] if is_empty else [np.nan if value is None else float(value) for value in entries], np.float64)


def _nanoseconds(stamp: object) -> int | None:
    for seconds, nanoseconds in _STAMP_FIELDS:
        whole, part = _value_at(stamp, seconds), _value_at(stamp, nanoseconds)
        if whole is not None and part is not None:
            time: int = int(whole) * 10**9 + int(part)
            if abs(time) > LATEST_TIME_NS:
                raise OverflowError(f"a time stamp of {whole} s")
            return time
    return None


_EXPECTED = "expected fields q, dq and tau_J, or position, velocity and effort"
_NOT_MEASURED = re.compile(r"desired|command|target|goal|motor_state|external")


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Candidate(Topic):
    """A topic whose messages can be read as joint states."""

    messages: int
    kind: MessageKind  # which fields are which channel
    decoders: Mapping[int, MessageDecoder]  # key of each connection -> its decoder
    is_decoded: bool  # True if any of the first messages fits its definition
    names: tuple[str, ...]  # of joints in the first messages
    channels: tuple[str, ...]  # that have content in the first messages, in the order of the kind's table

    @property
    def choices(self) -> dict[str, str]:
        """Prefix of each arm in the messages -> what ``--topic`` calls it."""
        arms = arms_in(self.names)
        return {arm: f"{self.name}#{arm or UNNAMED_ARM}" if len(arms) > 1 else self.name for arm in arms}

    @property
    def preference(self) -> tuple[bool, int, bool, int]:
        """Torque before none, libfranka's own messages before others, first hand before republished, then the rate."""
        first_hand = bool(DRIVER_NODES & set(self.name.split("/")))
        torque = any(name in self.channels for name in TORQUE_CHANNELS)
        return not torque, self.kind.rank, not first_hand, -self.messages


def choose_topic(
    path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic], wanted: str | None
) -> tuple[Candidate, tuple[str, ...], tuple[Finding, ...]]:
    """Return the topic, the joints of the arm, and what to say about it; SeveralLogsError if the user has to choose."""
    name, _, arm = (wanted or "").partition("#")
    measured = [c for c in candidates if c.choices and not _NOT_MEASURED.search(c.name.rsplit("/", 1)[-1])]
    listed = f"topics are {', '.join(map(str, topics))}" if topics else "there are no topics"
    if wanted is not None:
        there = {topic.name.strip("/"): topic for topic in (*topics, *candidates)}.get(name.strip("/"))
        if there is None:
            near = near_misses(name, [topic.name for topic in topics])
            raise InputError(f"{path}: no topic {name}{near}; {listed}; choose one with --topic")
        if not isinstance(there, Candidate):
            what = f"of type {there.type} holds no joint state that can be read; {_EXPECTED}"
            what = what if there.messages else "has no messages"
            raise InputError(f"{path}: topic {there.name} {what}; {listed}")
        measured = [there]
    elif not measured:
        what = f"no topic with measured joint states; {_EXPECTED}"
        if not any(topic.messages for topic in topics):
            what = "0 messages on any topic; expected joint states"
        elif broken := next((candidate for candidate in candidates if not candidate.is_decoded), None):
            what = f"the first messages on topic {broken.name} of type {broken.type} do not fit their definition"
        how = "name a topic with --topic and its fields with --map, or record again"
        raise InputError(f"{path}: {what}; {listed}; {how}")
    else:
        _refuse_several_arms(path, measured)
    best, *others = sorted(measured, key=lambda one: one.preference)
    if not best.choices:
        raise InputError(f"{path}: topic {best.name} has no joints in its messages; choose another with --topic")
    message = f"{best} was read; also there: {', '.join(map(str, others))}; choose with --topic"
    findings = (Finding("topic_chosen", message),) if others else ()
    return best, choose_arm(best.names, arm, path=str(path), topic=best.name), findings


def _refuse_several_arms(path: Path, candidates: Sequence[Candidate]) -> None:
    """Refuse several arms, distinguished by the names of their joints, else by namespace."""
    namespaces = {namespace(candidate.name) for candidate in candidates} - {""}
    prefixes = {arm for candidate in candidates for arm in candidate.choices} - {""}
    if max(len(namespaces), len(prefixes)) <= 1:
        return
    ranked = sorted(candidates, key=lambda one: one.preference)
    choices = [(arm_name(arm) or namespace(c.name), choice) for c in ranked for arm, choice in c.choices.items()]
    best = dict(reversed(choices))  # the first one of each arm
    listed = [f"--topic '{choice}' ({c.messages} messages)" for c in candidates for choice in c.choices.values()]
    message = f"{path}: several arms in one log; choose one with {' or '.join(listed)}"
    raise SeveralLogsError(message, [best[arm] for arm in sorted(best)])


# Values of some joints in messages that follow each other: the clocks, and channel -> a column per joint.
Piece = tuple[Times, Mapping[str, Sequence[NDArray[Any]]]]


class JointDecoder:
    """Decodes blocks of one topic to the values of some joints."""

    def __init__(self, chosen: Candidate, joints: tuple[str, ...], channels: Sequence[str]) -> None:
        self.undecodable = self.incomplete = 0  # messages that do not fit their definition, or lack some of the joints
        self.chosen, self.joints, self._channels = chosen, joints, channels
        kind = chosen.kind
        self._stamp = [f"{path}.{part}" for path in kind.stamps[:1] for part in ("sec", "nanosec")]
        paths = [*(kind.fields[name] for name in channels), *self._stamp, kind.robot_time]
        self._paths = list(dict.fromkeys(path for path in paths if path))
        self._layouts: dict[int, Layout] = {}

    def decode(self, block: Block) -> Piece:
        """Decode by the layout in use, or by that of the block's own first message; else message by message."""
        layout, find = self._layouts.get(block.key), self.chosen.decoders[block.key].layout
        records = layout.records(block, self._paths) if layout else None
        if records is None and find:
            with suppress(BrokenError):
                layout = find(next(block.payloads()))
                records = layout.records(block, self._paths)
        if layout is None or records is None:
            return self.of_messages(block)
        self._layouts[block.key] = layout
        return self._of_records(records, layout, block) or self.of_messages(block)

    def _of_records(self, records: Records, layout: Layout, block: Block) -> Piece | None:
        """View records of constant layout; None if their arrays do not fit their names."""
        kind = self.chosen.kind
        names = layout.strings.get(kind.names, ()) if kind.names else ()
        if not any(names):
            counts = [layout.numbers[path][0].shape[0] for path in kind.fields.values() if path in layout.numbers]
            names = tuple(f"joint{k + 1}" for k in range(max(counts)))
        columns, fields = _columns_of(names, self.joints), {name: records[kind.fields[name]] for name in self._channels}
        if (columns < 0).any() or any(field.shape[1] != len(names) for field in fields.values()):
            return None
        times = {"log_time": block.log_time}
        if self._stamp:
            seconds, nanoseconds = (records[path][:, 0] for path in self._stamp)
            times["header_stamp"] = seconds.astype(np.int64) * 10**9 + nanoseconds
        if kind.robot_time:
            times["robot_time"] = records[kind.robot_time][:, 0]
        return times, {name: [field[:, column] for column in columns] for name, field in fields.items()}

    def of_messages(self, block: Block) -> Piece:
        """Decode message by message, with the library's decoder; one that holds none of the joints is passed over."""
        found = list[tuple[int, Row, NDArray[np.intp]]]()
        rows = rows_of(block, self.chosen.decoders[block.key], self.chosen.kind)
        for log_time, row in zip(block.log_time.tolist(), rows, strict=True):
            if row is None or len(row.names) > MOST_JOINTS:
                self.undecodable += 1
                continue
            columns = _columns_of(row.names, self.joints)
            self.incomplete += bool((columns < 0).any() and (columns >= 0).any())
            if (columns >= 0).any():
                found.append((log_time, row, columns))
        arrays = {name: np.full((len(self.joints), len(found)), np.nan) for name in self._channels}
        for at, (_, row, columns) in enumerate(found):
            for name, array in arrays.items():
                values = row.channels.get(name, np.empty(0))
                there = (columns >= 0) & (columns < len(values))
                array[there, at] = values[columns[there]]
        stamps, readings = [row.stamp for _, row, _ in found], [row.robot_time for _, row, _ in found]
        own: dict[str, list[Any]] = {"header_stamp": stamps, "robot_time": readings}
        own["log_time"] = [log_time for log_time, *_ in found]
        times = {name: np.array(values) for name, values in own.items() if None not in values}
        return times, {name: list(array) for name, array in arrays.items()}


@lru_cache(maxsize=64)
def _columns_of(names: tuple[str, ...], joints: tuple[str, ...]) -> NDArray[np.intp]:
    """Return, for each joint, its index in a message with these names, or -1 where it lacks the joint."""
    place = {name: index for index, name in reversed(list(enumerate(names)))}
    return np.array([place.get(joint, -1) for joint in joints], np.intp)
