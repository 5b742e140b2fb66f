"""Which of a message's joints belong to an arm, and in which order: by name, never by index."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.message_decoder import UndecodableError, value_at
from friction_audit.io.readers.message_layout import Layout, Records
from friction_audit.io.readers.message_stream import Int, MessageKind
from friction_audit.io.readers.reader import SeveralArmsError
from friction_audit.joint_log import Float

ARM_JOINT = re.compile(r"^(?:(?P<arm>.*?)_?)?joint_?(?P<number>\d+)$", re.IGNORECASE)
"""``panda_joint3``, ``left_fr3_joint1``, ``joint2``: the arm before the word, the joint's number after it."""

_FINGER = re.compile(r"finger|gripper", re.IGNORECASE)
_LAST_NUMBER = re.compile(r"(.*?)(\d+)")

ROBOTS = (
    ("panda", re.compile(r"(?:^|[\W_])(?:panda|fer)(?:[\W_]|\d|$)", re.IGNORECASE)),
    ("fr3", re.compile(r"(?:^|[\W_])fr3(?:[\W_]|v\d|\d|$)", re.IGNORECASE)),
)
"""Robot -> how the prefix of its joints says so: ``panda1``, ``left_panda``, ``fer``, ``fr3v2``."""

_MAKE = re.compile(r"panda|fer|fr3(?:v\d(?:_\d)?)?|franka", re.IGNORECASE)

UNNAMED_ARM = "joint"
"""What an arm without prefix is called behind the ``#`` of ``--topic``."""

MINIMUM_JOINTS_BESIDE_AN_ARM = 2
"""A single numbered joint beside an arm (a lift, a gripper) is not a second arm."""


def arms_in(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Group joints by arm.

    Args:
        names: Joint names in the order of the message.

    Returns:
        Prefix of the arm -> its joints in the order of their numbers, fingers left out. Where no name ends in
        ``joint`` and a number, there is one arm, "": names that differ in a number at their end alone (``A1``) in the
        order of the numbers, others in the order of the message.
    """
    bodies = [name for name in dict.fromkeys(names) if not is_finger(name)]
    numbered: dict[str, list[tuple[int, str]]] = {}
    for name in bodies:
        if match := ARM_JOINT.match(name):
            numbered.setdefault(match["arm"] or "", []).append((int(match["number"]), name))
    if not numbered:
        return {"": _by_last_number(bodies)} if bodies else {}
    most = max(map(len, numbered.values()))
    return {
        arm: tuple(name for _, name in sorted(joints))
        for arm, joints in sorted(numbered.items())
        if len(joints) >= min(most, MINIMUM_JOINTS_BESIDE_AN_ARM)
    }


def is_finger(name: str) -> bool:
    """Return True for joints of a gripper, which are no part of the arm."""
    return _FINGER.search(name) is not None


def _by_last_number(names: Sequence[str]) -> tuple[str, ...]:
    numbered = [(match[1], int(match[2]), name) for name in names if (match := _LAST_NUMBER.fullmatch(name))]
    if len(numbered) < len(names) or len({stem for stem, _, _ in numbered}) > 1:
        return tuple(names)
    return tuple(name for _, _, name in sorted(numbered))


def choose_arm(names: Sequence[str], wanted: str, *, path: str) -> tuple[str, ...]:
    """Return the joints of the arm to read, in their order, from the joints of a table.

    Args:
        names: Joint names in the order of the table.
        wanted: The arm as the user gave it behind the ``#`` of ``--topic``, or "".
        path: The file, for messages.

    Raises:
        InputError: If there is no such arm.
        SeveralArmsError: If there are several arms and the user named none.
    """
    arms = {arm or UNNAMED_ARM: joints for arm, joints in arms_in(names).items()}
    topics = [f"#{arm}" for arm in arms]
    choices = " or ".join(f"--topic '{topic}'" for topic in topics)
    if wanted and wanted not in arms:
        raise InputError(
            f"{path}: no arm {wanted!r} in this table; it has {', '.join(arms) or 'no joints by name'}; "
            f"{f'choose with {choices}' if arms else 'leave --topic out'}"
        )
    if not wanted and len(arms) > 1:
        raise SeveralArmsError(f"{path}: several arms in one log; choose one with {choices}", topics)
    return arms[wanted] if wanted else next(iter(arms.values()), ())


def arm_name(prefix: str) -> str:
    """Return what the prefix of joints calls their arm, or nothing where it is the make of the robot alone."""
    return "" if _MAKE.fullmatch(prefix) else prefix


def robot_of(names: Iterable[str]) -> str:
    """Return ``"panda"``, ``"fr3"`` or ``"unknown"`` from the prefix of the joint names."""
    prefixes = {match["arm"] or "" for name in names if (match := ARM_JOINT.match(name))}
    robots = {robot for robot, pattern in ROBOTS for prefix in prefixes if pattern.search(prefix)}
    return robots.pop() if len(robots) == 1 else "unknown"


def numbered_joints(count: int) -> tuple[str, ...]:
    """Name the joints of a message that carries no names: joint1..joint{count}."""
    return tuple(f"joint{number}" for number in range(1, count + 1))


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


SMALLEST_CAPACITY = 1024
LARGEST_EXPECTATION = 20_000_000
"""A count in a file is not trusted beyond this (5 hours at 1 kHz); the arrays then grow with the messages found."""
NANOSECONDS = 10**9

Columns = NDArray[np.intp]
Number = TypeVar("Number", np.int64, np.float64)


class JointSamples:
    """Samples of some joints and channels, in the order of the file.

    Attributes:
        joints: Names of the joints kept, one per column.
        channels: Channel -> array of shape (capacity, j), Fortran order.
        count: Number of samples so far.
        incomplete: Number of messages that lacked some of the joints.
    """

    def __init__(self, joints: tuple[str, ...], channels: Sequence[str], expected: int | None) -> None:
        """Make room for the number of samples expected."""
        self.joints = joints
        self.count = 0
        self.incomplete = 0
        self._capacity = min(max(expected or 0, SMALLEST_CAPACITY), LARGEST_EXPECTATION)
        self.channels = {name: np.empty((self._capacity, len(joints)), order="F") for name in channels}
        self._log_time = np.empty(self._capacity, np.int64)
        self._stamp = np.empty(self._capacity, np.int64)
        self._robot_time = np.empty(self._capacity)
        self._has_stamp = True
        self._has_robot_time = True
        self._columns: dict[tuple[str, ...], Columns] = {}

    def columns_of(self, names: tuple[str, ...]) -> Columns:
        """Return, for each joint kept, its index in a message with these names, or -1 where it lacks the joint."""
        columns = self._columns.get(names)
        if columns is None:
            place = {name: index for index, name in reversed(list(enumerate(names)))}
            columns = np.array([place.get(joint, -1) for joint in self.joints], np.intp)
            self._columns[names] = columns
        return columns

    def add_records(self, records: Records, layout: Layout, kind: MessageKind, log_time: Int) -> bool:
        """Append a block of constant layout; False if its arrays do not fit its names, and nothing was done."""
        names = layout_names(layout, kind)
        columns = self.columns_of(names)
        if (columns < 0).any() or any(layout.numbers[kind.fields[name]].count != len(names) for name in self.channels):
            return False
        first, last = self._extend(len(records))
        for name, array in self.channels.items():
            field = records[kind.fields[name]]
            for joint, column in enumerate(columns):
                array[first:last, joint] = field[:, column]
        self._log_time[first:last] = log_time
        self._add_clocks(records, kind, slice(first, last))
        return True

    def _add_clocks(self, records: Records, kind: MessageKind, rows: slice) -> None:
        if kind.stamps:
            seconds, nanoseconds = stamp_paths(kind)
            np.multiply(records[seconds][:, 0], NANOSECONDS, out=self._stamp[rows], dtype=np.int64)
            self._stamp[rows] += records[nanoseconds][:, 0]
        else:
            self._has_stamp = False
        if kind.robot_time:
            self._robot_time[rows] = records[kind.robot_time][:, 0]
        else:
            self._has_robot_time = False

    def add_row(self, row: Row, log_time: int) -> None:
        """Append one decoded message; one that holds none of the joints is passed over."""
        columns = self.columns_of(row.names)
        if (columns < 0).any():
            self.incomplete += bool((columns >= 0).any())
            if (columns < 0).all():
                return
        at, _ = self._extend(1)
        for name, array in self.channels.items():
            values = row.channels.get(name, np.empty(0))
            there = (columns >= 0) & (columns < len(values))
            array[at] = np.nan
            array[at, there] = values[columns[there]]
        self._log_time[at] = log_time
        self._stamp[at] = row.stamp or 0
        self._robot_time[at] = np.nan if row.robot_time is None else row.robot_time
        self._has_stamp &= row.stamp is not None
        self._has_robot_time &= row.robot_time is not None

    def _extend(self, more: int) -> tuple[int, int]:
        first, last = self.count, self.count + more
        if last > self._capacity:
            self._resize(max(last, 2 * self._capacity))
        self.count = last
        return first, last

    def _resize(self, capacity: int) -> None:
        """Move everything, one array at a time; memory that was never written to costs nothing."""
        kept = min(self.count, capacity)
        for name, old in self.channels.items():
            self.channels[name] = _moved(old, kept, capacity)
        self._log_time = _moved(self._log_time, kept, capacity)
        self._stamp = _moved(self._stamp, kept, capacity)
        self._robot_time = _moved(self._robot_time, kept, capacity)
        self._capacity = capacity

    def trim(self) -> None:
        """Give back the room that was not needed."""
        if self.count < self._capacity:
            self._resize(self.count)

    @property
    def log_time(self) -> Int:
        """Time at which each message was recorded. [ns]"""
        return self._log_time[: self.count]

    @property
    def stamp(self) -> Int | None:
        """Time stamp of the source, or None if not every message has one. [ns]"""
        return self._stamp[: self.count] if self._has_stamp else None

    @property
    def robot_time(self) -> Float | None:
        """The robot's own clock, or None if not every message has it. [s]"""
        return self._robot_time[: self.count] if self._has_robot_time else None


def _moved(old: NDArray[Number], kept: int, capacity: int) -> NDArray[Number]:
    new = np.empty((capacity, *old.shape[1:]), old.dtype, order="F")
    new[:kept] = old[:kept]
    return new


def stamp_paths(kind: MessageKind) -> tuple[str, str]:
    """Return the paths of the seconds and nanoseconds of a ROS message's stamp."""
    return f"{kind.stamps[0]}.sec", f"{kind.stamps[0]}.nanosec"


def layout_names(layout: Layout, kind: MessageKind) -> tuple[str, ...]:
    """Return the joint names in a layout, joint1..n if it has none."""
    names = layout.strings.get(kind.names, ()) if kind.names else ()
    if any(names):
        return names
    return numbered_joints(max(layout.numbers[path].count for path in kind.fields.values() if path in layout.numbers))
