"""The values of some joints in messages, block by block and as arrays, and their clock."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.joint_names import numbered_joints
from friction_audit.io.readers.message_kinds import Row, row_of
from friction_audit.io.readers.message_layout import BlockDecoder, Layout, Records
from friction_audit.io.readers.message_stream import Block, Int, UndecodableError
from friction_audit.io.readers.topics import Candidate
from friction_audit.joint_log import Finding, Float

_NANOSECONDS = 10**9
_CLOCKS = ("stamp", "robot_time")  # of the source, where it has them
_SMALLEST_CAPACITY = 1024


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Values of some joints in n messages that follow each other."""

    log_time: Int  # time at which each message was recorded [ns]
    stamp: Int | None  # time stamp of the source, None if not every message has one [ns]
    robot_time: Float | None  # the robot's own clock, None if not every message has it [s]
    channels: Mapping[str, Sequence[NDArray[Any]]]  # channel -> a column per joint


class JointSamples:
    """Pieces one after the other in arrays, channels of shape (n, j) in Fortran order."""

    def __init__(self, joints: int, channels: Iterable[str], expected: int, *, every: int = 1) -> None:
        """Make room for the number of samples expected, which grows with the pieces; keep one of so many."""
        room = max(expected // every, _SMALLEST_CAPACITY)
        self.rows = self.count = 0  # samples so far, and those of them that are kept
        self.channels = {name: np.empty((room, joints), order="F") for name in channels}
        self._times: dict[str, NDArray[Any]] = {name: np.empty(room, np.int64) for name in ("log_time", "stamp")}
        self._times["robot_time"] = np.empty(room)
        self._absent: set[str] = set()
        self._every = every

    def add(self, piece: Piece) -> None:
        """Append a piece."""
        kept = slice(-self.rows % self._every, None, self._every)
        rows = slice(self.count, self.count + len(piece.log_time[kept]))
        if rows.stop > len(self._times["log_time"]):
            self.resize(max(rows.stop, 2 * rows.start))
        self.rows, self.count = self.rows + len(piece.log_time), rows.stop
        for name, array in self.channels.items():
            for joint, column in enumerate(piece.channels[name]):
                array[rows, joint] = column[kept]
        for name, times in self._times.items():
            if (own := getattr(piece, name)) is None:
                self._absent.add(name)
            else:
                times[rows] = own[kept]

    def resize(self, rows: int) -> None:
        """Move everything, one array at a time; memory that was never written to costs nothing."""
        for arrays in (self.channels, self._times):
            for name, old in arrays.items():
                new = np.empty((rows, *old.shape[1:]), old.dtype, order="F")
                new[: self.count] = old[: self.count]
                arrays[name] = new

    @property
    def times(self) -> tuple[Int, Int | None, Float | None]:
        """Time of recording, time stamp of the source, the robot's own clock; None if a piece has none."""
        log_time, *others = (array[: self.count] for array in self._times.values())
        stamp, robot_time = (None if name in self._absent else one for name, one in zip(_CLOCKS, others, strict=True))
        return log_time, stamp, robot_time


class JointDecoder:
    """Decodes blocks of one topic to the values of some joints."""

    def __init__(self, chosen: Candidate, joints: tuple[str, ...], channels: Sequence[str]) -> None:
        self.undecodable = self.incomplete = 0  # messages that do not fit their definition, or lack some of the joints
        kind = chosen.kind
        self.chosen, self.joints, self._channels = chosen, joints, channels
        self._paths = [*(kind.fields[name] for name in channels), *kind.stamp_paths]
        self._paths += [kind.robot_time] if kind.robot_time else []
        self._fast: dict[int, BlockDecoder] = {}
        self._columns: dict[tuple[str, ...], NDArray[np.intp]] = {}

    def decode(self, block: Block) -> Piece:
        """Decode by the layout in use, or by that of the block's own first message; else message by message."""
        known = self._fast.get(block.key)
        records = known.decode(block) if known else None
        if records is None and (known := self._block_decoder(block)) is not None:
            records = known.decode(block)
        if known is None or records is None:
            return self.of_messages(block)
        self._fast[block.key] = known
        return self._of_records(records, known.layout, block) or self.of_messages(block)

    def _block_decoder(self, block: Block) -> BlockDecoder | None:
        layout = self.chosen.decoders[block.key].layout(block.payload(0))
        if layout is None or any(path not in layout.numbers for path in self._paths):
            return None
        return BlockDecoder(layout, block.payload(0), tuple(dict.fromkeys(self._paths)))

    def _columns_of(self, names: tuple[str, ...]) -> NDArray[np.intp]:
        """Return, for each joint, its index in a message with these names, or -1 where it lacks the joint."""
        columns = self._columns.get(names)
        if columns is None:
            place = {name: index for index, name in reversed(list(enumerate(names)))}
            columns = self._columns[names] = np.array([place.get(joint, -1) for joint in self.joints], np.intp)
        return columns

    def _of_records(self, records: Records, layout: Layout, block: Block) -> Piece | None:
        """View records of constant layout; None if their arrays do not fit their names."""
        kind = self.chosen.kind
        names = layout.strings.get(kind.names, ()) if kind.names else ()
        if not any(names):
            counts = [layout.numbers[path].count for path in kind.fields.values() if path in layout.numbers]
            names = numbered_joints(max(counts))
        columns, fields = self._columns_of(names), {name: records[kind.fields[name]] for name in self._channels}
        if (columns < 0).any() or any(field.shape[1] != len(names) for field in fields.values()):
            return None
        stamp = None
        if kind.stamps:
            seconds, nanoseconds = kind.stamp_paths
            stamp = records[seconds][:, 0].astype(np.int64) * _NANOSECONDS + records[nanoseconds][:, 0]
        robot_time = records[kind.robot_time][:, 0] if kind.robot_time else None
        channels = {name: [field[:, column] for column in columns] for name, field in fields.items()}
        return Piece(block.log_time, stamp, robot_time, channels)

    def of_messages(self, block: Block) -> Piece:
        """Decode message by message, with the library's decoder; one that holds none of the joints is passed over."""
        decoder, found = self.chosen.decoders[block.key], list[tuple[int, Row, NDArray[np.intp]]]()
        for index, log_time in enumerate(block.log_time.tolist()):
            try:
                row = row_of(decoder.decode(block.payload(index)), self.chosen.kind)
            except UndecodableError:
                self.undecodable += 1
                continue
            columns = self._columns_of(row.names) if len(row.names) <= MOST_JOINTS else None
            if columns is None:
                self.undecodable += 1
                continue
            self.incomplete += bool((columns < 0).any() and (columns >= 0).any())
            if (columns >= 0).any():
                found.append((log_time, row, columns))
        arrays = {name: np.full((len(self.joints), len(found)), np.nan) for name in self._channels}
        for at, (_, row, columns) in enumerate(found):
            for name, array in arrays.items():
                values = row.channels.get(name, np.empty(0))
                there = (columns >= 0) & (columns < len(values))
                array[there, at] = values[columns[there]]
        stamps, times = [row.stamp for _, row, _ in found], [row.robot_time for _, row, _ in found]
        return Piece(
            np.array([log_time for log_time, *_ in found], np.int64),
            None if None in stamps else np.array(stamps, np.int64),
            None if None in times else np.array(times, np.float64),
            {name: list(array) for name, array in arrays.items()},
        )


_FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
_DISAGREEMENT_SD_S = 5e-3
_DISAGREEMENT_STEPS = 2.0
_DISAGREEMENT_DRIFT = 2e-4
_ROBOT_TIME_UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
_UNIT_TOLERANCE = 0.2
_TITLES = {"robot_time": "the robot's own time", "header_stamp": "the header stamp", "log_time": "the log time"}


@dataclass(frozen=True, eq=False, slots=True)
class MessageClock:
    """The clock chosen for the messages."""

    name: str
    t: Float  # time from its smallest value [s]
    origin_s: float  # its reading at t = 0 [s]
    start_s: float | None  # that, if it is Unix time [s]
    findings: tuple[Finding, ...]
    first: Any  # its smallest value, in its own unit
    per_second: float  # of the robot's own time, as it is written

    def time_of(self, log_time: Int, stamp: Int | None, robot_time: Float | None) -> Float:
        """Return t of other messages."""
        if self.name == "robot_time":
            return np.asarray(np.asarray(robot_time) / self.per_second - self.first)
        raw = log_time if stamp is None or self.name == "log_time" else stamp
        return np.asarray((raw - self.first) / 1e9)


def choose_clock(log_time: Int, stamp: Int | None, robot_time: Float | None) -> MessageClock:
    """Choose the best clock that runs.

    Args:
        log_time: Time of recording, shape (n,) [ns]
        stamp: Time stamp of the source, if there is one. [ns]
        robot_time: The robot's own clock, if there is one. [s]
    """
    robot_time, findings = (None, []) if robot_time is None else _in_seconds(robot_time, log_time)
    per_second = float(findings[0].amount or 1.0) if findings else 1.0
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    offered = {
        "robot_time": None if robot_time is None else robot_time - np.min(robot_time),
        "header_stamp": None if stamp is None else (stamp - stamp.min()) / 1e9,
        "log_time": (log_time - log_time.min()) / 1e9,
    }
    clocks = {name: t for name, t in offered.items() if t is not None}
    # A single message cannot show that a clock runs.
    running = [n for n, t in clocks.items() if np.isfinite(t).all() and (len(t) == 1 or t.max() > 0.0)]
    chosen = next(iter(running), "log_time")
    for name in (name for name in clocks if name not in (*running, chosen)):
        text = f"{_TITLES[name]} is the same (or not a number) in all messages; {_TITLES[chosen]} was used"
        findings.append(Finding(code="clock_stopped", message=text))
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    # The robot's clock counts from its start, so the log time stands in for it.
    source = stamp if chosen == "header_stamp" and stamp is not None else log_time
    start_s = float(source.min()) / 1e9
    unix_s = start_s if start_s > _FIRST_UNIX_TIME_S else None
    first = {"robot_time": robot_time, "header_stamp": stamp, "log_time": log_time}[chosen]
    assert first is not None
    return MessageClock(chosen, clocks[chosen], start_s, unix_s, tuple(findings), first.min(), per_second)


def _in_seconds(robot_time: Float, log_time: Int) -> tuple[Float, list[Finding]]:
    """Recognise a robot's clock that counts in milli-, micro- or nanoseconds: by that factor faster than the log."""
    logged_s = float(np.ptp(log_time)) / 1e9
    ratio = float(np.ptp(robot_time)) / logged_s if logged_s > 0.0 else 1.0
    for factor, unit in _ROBOT_TIME_UNITS:
        if abs(ratio / factor - 1.0) < _UNIT_TOLERANCE:
            text = (
                f"the robot's own time counts in {unit}, by comparison with the log time; it was divided by {factor:g}"
            )
            return robot_time / factor, [Finding(code="robot_time_unit", message=text, amount=factor)]
    return robot_time, []


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    difference = log_t - t
    centred = t - t.mean()
    drift = float(centred @ difference / (centred @ centred))
    sd_s = float(np.std(difference - drift * centred))
    limit_s = max(_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    findings = []
    if sd_s > limit_s:
        text = f"{_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"
        findings.append(Finding(code="clock_disagreement", amount=sd_s, message=f"{text}; {chosen} was used"))
    if abs(drift) > _DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        text = f"the log time runs {drift * 100:+.3g} % against {_TITLES[chosen]}"
        findings.append(Finding(code="clock_disagreement", amount=drift, message=f"{text}; {chosen} was used"))
    return findings
