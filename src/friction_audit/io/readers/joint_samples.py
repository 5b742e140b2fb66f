"""The joint values of many messages, gathered message by message or block by block."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.joint_names import numbered_joints
from friction_audit.io.readers.message_kinds import MessageKind, Row
from friction_audit.io.readers.message_layout import Layout, Records
from friction_audit.io.readers.message_stream import Int
from friction_audit.joint_log import Float

# A count in a file is not trusted beyond this (5 hours at 1 kHz); the arrays then grow with the messages found.
LARGEST_EXPECTATION = 20_000_000
_SMALLEST_CAPACITY = 1024
_NANOSECONDS = 10**9

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
        self._capacity = min(max(expected or 0, _SMALLEST_CAPACITY), LARGEST_EXPECTATION)
        self.channels = {name: np.empty((self._capacity, len(joints)), order="F") for name in channels}
        self._log_time = np.empty(self._capacity, np.int64)
        self._stamp = np.empty(self._capacity, np.int64)
        self._robot_time = np.empty(self._capacity)
        self._has_stamp = True
        self._has_robot_time = True
        self._columns: dict[tuple[str, ...], NDArray[np.intp]] = {}

    def _columns_of(self, names: tuple[str, ...]) -> NDArray[np.intp]:
        """Return, for each joint kept, its index in a message with these names, or -1 where it lacks the joint."""
        columns = self._columns.get(names)
        if columns is None:
            place = {name: index for index, name in reversed(list(enumerate(names)))}
            columns = np.array([place.get(joint, -1) for joint in self.joints], np.intp)
            self._columns[names] = columns
        return columns

    def add_records(self, records: Records, layout: Layout, kind: MessageKind, log_time: Int) -> bool:
        """Append a block of constant layout; False if its arrays do not fit its names, and nothing was done."""
        names = layout.strings.get(kind.names, ()) if kind.names else ()
        if not any(names):
            counts = [layout.numbers[path].count for path in kind.fields.values() if path in layout.numbers]
            names = numbered_joints(max(counts))
        columns = self._columns_of(names)
        if (columns < 0).any() or any(layout.numbers[kind.fields[name]].count != len(names) for name in self.channels):
            return False
        rows = self._extend(len(records))
        for name, array in self.channels.items():
            field = records[kind.fields[name]]
            for joint, column in enumerate(columns):
                array[rows, joint] = field[:, column]
        self._log_time[rows] = log_time
        self._has_stamp &= bool(kind.stamps)
        if kind.stamps:
            seconds, nanoseconds = kind.stamp_paths
            np.multiply(records[seconds][:, 0], _NANOSECONDS, out=self._stamp[rows], dtype=np.int64)
            self._stamp[rows] += records[nanoseconds][:, 0]
        self._has_robot_time &= bool(kind.robot_time)
        if kind.robot_time:
            self._robot_time[rows] = records[kind.robot_time][:, 0]
        return True

    def add_row(self, row: Row, log_time: int) -> None:
        """Append one decoded message; one that holds none of the joints is passed over."""
        columns = self._columns_of(row.names)
        if (columns < 0).any():
            self.incomplete += bool((columns >= 0).any())
            if (columns < 0).all():
                return
        at = self._extend(1).start
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

    def _extend(self, more: int) -> slice:
        first, last = self.count, self.count + more
        if last > self._capacity:
            self._resize(max(last, 2 * self._capacity))
        self.count = last
        return slice(first, last)

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
