"""The values of some joints in messages, block by block and as arrays, and their clock."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.message_decoder import Layout, Records
from friction_audit.io.readers.message_kinds import Candidate, Row, rows_of
from friction_audit.io.readers.message_stream import Block, BrokenError, Int
from friction_audit.joint_log import Finding, Float

_NANOSECONDS = 10**9
# Clocks and their units per second, the best first: the robot's own, the time stamp of the source, the recorder's.
_CLOCKS = {"robot_time": 1.0, "header_stamp": 1e9, "log_time": 1e9}
_SMALLEST_CAPACITY = 1024

Times = Mapping[str, NDArray[Any]]  # clock that all messages have -> its readings, nanoseconds as integers


# Values of some joints in messages that follow each other: the clocks, and channel -> a column per joint.
Piece = tuple[Times, Mapping[str, Sequence[NDArray[Any]]]]


class JointSamples:
    """Pieces one after the other in arrays, channels of shape (n, j) in Fortran order."""

    def __init__(self, joints: int, channels: Iterable[str], expected: int, *, every: int = 1) -> None:
        """Make room for the number of samples expected, which grows with the pieces; keep one of so many."""
        room = max(expected // every, _SMALLEST_CAPACITY)
        self.rows = self.count = 0  # samples so far, and those of them that are kept
        self.channels = {name: np.empty((room, joints), order="F") for name in channels}
        self._times = {name: np.empty(room, np.int64 if unit > 1.0 else np.float64) for name, unit in _CLOCKS.items()}
        self._every = every

    def add(self, piece: Piece) -> None:
        """Append a piece."""
        found, channels = piece
        count = len(found["log_time"])
        kept = slice(-self.rows % self._every, None, self._every)
        rows = slice(self.count, self.count + len(range(count)[kept]))
        if rows.stop > len(self._times["log_time"]):
            self.resize(max(rows.stop, 2 * rows.start))
        self.rows, self.count = self.rows + count, rows.stop
        for name, array in self.channels.items():
            for joint, column in enumerate(channels[name]):
                array[rows, joint] = column[kept]
        self._times = {name: times for name, times in self._times.items() if name in found}
        for name, times in self._times.items():
            times[rows] = found[name][kept]

    def resize(self, rows: int) -> None:
        """Move everything, one array at a time; memory that was never written to costs nothing."""
        for arrays in (self.channels, self._times):
            for name, old in arrays.items():
                new = np.empty((rows, *old.shape[1:]), old.dtype, order="F")
                new[: self.count] = old[: self.count]
                arrays[name] = new

    @property
    def times(self) -> Times:
        """The clocks that all pieces have."""
        return {name: array[: self.count] for name, array in self._times.items()}


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
            counts = [layout.numbers[path].count for path in kind.fields.values() if path in layout.numbers]
            names = tuple(f"joint{k + 1}" for k in range(max(counts)))
        columns, fields = _columns_of(names, self.joints), {name: records[kind.fields[name]] for name in self._channels}
        if (columns < 0).any() or any(field.shape[1] != len(names) for field in fields.values()):
            return None
        times = {"log_time": block.log_time}
        if self._stamp:
            seconds, nanoseconds = (records[path][:, 0] for path in self._stamp)
            times["header_stamp"] = seconds.astype(np.int64) * _NANOSECONDS + nanoseconds
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


_FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS, _DISAGREEMENT_DRIFT = 5e-3, 2.0, 2e-4
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
    first: Any  # its smallest reading
    per_second: float  # of its units


def choose_clock(times: Times) -> MessageClock:
    """Choose the best clock that runs."""
    units, findings = dict(_CLOCKS), list[Finding]()
    if "robot_time" in times:
        units["robot_time"], findings = _robot_unit(times["robot_time"], times["log_time"])
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    first = {name: times[name].min() for name in units if name in times}
    clocks: dict[str, Float] = {name: (times[name] - low) / units[name] for name, low in first.items()}
    # A single message cannot show that a clock runs.
    running = [n for n, t in clocks.items() if np.isfinite(t).all() and (len(t) == 1 or t.max() > 0.0)]
    chosen = next(iter(running), "log_time")
    for name in (name for name in clocks if name not in (*running, chosen)):
        text = f"{_TITLES[name]} is the same (or not a number) in all messages; {_TITLES[chosen]} was used"
        findings.append(Finding("clock_stopped", text))
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    # The robot's clock counts from its start, so the log time stands in for it.
    start_s = float(first["log_time" if chosen == "robot_time" else chosen]) / _NANOSECONDS
    unix_s = start_s if start_s > _FIRST_UNIX_TIME_S else None
    return MessageClock(chosen, clocks[chosen], start_s, unix_s, tuple(findings), first[chosen], units[chosen])


def _robot_unit(robot_time: Float, log_time: Int) -> tuple[float, list[Finding]]:
    """Recognise a robot's clock that counts in milli-, micro- or nanoseconds: by that factor faster than the log."""
    logged_s = float(np.ptp(log_time)) / _NANOSECONDS
    ratio = float(np.ptp(robot_time)) / logged_s if logged_s > 0.0 else 1.0
    for factor, unit in _ROBOT_TIME_UNITS:
        if abs(ratio / factor - 1.0) < _UNIT_TOLERANCE:
            text = f"the robot's own time counts in {unit} by the log time; it was divided by {factor:g}"
            return factor, [Finding("robot_time_unit", text, amount=factor)]
    return 1.0, []


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    difference = log_t - t
    centred = t - t.mean()
    drift = float(centred @ difference / (centred @ centred))
    sd_s = float(np.std(difference - drift * centred))
    limit_s = max(_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    texts = {}
    if sd_s > limit_s:
        texts[f"{_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"] = sd_s
    if abs(drift) > _DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        texts[f"the log time runs {drift * 100:+.3g} % against {_TITLES[chosen]}"] = drift
    return [Finding("clock_disagreement", f"{text}; {chosen} was used", amount=one) for text, one in texts.items()]
