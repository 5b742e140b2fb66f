"""Parquet -> Recording: scalar columns, or one list-valued column per channel."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import is_label, labels_of, serial_in
from friction_audit.io.readers.columns import ColumnMap, map_columns
from friction_audit.io.readers.long_table import LongColumns, find_long_columns, pivot_long
from friction_audit.io.readers.reader import Reader, ReadOptions, Recording, Topic, address_limit, refuse_too_large
from friction_audit.io.readers.time_column import Clock, TimeColumn, take_part, to_clock
from friction_audit.io.readers.to_recording import name_joints, stated_arm, to_recording
from friction_audit.io.readers.unpack import starts_with
from friction_audit.joint_log import Finding, Float
from friction_audit.parallel import per_joint

_MAGIC = b"PAR1"
_BATCH_ROWS = 1 << 16
_LOOK_ROWS = 1000
"""Rows among which the first list that is not empty is looked for: the first messages of a topic may be empty."""

if address_limit() < inf:  # before Arrow is loaded
    # Its own allocator asks for a gigabyte of addresses at once, which the limit counts as if they were used.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")


@dataclass(frozen=True, slots=True)
class Cell:
    """One number per row: a scalar column, or one element of a list-valued column.

    Attributes:
        column: Dotted path of the column in the file.
        element: Place in the list, or None for a scalar.
    """

    column: str
    element: int | None

    @property
    def name(self) -> str:
        """The name under which the cell is looked for."""
        return self.column if self.element is None else f"{self.column}[{self.element}]"


def read_parquet(path: Path, options: ReadOptions) -> Recording:
    """Read a Parquet file.

    Raises:
        InputError: If columns are missing, or the file is damaged.
    """
    import pyarrow as pa

    arm = stated_arm(path, options)
    try:
        with _open(path) as file:
            cells = _cells(file)
            names = [cell.name for cell in cells]
            long = find_long_columns(names, path=str(path), mapping=options.mapping)
            if long is not None:
                return _read_long(file, path, cells, long, arm, options)
            told = _joints_of_first_row(file)
            labels = labels_of(names, {f"{column}[{i}]": j for column, row in told.items() for i, j in enumerate(row)})
            columns = map_columns(names, path=str(path), mapping=options.mapping, labels=labels, arm=arm)
            if labels:
                _refuse_moving_joints(file, path, told)
            return _read_wide(file, path, cells, columns, options, is_named=bool(labels))
    except MemoryError:  # Arrow's own is an ArrowException too
        raise
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: a damaged or unfinished Parquet file: {error}; its index is at its end, so nothing can be "
            "salvaged; copy or record it again"
        ) from error


def _open(path: Path, metadata: Any = None) -> Any:  # noqa: ANN401
    import pyarrow.parquet as pq

    return pq.ParquetFile(path, metadata=metadata, page_checksum_verification=True)


def _joints_of_first_row(file: Any) -> dict[str, list[str]]:  # noqa: ANN401
    """Return list-valued column of joint names -> the names in its first row, as a JointState has them."""
    columns = [column for column in _leaves(file.schema_arrow, "", _is_text)[1] if is_label(f"{column}[0]")]
    first = next(file.iter_batches(batch_size=_LOOK_ROWS, columns=columns), None) if columns else None
    if first is None:
        return {}
    rows: dict[str, list[object]] = {c: next(filter(None, _child(first, c).to_pylist()), []) for c in columns}
    return {column: [str(joint) for joint in row] for column, row in rows.items() if row}


def _refuse_moving_joints(file: Any, path: Path, told: Mapping[str, Sequence[str]]) -> None:  # noqa: ANN401
    """Refuse a table in which the joints change their places."""
    start = 0
    for batch in file.iter_batches(batch_size=_BATCH_ROWS, columns=list(told)):
        for column, joints in told.items():
            array = _child(batch, column)
            lengths = array.value_lengths().fill_null(-1).to_numpy(zero_copy_only=False)
            same = (lengths == len(joints)) | (lengths == 0)
            if same.all():
                same[lengths > 0] = _are_the_same(array.flatten(), joints)
            if not same.all():
                row = int(np.flatnonzero(~same)[0])
                raise InputError(
                    f"{path}: row {start + row + 1} of {column} holds {array[row].as_py()}; expected {list(joints)} "
                    "as in the first row; the order of the joints changes; sort every row by joint"
                )
        start += len(batch)


def _are_the_same(texts: Any, joints: Sequence[str]) -> NDArray[np.bool_]:  # noqa: ANN401
    """Return for each row of joint names, given one after the other, whether they are these."""
    import pyarrow as pa

    coded = (texts.dictionary_decode() if pa.types.is_dictionary(texts.type) else texts).dictionary_encode()
    codes = {text: code for code, text in enumerate(coded.dictionary.to_pylist())}
    expected = [codes.get(joint, -1) for joint in joints]
    rows = coded.indices.to_numpy(zero_copy_only=False).reshape(-1, len(joints))
    same: NDArray[np.bool_] = (rows == expected).all(axis=1)
    return same


def _read_wide(
    file: Any,  # noqa: ANN401
    path: Path,
    cells: Sequence[Cell],
    columns: ColumnMap,
    options: ReadOptions,
    *,
    is_named: bool,
) -> Recording:
    if file.metadata.num_rows == 0:
        raise InputError(f"{path}: 0 samples; the table has columns and no rows; record the arm while it moves")
    unit = _stamp_unit(file, cells[columns.time.cells[0]]) or columns.time.unit
    numbers = _Numbers(file, path, cells, columns.time, unit)
    channels, clock, _, first_s = numbers.read(columns.channels, options)
    recording = to_recording(columns, clock, channels, findings=numbers.findings())
    metadata = file.schema_arrow.metadata or {}
    notes = _as_text(metadata)
    start_s = _start_of(recording, notes, first_s)
    recording = replace(recording, serial=serial_in(notes), start_s=start_s, first_s=first_s)
    return recording if is_named else name_joints(recording, *_stated_joints(metadata))


def _start_of(recording: Recording, notes: Mapping[str, str], first_s: float | None) -> float | None:
    """Return the Unix time of t = 0: that of the clock, else of the first sample as our own writer notes it. [s]"""
    try:
        stated = float(notes["start_s"]) - (float(recording.t[0]) if first_s is None else first_s)
    except (KeyError, ValueError):
        return recording.start_s
    return stated if recording.start_s is None and isfinite(stated) else recording.start_s


def _as_text(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    return {key.decode(errors="replace"): value.decode(errors="replace") for key, value in metadata.items()}


def _stated_joints(metadata: Mapping[bytes, bytes]) -> tuple[list[str], str]:
    """Return the joints' names and the robot from the file's key-value metadata, where our own writer puts them."""
    try:
        names = json.loads(metadata.get(b"joint_names", b"[]"))
    except (ValueError, RecursionError):  # somebody else's metadata under the same key: the columns name the joints
        names = []
    robot = metadata.get(b"robot", b"").decode(errors="replace")
    is_list = isinstance(names, list) and all(isinstance(name, str) for name in names)
    return names if is_list else [], robot if robot in ("panda", "fr3") else "unknown"


class _Numbers:
    """The numbers of a file: what is read of them, and what is damaged.

    Column by column: as fast as all at once, and only one row group of one column per thread is in memory beside the
    arrays that are kept; columns are shared out as joints are.
    """

    def __init__(self, file: Any, path: Path, cells: Sequence[Cell], time: TimeColumn, unit: str | None) -> None:  # noqa: ANN401
        self._file, self._path, self._cells, self._time, self._unit = file, path, cells, time, unit
        self._damage: dict[tuple[str, int], str] = {}

    def read(
        self, channels: Mapping[str, Sequence[int]], options: ReadOptions
    ) -> tuple[dict[str, Float], Clock, NDArray[np.bool_] | None, float | None]:
        """Return the arrays of channels, given by cells, and their clock.

        Of a large log only the part asked for is read; then the mask of its rows and the first stamp of all follow.
        """
        rows, packed = self._file.metadata.num_rows, self._path.stat().st_size
        width = sum(map(len, channels.values()))
        if not options.reads_part(8 * rows * (width + 1)):
            refuse_too_large(self._path, 8 * rows * (width + 1), packed)
            time, aims = self._stamps(rows)
            arrays = self._read_channels(channels, rows, aims, None)
            return arrays, self._to_clock(time), None, None
        refuse_too_large(self._path, 8 * rows, packed)
        time, aims = self._stamps(rows)
        self._read_columns(aims, None)
        clock, kept, first_s = take_part(self._to_clock(time), options, path=str(self._path))
        refuse_too_large(self._path, 8 * len(clock.t) * (width + 1), packed)
        return self._read_channels(channels, len(clock.t), [], kept), clock, kept, first_s

    def _read_channels(
        self,
        channels: Mapping[str, Sequence[int]],
        count: int,
        aims: Sequence[tuple[Cell, NDArray[Any]]],
        rows: NDArray[np.bool_] | None,
    ) -> dict[str, Float]:
        """Read channels, and whatever else is aimed at, in some rows."""
        arrays: dict[str, Float] = {c: np.empty((count, len(own)), order="F") for c, own in channels.items()}
        own = [(self._cells[cell], arrays[c][:, j]) for c, cells in channels.items() for j, cell in enumerate(cells)]
        self._read_columns([*aims, *own], rows)
        return arrays

    def read_texts(self, column: str, rows: NDArray[np.bool_] | None) -> NDArray[Any]:
        """Return the texts of a column in some rows."""
        found, start = [], 0
        for group in range(self._file.metadata.num_row_groups):
            size = self._file.metadata.row_group(group).num_rows
            own = np.ones(size, dtype=np.bool_) if rows is None else rows[start : start + size]
            if own.any():
                table = self._file.read_row_group(group, columns=[column])
                found.append(table[column].to_numpy()[own].astype(str).astype(object))
            start += size
        return np.concatenate(found)

    def findings(self) -> tuple[Finding, ...]:
        """Return what is damaged; its numbers are missing values."""
        return tuple(
            Finding(
                code="damaged_numbers",
                message=f"{column}: row group {group + 1} of {self._file.metadata.num_row_groups} is damaged and left "
                f"out ({error})",
                amount=float(self._file.metadata.row_group(group).num_rows),
                damaged=True,
            )
            for (column, group), error in sorted(self._damage.items())
        )

    def _stamps(self, rows: int) -> tuple[NDArray[Any], list[tuple[Cell, NDArray[Any]]]]:
        """Return the array of the stamps, as they stand in the file, and what is to be read into it."""
        own = self._time.cells
        time: NDArray[Any] = np.zeros(rows, dtype=_time_type(self._file, self._cells, self._time))
        parts = [time] if len(own) == 1 else [time[:, part] for part in range(len(own))]
        return time, [(self._cells[cell], part) for cell, part in zip(own, parts, strict=True)]

    def _to_clock(self, time: NDArray[Any]) -> Clock:
        """Return the clock, NaN where the stamps are damaged."""
        stamps = time if time.ndim == 1 else time[:, 0] * 1_000_000_000 + time[:, 1]
        names = {self._cells[cell].column for cell in self._time.cells}
        lost = np.zeros(len(time) if any(name in names for name, _ in self._damage) else 0, dtype=np.bool_)
        for name, group in self._damage:
            start = sum(self._file.metadata.row_group(before).num_rows for before in range(group))
            if name in names:
                lost[start : start + self._file.metadata.row_group(group).num_rows] = True
        if lost.any():
            if lost.all():
                damage = "; ".join(finding.message for finding in self.findings())
                raise InputError(f"{self._path}: a damaged Parquet file: {damage}; copy or record it again")
            stamps[lost] = stamps[~lost][0]
        clock = to_clock(stamps, self._unit, path=str(self._path))
        if lost.any():
            clock.t[lost] = np.nan
        return clock

    def _read_columns(self, aims: Sequence[tuple[Cell, NDArray[Any]]], rows: NDArray[np.bool_] | None = None) -> None:
        wishes = [(*wish, targets) for wish, targets in _targets(self._cells, aims).items()]
        per_joint(lambda number: self._read_column(*wishes[number], rows), len(wishes))

    def _read_column(
        self,
        column: str,
        width: int,
        targets: Sequence[tuple[int | None, NDArray[Any]]],
        rows: NDArray[np.bool_] | None,
    ) -> None:
        """Read one column of the file into its arrays; each thread has a file object of its own."""
        import pyarrow as pa

        start = filled = 0
        with _open(self._path, self._file.metadata) as file:
            for group in range(file.metadata.num_row_groups):
                size = file.metadata.row_group(group).num_rows
                kept = None if rows is None else rows[start : start + size]
                count = size if kept is None else int(np.count_nonzero(kept))
                try:
                    table = file.read_row_group(group, columns=[column], use_threads=False) if count else None
                except MemoryError:
                    raise
                except (pa.ArrowException, OSError) as error:
                    self._damage[column, group] = " ".join(str(error).split())
                    for _, target in targets:
                        target[filled : filled + count] = np.nan if target.dtype.kind == "f" else 0
                else:
                    if table is not None:
                        self._fill(table, column, width, targets, start, filled, kept)
                start, filled = start + size, filled + count

    def _fill(
        self,
        table: Any,  # noqa: ANN401
        column: str,
        width: int,
        targets: Sequence[tuple[int | None, NDArray[Any]]],
        start: int,
        filled: int,
        kept: NDArray[np.bool_] | None,
    ) -> None:
        done = 0
        for batch in table.to_batches(max_chunksize=_BATCH_ROWS):
            values = _values(batch, column, width, self._path, start + done)
            own = values if kept is None else values[kept[done : done + len(values)]]
            for element, target in targets:
                _refuse_missing_stamps(self._path, column, own, target)
                target[filled : filled + len(own)] = own if element is None else own[:, element]
            done, filled = done + len(values), filled + len(own)


def _targets(
    cells: Sequence[Cell], aims: Sequence[tuple[Cell, NDArray[Any]]]
) -> dict[tuple[str, int], list[tuple[int | None, NDArray[Any]]]]:
    """Return column of the file and its width -> the arrays that its elements go to."""
    widths: dict[str, int] = {}
    for cell in cells:
        widths[cell.column] = widths.get(cell.column, 0) + (cell.element is not None)
    wanted: dict[tuple[str, int], list[tuple[int | None, NDArray[Any]]]] = {}
    for cell, target in aims:
        wanted.setdefault((cell.column, widths[cell.column]), []).append((cell.element, target))
    return wanted


def _read_long(
    file: Any,  # noqa: ANN401
    path: Path,
    cells: Sequence[Cell],
    long: LongColumns,
    arm: str,
    options: ReadOptions,
) -> Recording:
    """Read a table with one row per joint and time."""
    unit = _stamp_unit(file, cells[long.time.cells[0]])
    numbers = _Numbers(file, path, cells, long.time, unit or long.time.unit)
    own = {channel: (cell,) for channel, cell in long.channels.items()}
    channels, clock, rows, first_s = numbers.read(own, options)
    values = {channel: array[:, 0] for channel, array in channels.items()}
    joint = numbers.read_texts(cells[long.joint].column, rows)
    recording = pivot_long(long, joint, clock, values, path=str(path), arm=arm, findings=numbers.findings())
    return replace(recording, first_s=first_s)


def _refuse_missing_stamps(path: Path, column: str, values: NDArray[Any], target: NDArray[Any]) -> None:
    """Refuse integer stamps with nulls among them, which no integer stands for."""
    if target.dtype.kind == "i" and values.dtype.kind == "f" and np.isnan(values).any():
        raise InputError(
            f"{path}: {column} lacks {np.count_nonzero(np.isnan(values))} stamps; expected one in every row; "
            "remove the rows without, or name another clock with --map t=<column>"
        )


def _values(batch: Any, column: str, width: int, path: Path, start: int) -> NDArray[Any]:  # noqa: ANN401
    """Return the numbers of one column of a batch: (m,), or (m, width) for lists; NaN where nothing is."""
    array = _child(batch, column)
    if width == 0:
        if not _is_number_or_stamp(array.type):
            raise InputError(f"{path}: {column} holds {array.type}; expected numbers; name another column with --map")
        return _integers_or_floats(array)
    lengths = array.value_lengths().fill_null(0).to_numpy(zero_copy_only=False)
    if not ((lengths == width) | (lengths == 0)).all():
        row = int(np.flatnonzero((lengths != width) & (lengths != 0))[0])
        raise InputError(
            f"{path}: row {start + row + 1} of {column} holds {lengths[row]} values; expected {width} as in "
            "the first row; name a column of constant length with --map"
        )
    values = np.full((len(array), width), np.nan)
    values[lengths == width] = _integers_or_floats(array.flatten()).reshape(-1, width)
    return values


def _child(batch: Any, column: str) -> Any:  # noqa: ANN401
    """Return a column by its dotted path."""
    names = batch.schema.names
    if column in names:
        return batch.column(names.index(column))
    head, _, rest = column.partition(".")
    array = batch.column(names.index(head))
    for part in rest.split("."):
        array = array.field(part)
    return array


def _integers_or_floats(array: Any) -> NDArray[Any]:  # noqa: ANN401
    """Return Arrow numbers as NumPy: stamps as int64, everything else as it is, NaN for null."""
    import pyarrow as pa

    if pa.types.is_timestamp(array.type) or pa.types.is_duration(array.type):
        array = array.cast(pa.int64())
    if pa.types.is_decimal(array.type) or pa.types.is_boolean(array.type):
        array = array.cast(pa.float64())
    # Arrow's own conversion loads pandas, half a second, of which only nulls have need.
    numbers: NDArray[Any] = array.to_numpy(zero_copy_only=False) if array.null_count else np.from_dlpack(array)
    return numbers


def _cells(file: Any) -> list[Cell]:  # noqa: ANN401
    """Return everything in the file that is one number per row; lists are as long as the first that is not empty."""
    import pyarrow as pa

    scalars, lists = _leaves(file.schema_arrow, "", _is_number)
    if not lists:
        return [Cell(column, None) for column in scalars]
    first = next(file.iter_batches(batch_size=_LOOK_ROWS, columns=lists), None)
    cells = [Cell(column, None) for column in scalars]
    for column in lists:
        array = None if first is None else _child(first, column)
        lengths = () if array is None else array.value_lengths().fill_null(0).to_numpy(zero_copy_only=False)
        length = next((int(one) for one in lengths if one), 0)
        if array is not None and pa.types.is_fixed_size_list(array.type):
            length = array.type.list_size
        cells += [Cell(column, element) for element in range(length or 0)]
    return cells


def _leaves(fields: Any, prefix: str, is_wanted: Callable[[Any], bool]) -> tuple[list[str], list[str]]:  # noqa: ANN401
    """Return the dotted paths of the scalar columns, and of those that hold lists of what is wanted."""
    import pyarrow as pa

    scalars: list[str] = []
    lists: list[str] = []
    for field in fields:
        kind = field.type
        if pa.types.is_struct(kind):
            inner = _leaves([kind.field(i) for i in range(kind.num_fields)], f"{prefix}{field.name}.", is_wanted)
            scalars, lists = scalars + inner[0], lists + inner[1]
        elif pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind):
            lists += [f"{prefix}{field.name}"] if is_wanted(kind.value_type) else []
        else:
            scalars.append(f"{prefix}{field.name}")
    return scalars, lists


def _is_number(kind: Any) -> bool:  # noqa: ANN401
    import pyarrow as pa

    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind))


def _is_text(kind: Any) -> bool:  # noqa: ANN401
    import pyarrow as pa

    inner = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_string(inner) or pa.types.is_large_string(inner) or pa.types.is_string_view(inner))


def _is_number_or_stamp(kind: Any) -> bool:  # noqa: ANN401
    import pyarrow as pa

    stamp = pa.types.is_timestamp(kind) or pa.types.is_duration(kind) or pa.types.is_boolean(kind)
    return stamp or _is_number(kind)


def _field_type(file: Any, cell: Cell) -> Any:  # noqa: ANN401
    head, *rest = cell.column.split(".") if cell.column not in file.schema_arrow.names else [cell.column]
    kind = file.schema_arrow.field(head).type
    for part in rest:
        kind = kind.field(part).type
    return kind


def _time_type(file: Any, cells: Sequence[Cell], clock: TimeColumn) -> Any:  # noqa: ANN401
    """Return int64 for integer stamps, which a float would round, and float64 otherwise."""
    import pyarrow as pa

    kinds = [_field_type(file, cells[cell]) for cell in clock.cells]
    exact = all(pa.types.is_integer(k) or pa.types.is_timestamp(k) or pa.types.is_duration(k) for k in kinds)
    return np.dtype((np.int64, (len(kinds),))) if len(kinds) > 1 else np.dtype(np.int64 if exact else np.float64)


def _stamp_unit(file: Any, cell: Cell) -> str | None:  # noqa: ANN401
    import pyarrow as pa

    kind = _field_type(file, cell)
    return str(kind.unit) if pa.types.is_timestamp(kind) or pa.types.is_duration(kind) else None


def _recognises(path: Path) -> bool:
    return starts_with(path, _MAGIC)


def _tables(path: Path) -> tuple[Topic, ...]:
    import pyarrow as pa

    try:
        with _open(path) as file:
            rows, columns = file.metadata.num_rows, file.metadata.num_columns
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: a damaged or unfinished Parquet file: {error}; copy or record it again") from error
    return (Topic(name=path.name, type=f"table of {columns} columns", messages=rows, readable=True),)


PARQUET = Reader(
    name="parquet",
    suffixes=(".parquet", ".pq"),
    recognises=_recognises,
    read=read_parquet,
    topics=_tables,
    summary="Parquet: one column per joint and channel, or one list-valued column per channel",
)
