"""A table -> Recording: what CSV, Parquet and npz share once the container has named its columns."""

import re
from abc import ABC, abstractmethod
from bisect import bisect
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from itertools import chain
from math import inf, isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, few
from friction_audit.io.readers.channel_names import choose_arm, robot_of
from friction_audit.io.readers.clocks import Clock, Stamps, TimeColumn
from friction_audit.io.readers.columns import MOST_JOINTS, REQUIRED, ColumnMap, absent, doubt_torque, map_columns
from friction_audit.io.readers.join import interpolated
from friction_audit.io.readers.reader import IN_BLOCKS_BYTES, ReadOptions, refuse_bomb, refuse_too_large
from friction_audit.io.recording import Block, Blocks, Recording, WholeLogError
from friction_audit.joint_log import Bool, Finding, Float, find_window
from friction_audit.parallel import per_joint

ROBOT_COLUMN = re.compile(r"\s*(?:robot|arm)(?:[ _-]?(?:name|id|number|no|serial))?\s*", re.IGNORECASE)
_WHOLE = re.compile(r"^(\d+)\.0+$")  # a joint's number in a column that was written as floats


Cells = dict[int, NDArray[Any]]  # position of a column -> its numbers or words
# Yields some columns by position, many rows of all of them at a time, from a group of rows on; the first stamps first.
Pieces = Callable[..., Iterator[Cells]]
Piece = tuple[int, NDArray[Any]]  # number of the first column of an array, and numbers of many rows, (m, k)
Rows = tuple[int, float]  # that are read at least, from one to before another one
ALL = (0, inf)


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
    groups: Sequence[int] = (0,)  # first rows of groups of rows, from each of which on it may be read
    slower = 1  # times as long as reading the same numbers takes elsewhere: smaller tables are not read twice

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

    def findings(self) -> tuple[Finding, ...]:
        """Return the damage found so far."""
        return self.damage

    @abstractmethod
    def size(self, columns: ColumnMap) -> tuple[int, int, str | None]:
        """Return the number of rows, of a text table about, and the bytes that these columns take in the file.

        The third is the unit of the stamps, None where their values decide.
        """

    def in_blocks(self, columns: ColumnMap) -> tuple[int, Pieces] | None:  # noqa: ARG002
        """Return the exact number of rows and how they are read, or None where the table cannot be read in blocks."""
        return None

    @abstractmethod
    def gather(self, columns: ColumnMap, stamps: Stamps, part: ReadOptions | None, rows: int) -> Part:
        """Read a number of rows, which are all, or those of the part that the options ask for."""

    def read(self, columns: ColumnMap, options: ReadOptions) -> Part:
        """Read the columns; of a large table the part asked for alone, or how blocks are read."""
        rows, packed, unit = self.size(columns)
        row_bytes = np.float64().itemsize * (1 + sum(map(len, columns.channels.values())))
        if options.in_blocks and columns.joint is None and rows * row_bytes > self.slower * IN_BLOCKS_BYTES:
            refuse_bomb(self.path, rows * row_bytes, packed)
            if (found := self.in_blocks(columns)) is not None:
                return self._read_in_blocks(columns, Stamps(unit), *found)
        is_part = options.reads_part(rows * row_bytes)
        refuse_too_large(self.path, rows * (np.float64().itemsize if is_part else row_bytes), packed)
        return self.gather(columns, Stamps(unit), options if is_part else None, rows)

    def _read_in_blocks(self, columns: ColumnMap, stamps: Stamps, rows: int, pieces: Pieces) -> Part:
        """Read the first stamps, which say what the clock is, and return how blocks are read."""
        path, time, is_sound = str(self.path), columns.time, False
        try:
            first = next(pieces(time.cells))
            clock = stamps.clock(stamps.since([first[cell] for cell in time.cells]), path)
        except (InputError, OSError) as error:
            raise WholeLogError from error  # where all is read at once, it says what is wrong, or leaves it out

        def read(names: Collection[str], **group: int) -> Iterator[Block]:
            nonlocal is_sound
            wanted = {channel: cells for channel, cells in columns.channels.items() if channel in names}
            cells = [*time.cells, *chain.from_iterable(wanted.values())]
            try:
                for piece in pieces(cells, **group):
                    t = stamps.clock(stamps.since([piece[cell] for cell in time.cells]), path).t
                    yield t, {c: np.array([piece[cell] for cell in own], np.float64).T for c, own in wanted.items()}
            except (InputError, WholeLogError, OSError) as error:
                if is_sound:
                    raise InputError(f"{path}: changed while it was read; read it again when it is finished") from error
                raise WholeLogError from error
            is_sound |= len(wanted) == len(columns.channels)

        nothing = {channel: np.empty((0, len(cells))) for channel, cells in columns.channels.items()}
        blocks = Blocks(rows=rows, read=read, groups=self.groups)
        return Part(clock._replace(t=np.empty(0)), nothing, blocks=blocks)


class ColumnTable(Table):
    """A table that is stored array by array, so that the stamps can be read before all else."""

    arrays: list[tuple[str, int]]  # of each column, by position: name of its array, and number in it

    @abstractmethod
    def pieces(self, columns: ColumnMap, name: str, rows: Rows) -> Iterator[Piece]:
        """Yield an array as it lies in the file, from the group of rows on in which the rows asked for begin."""

    def gather(self, columns: ColumnMap, stamps: Stamps, part: ReadOptions | None, rows: int) -> Part:
        clock, kept, first_s = self._read_clock(columns, stamps, part, rows), np.ones(rows, np.bool_), None
        if part is not None:
            first_s = float(np.nanmin(clock.t))
            elapsed, (start, stop) = clock.t - first_s, part.window_of_clock()
            kept = (elapsed >= start) & (elapsed < stop)
            if not kept.any():
                times = np.sort(elapsed[np.isfinite(elapsed)]) * part.time_scale
                find_window(times, part.t_start_s, part.t_end_s, str(self.path))
            clock = clock._replace(t=clock.t[kept])
        size = len(clock.t) * np.float64().itemsize * (1 + sum(map(len, columns.channels.values())))
        refuse_too_large(self.path, size, size)
        channels = {c: np.empty((len(clock.t), len(cells)), order="F") for c, cells in columns.channels.items()}
        words = [] if columns.joint is None else [(columns.joint, np.empty(len(clock.t), object))]
        each = [(cell, channels[c][:, j]) for c, cells in columns.channels.items() for j, cell in enumerate(cells)]
        wanted = defaultdict[str, dict[int, list[NDArray[Any]]]](lambda: defaultdict(list))
        for cell, target in [*each, *words]:
            wanted[self.arrays[cell][0]][cell].append(target)
        lots = list(wanted.values())
        per_joint(lambda number: self._fill(columns, lots[number], kept), len(lots))
        return Part(clock, channels, words[0][1] if words else None, first_s=first_s)

    def _read_clock(self, columns: ColumnMap, stamps: Stamps, part: ReadOptions | None, rows: int) -> Clock:
        """Read all stamps, or of a clock in order at least those up to the end of the part."""
        t, count = np.empty(rows), 0
        # The joints of a long table may follow each other.
        whole = part is None or part.hashed or part.in_blocks or columns.joint is not None
        for both in zip(*(self.columns(columns, [cell]) for cell in columns.time.cells), strict=True):
            elapsed = stamps.since([values for _, values in both])
            t[count : count + len(elapsed)], count = elapsed, count + len(elapsed)
            if whole or part is None or stamps.origin is None:
                continue
            if elapsed[-1] / stamps.unit_of(elapsed) > part.window_of_clock()[1]:
                break
        return stamps.clock(t[:count], str(self.path))

    def _fill(self, columns: ColumnMap, targets: Mapping[int, Sequence[NDArray[Any]]], kept: Bool) -> None:
        """Read columns of an array into others, in the rows of a mask."""
        first, last = int(kept.argmax()), len(kept) - int(kept[::-1].argmax())
        begin = self.groups[bisect(self.groups, first) - 1]
        seen, filled = dict.fromkeys(targets, begin), dict.fromkeys(targets, 0)
        for cell, values in self.columns(columns, [*targets], (first, last)):
            own = kept[seen[cell] : seen[cell] + len(values)]
            numbers = values if own.all() else values[: len(own)][own]
            for target in targets[cell]:
                target[filled[cell] : filled[cell] + len(numbers)] = numbers
            seen[cell], filled[cell] = seen[cell] + len(values), filled[cell] + len(numbers)

    def columns(self, columns: ColumnMap, cells: Sequence[int], rows: Rows = ALL) -> Iterator[Piece]:
        """Yield pieces of some columns of one array, each with its position."""
        for begin, array in self.pieces(columns, self.arrays[cells[0]][0], rows):
            for cell in cells:
                if 0 <= (place := self.arrays[cell][1] - begin) < array.shape[1]:
                    yield cell, array[:, place]


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
