"""Parquet -> Recording: scalar columns, or one list-valued column per channel."""

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow.parquet import FileMetaData, ParquetFile

from friction_audit.errors import InputError
from friction_audit.io.readers import arrow
from friction_audit.io.readers.channel_names import is_label, labels_of
from friction_audit.io.readers.clocks import Clock, TimeColumn, stamps_of, to_clock
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.reader import ReadOptions, Topic, serial_in
from friction_audit.io.readers.table import ROBOT_COLUMN, ColumnTable, Part, part_in_blocks, read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Bool, Finding
from friction_audit.parallel import per_joint
from friction_audit.presets import PRESETS

# Of a batch, of which about ten are in memory; of fewer rows, calls take the time. What is kept of the cycles of a log
# grows by ten bytes in so many numbers, and the batches of a long one leave it room.
_BATCH_ROWS, _BATCH_BYTES, _FEWEST_BYTES, _NUMBERS_PER_BYTE = 1 << 16, 1 << 23, 4 << 20, 450
_BUFFER_BYTES = 1 << 17
_LOOK_ROWS = 1000  # the first list that is not empty is among them: the first messages of a topic may be empty


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a Parquet file."""
    try:
        with _open(path) as file:
            return read_table(ParquetTable(path, file), options)
    except MemoryError:  # Arrow's own is an ArrowException too
        raise
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: a damaged or unfinished Parquet file: {error}; its index is at its end, so nothing can be "
            "salvaged; copy or record it again"
        ) from error


def _open(path: Path, metadata: FileMetaData | None = None) -> ParquetFile:
    # A buffer for a page or two: without it, a column of a whole row group is in memory as it lies in the file.
    options = {"page_checksum_verification": True, "buffer_size": _BUFFER_BYTES, "pre_buffer": False}
    return ParquetFile(path, metadata=metadata, **options)


class ParquetTable(ColumnTable):
    """A Parquet file.

    Column by column is as fast as all at once, and only one row group of one column per thread is in memory next to the
    arrays that are kept. A row group of a column whose checksum is wrong is left out.
    """

    def __init__(self, path: Path, file: ParquetFile) -> None:
        """Name the numbers of a row: scalars, and the elements of lists as long as the first that is not empty."""
        fields = arrow.flat(pa.Table.from_batches([], file.schema_arrow)).schema
        self._file, self._damage = file, dict[tuple[str, int], str]()
        self._types = {field.name: field.type for field in fields}
        self._sizes = [file.metadata.row_group(group).num_rows for group in range(file.metadata.num_row_groups)]
        lists = [field.name for field in fields if arrow.is_of(field.type, "list")]
        scalars = [field.name for field in fields if field.name not in lists]
        numbers = [name for name in lists if arrow.is_of(self._types[name].value_type, "number")]
        first = _first_rows(file, numbers)
        self._cells: list[tuple[str, int | None]] = [(name, None) for name in scalars]
        for name in numbers:
            length = next((len(one) for one in first.get(name, ()) if one), 0)
            if pa.types.is_fixed_size_list(self._types[name]) and name in first:
                length = self._types[name].list_size
            self._cells += [(name, element) for element in range(length)]
        self._widths = Counter(name for name, element in self._cells if element is not None)
        super().__init__(path, [name if element is None else f"{name}[{element}]" for name, element in self._cells])
        self.refuse_several_robots(_first_rows(file, [name for name in scalars if ROBOT_COLUMN.fullmatch(name)]))
        said = (name for name in lists if is_label(f"{name}[0]"))
        labels = [name for name in said if arrow.is_of(self._types[name].value_type, "text")]
        named = {name: list(map(str, next(filter(None, rows), []))) for name, rows in _first_rows(file, labels).items()}
        self._joints = {name: joints for name, joints in named.items() if joints}
        cells = {f"{name}[{i}]": joint for name, joints in self._joints.items() for i, joint in enumerate(joints)}
        self.labels = labels_of(self.names, cells)
        notes = {key.decode(errors="replace"): text for key, text in (file.schema_arrow.metadata or {}).items()}
        self._read_notes({key: text.decode(errors="replace") for key, text in notes.items()})

    def _read_notes(self, notes: dict[str, str]) -> None:
        """Take what this program's own writer puts into the key-value metadata."""
        self.serial = serial_in(notes)
        self.robot = notes["robot"] if notes.get("robot") in PRESETS else "unknown"
        try:
            self.start_s = float(notes["start_s"])
        except (KeyError, ValueError):
            self.start_s = None
        try:
            joints = json.loads(notes.get("joint_names", "[]"))
        except (ValueError, RecursionError):  # metadata of another program under the same key
            joints = []
        self.joint_names = joints if isinstance(joints, list) and all(isinstance(one, str) for one in joints) else ()

    def size(self, columns: ColumnMap) -> tuple[int, int]:
        if self.labels and columns.joint is None:
            self._refuse_moving_joints()
        return self._file.metadata.num_rows, self.path.stat().st_size

    def _refuse_moving_joints(self) -> None:
        start = 0
        for batch in self._file.iter_batches(batch_size=_BATCH_ROWS, columns=list(self._joints)):
            table = arrow.flat(batch)
            for name, joints in self._joints.items():
                array = table[name].combine_chunks()
                lengths = array.value_lengths().fill_null(-1).to_numpy(zero_copy_only=False)
                same = (lengths == len(joints)) | (lengths == 0)
                if same.all():
                    same[lengths > 0] = arrow.are_the_same(array.flatten(), joints)
                if not same.all():
                    row = int(np.flatnonzero(~same)[0])
                    raise InputError(
                        f"{self.path}: row {start + row + 1} of {name} holds {array[row].as_py()}; expected "
                        f"{joints} as in the first row; the order of the joints changes; sort every row by joint"
                    )
            start += len(batch)

    def read_clock(self, time: TimeColumn, stop: float = inf) -> Clock:
        """Read the stamps, NaN where they are damaged; integers as they are, which floats would round."""
        (number, unit), found, path = self._stamps(time), list[NDArray[Any]](), str(self.path)
        with suppress(InputError):  # all are read where some are damaged, and these are left out
            for piece in self._batches(time, time.cells) if stop < inf else ():
                found.append(stamps_of([piece[cell] for cell in time.cells]))
                clock = to_clock(found[-1].copy(), unit, path=path, origin=found[0][0].item())
                unit = clock.unit
                if clock.t[-1] > stop:
                    return to_clock(np.concatenate(found), unit, path=path)
        parts = [np.zeros(self._file.metadata.num_rows, number) for _ in time.cells]
        self._read_cells(zip(time.cells, parts, strict=True), None)
        return self._to_clock(parts, time)

    def read_rows(self, columns: ColumnMap, clock: Clock, rows: Bool | None) -> Part:
        channels = {c: np.empty((len(clock.t), len(cells)), order="F") for c, cells in columns.channels.items()}
        each = ((cell, channels[c][:, j]) for c, cells in columns.channels.items() for j, cell in enumerate(cells))
        self._read_cells(each, rows)
        joint = None if columns.joint is None else self._read_texts(self._cells[columns.joint][0], rows)
        return Part(clock=clock, channels=channels, joint=joint)

    def in_blocks(self, columns: ColumnMap) -> Part | None:
        pieces = partial(self._batches, columns.time)
        edges = np.cumsum([0, *self._sizes]).tolist()
        try:
            _, unit = self._stamps(columns.time)
            return part_in_blocks(columns, unit, edges[-1], pieces, str(self.path), edges)
        except InputError:  # damaged row groups are left out where all is read at once, or refused
            return None

    def _batches(self, time: TimeColumn, cells: Sequence[int], group: int = 0) -> Iterator[dict[int, NDArray[Any]]]:
        """Yield the numbers of some cells, one batch of rows after the other, from a row group on."""
        names, kind = list(dict.fromkeys(self._cells[cell][0] for cell in cells)), self._stamps(time)[0]
        size = max(_BATCH_BYTES - self._file.metadata.num_rows * len(cells) // _NUMBERS_PER_BYTE, _FEWEST_BYTES)
        groups, rows = range(group, len(self._sizes)), min(_BATCH_ROWS, size // (8 * len(cells)))
        try:
            with _open(self.path, self._file.metadata) as file:
                for batch in file.iter_batches(rows, groups, columns=names, use_threads=False):
                    table, found = arrow.flat(batch), dict[int, NDArray[Any]]()
                    values = {name: self._values(arrow.whole(table[name]), name, 0) for name in names}
                    for cell in cells:
                        name, place = self._cells[cell]
                        found[cell] = values[name] if place is None else values[name][:, place]
                        if cell in time.cells:
                            self._refuse_missing_stamps(name, found[cell], np.empty(0, kind))
                            found[cell] = found[cell].astype(kind)
                    yield found
        except (pa.ArrowException, OSError) as error:
            raise InputError(f"{self.path}: {error}; the file is damaged or has changed; read it again") from error

    def _stamps(self, time: TimeColumn) -> tuple[type, str | None]:
        """Return the type of number that stamps are read as, and their unit."""
        kind = self._types[self._cells[time.cells[0]][0]]
        has_unit = arrow.is_of(kind, "stamp")
        number = np.int64 if len(time.cells) > 1 or has_unit or pa.types.is_integer(kind) else np.float64
        return number, str(kind.unit) if has_unit else time.unit

    def _to_clock(self, parts: list[NDArray[Any]], time: TimeColumn) -> Clock:
        stamps = parts[0] if len(parts) == 1 else stamps_of(parts)
        names = {self._cells[cell][0] for cell in time.cells}
        edges, lost = np.cumsum([0, *self._sizes]), np.zeros(len(stamps), dtype=np.bool_)
        for name, group in self._damage:
            lost[edges[group] : edges[group + 1]] |= name in names
        if lost.any():
            if lost.all():
                damage = "; ".join(finding.message for finding in self.findings())
                raise InputError(f"{self.path}: a damaged Parquet file: {damage}; copy or record it again")
            stamps[lost] = stamps[~lost][0]
        clock = to_clock(stamps, self._stamps(time)[1], path=str(self.path))
        clock.t[lost] = np.nan
        return clock

    def findings(self) -> tuple[Finding, ...]:
        sizes, text = self._sizes, "{}: row group {} of {} is damaged and left out ({})"
        return tuple(
            Finding("damaged_numbers", text.format(name, n + 1, len(sizes), why), amount=float(sizes[n]), damaged=True)
            for (name, n), why in sorted(self._damage.items())
        )

    def _read_cells(self, wanted: Iterable[tuple[int, NDArray[Any]]], rows: Bool | None) -> None:
        """Read columns into arrays, column by column of the file, in threads."""
        targets: dict[str, list[tuple[int | None, NDArray[Any]]]] = defaultdict(list)
        for cell, target in wanted:
            name, element = self._cells[cell]
            targets[name].append((element, target))
        work = list(targets.items())
        per_joint(lambda number: self._read_column(*work[number], rows), len(work))

    def _read_column(self, column: str, targets: Sequence[tuple[int | None, NDArray[Any]]], rows: Bool | None) -> None:
        start, filled, samples = 0, 0, sum(self._sizes)
        asked = np.ones(samples, np.bool_) if rows is None else np.append(rows, np.zeros(samples - len(rows), np.bool_))
        with _open(self.path, self._file.metadata) as file:  # each thread has a file object of its own
            for group, size in enumerate(self._sizes):
                kept = asked[start : start + size]
                count = int(np.count_nonzero(kept))
                done, place = 0, filled
                try:
                    for batch in file.iter_batches(_BATCH_ROWS, [group], [column], use_threads=False) if count else ():
                        values = self._values(arrow.whole(arrow.flat(batch).column(0)), column, start + done)
                        own = values if rows is None else values[kept[done : done + len(values)]]
                        for element, target in targets:
                            self._refuse_missing_stamps(column, own, target)
                            target[place : place + len(own)] = own if element is None else own[:, element]
                        done, place = done + len(values), place + len(own)
                        if place == filled + count:  # no row of the rest is asked for
                            break
                except MemoryError:
                    raise
                except (pa.ArrowException, OSError) as error:
                    self._damage[column, group] = " ".join(str(error).split())
                    for _, target in targets:
                        target[filled : filled + count] = np.nan if target.dtype.kind == "f" else 0
                start, filled = start + size, filled + count

    def _values(self, array: pa.Array, column: str, start: int) -> NDArray[Any]:
        """Return the numbers of one column of a batch: (m,), or (m, width) for lists; NaN where there is none."""
        width = self._widths[column]
        if width == 0:
            kind = array.type
            if not (arrow.is_of(kind, "number") or arrow.is_of(kind, "stamp") or pa.types.is_boolean(kind)):
                raise InputError(f"{self.path}: {column} holds {array.type}; expected numbers; name another with --map")
            return arrow.integers_or_floats(array)
        lengths = array.value_lengths().fill_null(0).to_numpy(zero_copy_only=False)
        if not ((lengths == width) | (lengths == 0)).all():
            row = int(np.flatnonzero((lengths != width) & (lengths != 0))[0])
            raise InputError(
                f"{self.path}: row {start + row + 1} of {column} holds {lengths[row]} values; expected {width} as in "
                "the first row; name a column of constant length with --map"
            )
        values = np.full((len(array), width), np.nan)
        values[lengths == width] = arrow.integers_or_floats(array.flatten()).reshape(-1, width)
        return values

    def _refuse_missing_stamps(self, column: str, values: NDArray[Any], target: NDArray[Any]) -> None:
        """Refuse integer stamps with nulls among them: an integer has no value for a missing one."""
        if target.dtype.kind == "i" and values.dtype.kind == "f" and np.isnan(values).any():
            raise InputError(
                f"{self.path}: {column} lacks {np.count_nonzero(np.isnan(values))} stamps; expected one in every row; "
                "remove the rows without, or name another clock with --map t=<column>"
            )

    def _read_texts(self, column: str, rows: Bool | None) -> NDArray[Any]:
        found, start = [], 0
        for group, size in enumerate(self._sizes):
            own = np.ones(size, dtype=np.bool_) if rows is None else rows[start : start + size]
            if own.any():
                table = arrow.flat(self._file.read_row_group(group, columns=[column]))
                found.append(table[column].to_numpy()[own].astype(str).astype(object))
            start += size
        return np.concatenate(found)


def _first_rows(file: ParquetFile, columns: Sequence[str]) -> dict[str, list[Any]]:
    """Return the first rows of list columns; nothing of a file without rows."""
    first = next(file.iter_batches(batch_size=_LOOK_ROWS, columns=columns), None) if columns else None
    if first is None:
        return {}
    table = arrow.flat(first)
    return {name: table[name].to_pylist() for name in columns}


def topics(path: Path) -> tuple[Topic, ...]:
    """List the table of a Parquet file."""
    try:
        with _open(path) as file:
            rows, columns = file.metadata.num_rows, file.metadata.num_columns
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: a damaged or unfinished Parquet file: {error}; copy or record it again") from error
    return (Topic(name=path.name, type=f"table of {columns} columns", messages=rows, readable=True),)
