"""A table -> Recording: what CSV, Parquet and npz share once the container has named its columns."""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from math import inf, isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, few
from friction_audit.io.readers.channel_names import choose_arm, robot_of
from friction_audit.io.readers.clocks import Clock, TimeColumn, stamps_of, to_clock
from friction_audit.io.readers.columns import MOST_JOINTS, REQUIRED, ColumnMap, absent, doubt_torque, map_columns
from friction_audit.io.readers.join import interpolated
from friction_audit.io.readers.reader import IN_BLOCKS_BYTES, ReadOptions, refuse_bomb, refuse_too_large
from friction_audit.io.recording import Block, Blocks, Recording, WholeLogError
from friction_audit.joint_log import Bool, Finding, Float, find_window

ROBOT_COLUMN = re.compile(r"\s*(?:robot|arm)(?:[ _-]?(?:name|id|number|no|serial))?\s*", re.IGNORECASE)
_WHOLE = re.compile(r"^(\d+)\.0+$")  # a joint's number in a column that was written as floats


class Part(NamedTuple):
    """The numbers that were read of a table: all of it, or the part asked for."""

    clock: Clock  # its clock, n rows
    channels: dict[str, Float]  # channel -> array of shape (n, columns), Fortran order
    joint: NDArray[Any] | None = None  # Joint of each row of a long table, shape (n,), else None
    first_s: float | None = None  # first stamp of the whole table on the clock, where a part was read [s]
    blocks: Blocks | None = None  # how to read it block by block, instead of the channels


class Table(ABC):
    """An open table; each container derives from it, and fills in what it knows."""

    may_be_long = True  # False if a table of this container never has one row per joint and time
    labels: Mapping[int, str] = {}  # position of a column -> its joint, where joint names stand next to the numbers
    constant: frozenset[int] = frozenset()  # positions of columns seen not to change
    joint_names: Sequence[str] = ()  # these, the robot and the serial number as the file states them apart from columns
    robot = "unknown"
    serial = ""
    start_s: float | None = None  # Unix time of the first row, as the file states it apart from its columns [s]
    clock: TimeColumn | None = None  # the clock as the container knows it, for the column of the same name
    damage: tuple[Finding, ...] = ()  # found when it was opened

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self.path = path
        self.names = names  # of the columns that hold one number per row; elements of lists as name[0], name[1]...

    def refuse_several_robots(self, first: Mapping[str, Iterable[object]]) -> None:
        """Refuse a table whose first rows are of several robots, by the values of the columns that say it."""
        for name, values in first.items():
            robots = sorted({str(value).strip() for value in values})
            if len(robots) > 1:
                raise InputError(
                    f"{self.path}: the rows are of several robots: column {name} holds {', '.join(few(robots))}; "
                    "expected one robot; keep the rows of one, or rename the column if it holds something else"
                )

    @abstractmethod
    def read(self, columns: ColumnMap, options: ReadOptions) -> Part:
        """Read the columns; of a large table the part asked for alone."""

    def findings(self) -> tuple[Finding, ...]:
        """Return the damage found so far."""
        return self.damage


class ColumnTable(Table):
    """A table that is stored column by column, so that the clock can be read before all else."""

    def read(self, columns: ColumnMap, options: ReadOptions) -> Part:
        rows, packed = self.size(columns)
        row_bytes = np.float64().itemsize * (1 + sum(map(len, columns.channels.values())))
        is_part = options.reads_part(rows * row_bytes)
        if options.in_blocks and columns.joint is None and rows * row_bytes > IN_BLOCKS_BYTES:
            refuse_bomb(self.path, rows * row_bytes, packed)
            part = self.in_blocks(columns)
            if part is not None:
                return part
        refuse_too_large(self.path, rows * (np.float64().itemsize if is_part else row_bytes), packed)
        if not is_part:
            return self.read_rows(columns, self.read_clock(columns.time), None)
        # The joints of a long table may follow each other.
        whole = options.hashed or options.in_blocks or columns.joint is not None
        start, stop = options.window_of_clock()
        clock = self.read_clock(columns.time, inf if whole else stop)
        first_s = float(np.nanmin(clock.t))
        since = clock.t - first_s
        kept = (since >= start) & (since < stop)
        if not kept.any():
            times = np.sort(since[np.isfinite(since)]) * options.time_scale
            find_window(times, options.t_start_s, options.t_end_s, str(self.path))
        clock = clock._replace(t=clock.t[kept])
        refuse_too_large(self.path, len(clock.t) * row_bytes, packed)
        return self.read_rows(columns, clock, kept)._replace(first_s=first_s)

    @abstractmethod
    def size(self, columns: ColumnMap) -> tuple[int, int]:
        """Return the number of rows, and the bytes that these columns take in the file."""

    @abstractmethod
    def read_clock(self, time: TimeColumn, stop: float = inf) -> Clock:
        """Read all stamps, or of a clock in order at least those up to so long after the first. [s]"""

    @abstractmethod
    def read_rows(self, columns: ColumnMap, clock: Clock, rows: Bool | None) -> Part:
        """Read the channels, in the rows of a mask or in all."""

    def in_blocks(self, columns: ColumnMap) -> Part | None:  # noqa: ARG002
        """Read the first stamps alone, and say how to read blocks; None where the container does not allow that."""
        return None


Pieces = Callable[..., Iterator[dict[int, NDArray[Any]]]]
"""Yields some columns of a table, by position, in one piece after the other; the first stamps come first."""


def part_in_blocks(
    columns: ColumnMap, unit: str | None, rows: int, pieces: Pieces, path: str, groups: Sequence[int] = ()
) -> Part:
    """Read the first stamps, which say what the clock is, and return how blocks are read.

    ``groups`` are the first rows of groups of rows, from the number of which on pieces may be asked for.
    """
    time = columns.time
    first = next(stamps_of([piece[cell] for cell in time.cells]) for piece in pieces(time.cells))
    origin = first[np.isfinite(first).argmax()].item()
    clock, is_sound = to_clock(first, unit, path=path), False

    def read(names: Collection[str], *group: int) -> Iterator[Block]:
        nonlocal is_sound
        wanted = {channel: cells for channel, cells in columns.channels.items() if channel in names}
        try:
            for piece in pieces([*time.cells, *(cell for cells in wanted.values() for cell in cells)], *group):
                t = to_clock(stamps_of([piece[cell] for cell in time.cells]), clock.unit, path=path, origin=origin).t
                yield t, {c: np.array([piece[cell] for cell in cells], np.float64).T for c, cells in wanted.items()}
        except (InputError, WholeLogError, OSError) as error:
            if is_sound:
                raise InputError(f"{path}: changed while it was read; read it again when it is finished") from error
            raise WholeLogError from error  # where all is read at once, it says what is wrong, or leaves it out
        is_sound |= len(wanted) == len(columns.channels)

    def since(row: int) -> tuple[int, Callable[[Collection[str]], Iterator[Block]]]:
        group = int(np.searchsorted(groups, row, side="right")) - 1
        return groups[group], lambda names: read(names, group)

    nothing = {channel: np.empty((0, len(cells))) for channel, cells in columns.channels.items()}
    blocks = Blocks(rows=rows, read=read, since=since if groups else None)
    return Part(clock=clock._replace(t=np.empty(0)), channels=nothing, blocks=blocks)


def read_table(table: Table, options: ReadOptions) -> Recording:
    """Read the recording in a table; InputError, or SeveralLogsError if it holds several arms and none was named."""
    path, topic = str(table.path), options.topic
    stated, _, arm = (topic or "").partition("#")
    if stated or (topic is not None and not arm):
        raise InputError(f"{path}: a table has no topics, and --topic asks for {topic}; leave --topic out")
    mapping = options.mapping
    if options.partial:  # what another file of the log has is looked for there
        lost = absent(mapping, table.names)
        mapping = {channel: name for channel, name in mapping.items() if channel not in lost}
    try:
        needed = () if options.partial else REQUIRED
        columns = map_columns(table, mapping, arm, needed=needed, is_long=table.may_be_long)
    except InputError as error:
        damage = (finding.message for finding in table.findings())
        raise InputError("; ".join((str(error), *damage))) from error
    if table.clock is not None and table.clock.name == columns.time.name:
        columns = columns._replace(time=table.clock._replace(cells=columns.time.cells))
    part = table.read(columns, options)
    columns = columns._replace(findings=(*columns.findings, *table.findings()))
    if part.joint is not None:
        columns, part = _pivot(columns, part, arm, path)
    columns = columns._replace(findings=(*columns.findings, *doubt_torque(columns, table.names, mapping)))
    recording = Recording(
        t=part.clock.t,
        channels=part.channels,
        joint_names=columns.joint_names,
        clock=columns.time.clock,
        start_s=part.clock.start_s,
        origin_s=part.clock.origin_s,
        guessed_unit=part.clock.unit if columns.time.unit is None and part.clock.start_s is None else "",
        first_s=part.first_s,
        robot=robot_of(columns.joint_names),
        serial=table.serial,
        mapping={"t": f"{columns.time.name} [{part.clock.unit}]", **columns.mapping},
        findings=columns.findings,
        blocks=part.blocks,
    )
    for channel, per_turn in columns.per_turn.items():
        recording = recording.scaled(channel, 2.0 * np.pi / per_turn)
    return recording if columns.joint is not None else _with_stated(recording, table)


def _with_stated(recording: Recording, table: Table) -> Recording:
    """Add the start, the joints and the robot that the file states apart from its columns."""
    if recording.start_s is None and table.start_s is not None:
        stamps = [0.0] if recording.blocks is not None else recording.t  # a clock read in blocks begins at 0
        start_s = table.start_s - float(stamps[0] if recording.first_s is None else recording.first_s)
        recording = replace(recording, start_s=start_s if isfinite(start_s) else None)
    if table.labels or len(table.joint_names) != len(recording.joint_names):
        return recording
    robot = table.robot if table.robot != "unknown" else robot_of(table.joint_names)
    robot = recording.robot if robot == "unknown" else robot
    return replace(recording, joint_names=tuple(table.joint_names), robot=robot)


def _pivot(columns: ColumnMap, part: Part, arm: str, path: str) -> tuple[ColumnMap, Part]:
    """Bring a long table to one row per time; rows of times that some joint lacks are left out."""
    import pyarrow as pa

    coded = pa.array(part.joint, from_pandas=True).dictionary_encode()
    codes, labels = coded.indices.fill_null(-1).to_numpy(), coded.dictionary.to_pylist()
    if len(labels) > MOST_JOINTS:
        raise InputError(f"{path}: {len(labels)} names of joints; expected at most {MOST_JOINTS}; name another column")
    texts = [_WHOLE.sub(r"\1", str(label).strip()) for label in labels]
    kept = [texts.index(text) for text in choose_arm(texts, arm, path=path)]
    if not kept:
        raise InputError(f"{path}: 0 samples; the table has a header and no rows; record the arm while it moves")
    clock, every = part.clock, [np.flatnonzero(codes == code) for code in kept]
    rows, t, lost = every, clock.t[every[0]], 0
    if not all(np.array_equal(clock.t[own], t) for own in every):
        t = reduce(np.intersect1d, (clock.t[own] for own in every))  # the times that all joints have
        rows = [own[np.intersect1d(clock.t[own], t, return_indices=True)[1]] for own in every]
        lost = sum(map(len, every)) - len(every) * len(t)
    channels = {channel: np.empty((len(rows[0]), len(kept)), order="F") for channel in part.channels}
    for channel, column in part.channels.items():
        for place, chosen in enumerate(rows):
            channels[channel][:, place] = column[chosen, 0]
    names = [texts[code] for code in kept]
    message = f"{lost} rows belong to times at which other joints have no row; they are left out"
    found = (Finding("incomplete_rows", message, amount=float(lost), damaged=True),) if lost else ()
    if 2 * lost > sum(map(len, every)):
        t, channels = _at_stamps_of_first(every, clock.t, part.channels)
        message = f"every joint has its own stamps: all are interpolated linearly at those of joint {names[0]}"
        found = (Finding("joined", message, amount=float(len(every[0]) - len(t))),)
    if all(map(str.isdigit, names)):
        base = 0 if any(int(name) == 0 for name in names) else 1
        names = [f"joint{int(name) - base + 1}" for name in names]
    columns = columns._replace(joint_names=tuple(names), findings=(*columns.findings, *found))
    return columns, part._replace(clock=clock._replace(t=t), channels=channels)


def _at_stamps_of_first(
    rows: list[NDArray[np.intp]], time: Float, channels: Mapping[str, Float]
) -> tuple[Float, dict[str, Float]]:
    """Return the stamps of the first joint, and all joints interpolated there, without gaps and ends of any joint."""
    t = time[rows[0]]
    found = {channel: np.empty((len(t), len(rows)), order="F") for channel in channels}
    for place, own in enumerate(rows):
        for channel, column in channels.items():
            found[channel][:, place] = interpolated(t, time[own], column[own, 0])
    kept = np.logical_and.reduce([np.isfinite(array).all(axis=1) for array in found.values()])
    return t[kept], {channel: array[kept] for channel, array in found.items()}
