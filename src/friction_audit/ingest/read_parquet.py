"""Parquet -> Recording: scalar columns, or one list-valued column per channel."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.ingest.columns import ColumnMap, map_columns
from friction_audit.ingest.first_bytes import starts_with
from friction_audit.ingest.foreign_names import is_label, labels_of
from friction_audit.ingest.long_table import LongColumns, find_long_columns, pivot_long
from friction_audit.ingest.reader import Reader, ReadOptions, Recording, Topic
from friction_audit.ingest.stated_serial import serial_in
from friction_audit.ingest.time_column import TimeColumn, to_clock
from friction_audit.ingest.to_recording import name_joints, stated_arm, to_recording
from friction_audit.joint_log import Float
from friction_audit.per_joint import per_joint

_MAGIC = b"PAR1"
_BATCH_ROWS = 1 << 16


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
                return _read_long(file, path, cells, long, arm)
            told = _joints_of_first_row(file)
            labels = labels_of(names, {f"{column}[{i}]": j for column, row in told.items() for i, j in enumerate(row)})
            columns = map_columns(names, path=str(path), mapping=options.mapping, labels=labels, arm=arm)
            if labels:
                _refuse_moving_joints(file, path, told)
            return _read_wide(file, path, cells, columns, is_named=bool(labels))
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: a damaged or unfinished Parquet file: {error}; its index is at its end, so nothing can be "
            "salvaged; copy or record it again"
        ) from error


def _open(path: Path, metadata: Any = None) -> Any:  # noqa: ANN401
    import pyarrow.parquet as pq

    return pq.ParquetFile(path, metadata=metadata)


def _joints_of_first_row(file: Any) -> dict[str, list[str]]:  # noqa: ANN401
    """Return list-valued column of joint names -> the names in its first row, as a JointState has them."""
    columns = [column for column in _leaves(file.schema_arrow, "", _is_text)[1] if is_label(f"{column}[0]")]
    first = next(file.iter_batches(batch_size=1, columns=columns), None) if columns else None
    if first is None or len(first) == 0:
        return {}
    rows = {column: _child(first, column)[0].as_py() or [] for column in columns}
    return {column: [str(joint) for joint in row] for column, row in rows.items() if row}


def _refuse_moving_joints(file: Any, path: Path, told: Mapping[str, Sequence[str]]) -> None:  # noqa: ANN401
    """Refuse a table in which the joints change their places."""
    start = 0
    for batch in file.iter_batches(batch_size=_BATCH_ROWS, columns=list(told)):
        for column, joints in told.items():
            array = _child(batch, column)
            same = array.value_lengths().fill_null(0).to_numpy(zero_copy_only=False) == len(joints)
            if same.all():
                same = _are_the_same(array.flatten(), joints)
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
    *,
    is_named: bool,
) -> Recording:
    rows = file.metadata.num_rows
    if rows == 0:
        raise InputError(f"{path}: 0 samples; the table has columns and no rows; record the arm while it moves")
    channels: dict[str, Float] = {c: np.empty((rows, len(own)), order="F") for c, own in columns.channels.items()}
    aims = [
        (cells[cell], channels[c][:, joint]) for c, own in columns.channels.items() for joint, cell in enumerate(own)
    ]
    time = _read_numbers(file, path, cells, columns.time, aims)
    unit = _stamp_unit(file, cells[columns.time.cells[0]]) or columns.time.unit
    recording = to_recording(columns, to_clock(time, unit, path=str(path)), channels)
    metadata = file.schema_arrow.metadata or {}
    notes = _as_text(metadata)
    recording = replace(recording, serial=serial_in(notes), start_s=_start_of(recording, notes))
    return recording if is_named else name_joints(recording, *_stated_joints(metadata))


def _start_of(recording: Recording, notes: Mapping[str, str]) -> float | None:
    """Return the Unix time of t = 0: that of the clock, else of the first sample as our own writer notes it. [s]"""
    try:
        stated = float(notes["start_s"]) - float(recording.t[0])
    except (KeyError, ValueError):
        return recording.start_s
    return stated if recording.start_s is None and isfinite(stated) else recording.start_s


def _as_text(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    return {key.decode(errors="replace"): value.decode(errors="replace") for key, value in metadata.items()}


def _stated_joints(metadata: Mapping[bytes, bytes]) -> tuple[list[str], str]:
    """Return the joints' names and the robot from the file's key-value metadata, where our own writer puts them."""
    try:
        names = json.loads(metadata.get(b"joint_names", b"[]"))
    except ValueError:  # somebody else's metadata under the same key: the columns name the joints
        names = []
    robot = metadata.get(b"robot", b"").decode(errors="replace")
    is_list = isinstance(names, list) and all(isinstance(name, str) for name in names)
    return names if is_list else [], robot if robot in ("panda", "fr3") else "unknown"


def _read_numbers(
    file: Any,  # noqa: ANN401
    path: Path,
    cells: Sequence[Cell],
    clock: TimeColumn,
    aims: Sequence[tuple[Cell, Float]],
) -> NDArray[Any]:
    """Read cells into their arrays; returns the stamps, as they stand in the file."""
    time: NDArray[Any] = np.empty(file.metadata.num_rows, dtype=_time_type(file, cells, clock))
    parts = [time] if len(clock.cells) == 1 else [time[:, part] for part in range(len(clock.cells))]
    stamps = [(cells[cell], part) for cell, part in zip(clock.cells, parts, strict=True)]
    wanted = _targets(cells, [*aims, *stamps])
    wishes = [(*wish, targets) for wish, targets in wanted.items()]
    # Column by column: as fast as all at once, and only one row group of one column per thread is in memory beside
    # the arrays that are kept; columns are shared out as joints are.
    per_joint(lambda number: _read_column(file.metadata, path, *wishes[number]), len(wishes))
    return time if len(clock.cells) == 1 else time[:, 0] * 1_000_000_000 + time[:, 1]


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


def _read_long(file: Any, path: Path, cells: Sequence[Cell], long: LongColumns, arm: str) -> Recording:  # noqa: ANN401
    """Read a table with one row per joint and time."""
    values = {channel: np.empty(file.metadata.num_rows) for channel in long.channels}
    time = _read_numbers(file, path, cells, long.time, [(cells[own], values[c]) for c, own in long.channels.items()])
    column = cells[long.joint].column
    joint = file.read(columns=[column])[column].to_numpy().astype(str).astype(object)
    unit = _stamp_unit(file, cells[long.time.cells[0]])
    return pivot_long(long, joint, time, values, path=str(path), arm=arm, unit=unit)


def _read_column(
    metadata: Any,  # noqa: ANN401
    path: Path,
    column: str,
    width: int,
    targets: Sequence[tuple[int | None, NDArray[Any]]],
) -> None:
    """Read one column of the file into its arrays; each thread has a file object of its own."""
    start = 0
    with _open(path, metadata) as file:
        for group in range(metadata.num_row_groups):
            table = file.read_row_group(group, columns=[column], use_threads=False)
            for batch in table.to_batches(max_chunksize=_BATCH_ROWS):
                values = _values(batch, column, width, path, start)
                for element, target in targets:
                    _refuse_missing_stamps(path, column, values, target)
                    target[start : start + len(values)] = values if element is None else values[:, element]
                start += len(values)


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
    lengths = array.value_lengths().fill_null(width).to_numpy(zero_copy_only=False)
    if (lengths != width).any():
        row = int(np.flatnonzero(lengths != width)[0])
        raise InputError(
            f"{path}: row {start + row + 1} of {column} holds {lengths[row]} values; expected {width} as in "
            "the first row; name a column of constant length with --map"
        )
    values = np.full((len(array), width), np.nan)
    values[array.is_valid().to_numpy(zero_copy_only=False)] = _integers_or_floats(array.flatten()).reshape(-1, width)
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
    """Return everything in the file that is one number per row; the length of lists is read from the first row."""
    import pyarrow as pa

    scalars, lists = _leaves(file.schema_arrow, "", _is_number)
    if not lists:
        return [Cell(column, None) for column in scalars]
    first = next(file.iter_batches(batch_size=1, columns=lists), None)
    cells = [Cell(column, None) for column in scalars]
    for column in lists:
        array = None if first is None else _child(first, column)
        length = 0 if array is None or len(array) == 0 else array.value_lengths()[0].as_py()
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
