"""Parquet -> Recording: scalar columns, or one list-valued column per channel."""

import json
from bisect import bisect
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow.parquet import FileMetaData, ParquetFile

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import is_label, labels_of
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.reader import ReadOptions, Topic, serial_in
from friction_audit.io.readers.table import ROBOT_COLUMN, Cells, ColumnTable, Piece, Pieces, Rows, read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding
from friction_audit.presets import PRESETS

# Of a batch, of which about ten are in memory; of fewer rows, calls take the time. What is kept of the cycles of a log
# grows by ten bytes in so many numbers, and the batches of a long one leave it room.
_BATCH_ROWS, _BATCH_BYTES, _FEWEST_BYTES, _NUMBERS_PER_BYTE = 1 << 16, 9 << 20, 4 << 20, 450
_BUFFER_BYTES = 1 << 17
_LOOK_ROWS = 1000  # the first list that is not empty is among them: the first messages of a topic may be empty
KINDS = {
    "stamp": (pa.types.is_timestamp, pa.types.is_duration),  # whose type names the unit
    "list": (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list),
    "number": (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal),
    "text": (pa.types.is_string, pa.types.is_large_string, pa.types.is_string_view),
}


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a Parquet file."""
    with opened(path) as file:
        return read_table(ParquetTable(path, file), options)


@contextmanager
def opened(path: Path) -> Iterator[ParquetFile]:
    """Open a Parquet file; InputError if it is damaged, or what is read of it meanwhile."""
    try:
        with _open(path) as file:
            yield file
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

    Column by column is as fast as all at once, and only a batch of one column per thread is in memory next to the
    arrays that are kept. A row group of a column is left out from where it is damaged.
    """

    def __init__(self, path: Path, file: ParquetFile) -> None:
        """Name the numbers of a row: scalars, and the elements of lists as long as the first that is not empty."""
        fields = _flat(pa.Table.from_batches([], file.schema_arrow)).schema
        self._file, self._damage = file, dict[tuple[str, int], tuple[int, str]]()
        self._types = {field.name: field.type for field in fields}
        self._sizes = [file.metadata.row_group(group).num_rows for group in range(file.metadata.num_row_groups)]
        self.groups = np.cumsum([0, *self._sizes]).tolist()
        lists = [field.name for field in fields if is_of(field.type, "list")]
        scalars = [field.name for field in fields if field.name not in lists]
        numbers = [name for name in lists if is_of(self._types[name].value_type, "number")]
        first = _first_rows(file, numbers)
        self.arrays = [(name, 0) for name in scalars]
        for name in numbers:
            length = next((len(one) for one in first.get(name, ()) if one), 0)
            if pa.types.is_fixed_size_list(self._types[name]) and name in first:
                length = self._types[name].list_size
            self.arrays += [(name, element) for element in range(length)]
        self._widths = Counter(name for name, _ in self.arrays[len(scalars) :])
        super().__init__(path, [f"{name}[{at}]" if self._widths[name] else name for name, at in self.arrays])
        self.refuse_several_robots(_first_rows(file, [name for name in scalars if ROBOT_COLUMN.fullmatch(name)]))
        said = (name for name in lists if is_label(f"{name}[0]"))
        labels = [name for name in said if is_of(self._types[name].value_type, "text")]
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

    def size(self, columns: ColumnMap) -> tuple[int, int, str | None]:
        if self.labels and columns.joint is None:
            self._refuse_moving_joints()
        kind = self._types[self.arrays[columns.time.cells[0]][0]]
        unit = str(kind.unit) if is_of(kind, "stamp") else columns.time.unit
        return self._file.metadata.num_rows, self.path.stat().st_size, unit

    def _refuse_moving_joints(self) -> None:
        start = 0
        for batch in self._file.iter_batches(batch_size=_BATCH_ROWS, columns=list(self._joints)):
            table = _flat(batch)
            for name, joints in self._joints.items():
                array = table[name].combine_chunks()
                lengths = array.value_lengths().fill_null(-1).to_numpy(zero_copy_only=False)
                same = (lengths == len(joints)) | (lengths == 0)
                if same.all():
                    texts = array.flatten()
                    is_coded = pa.types.is_dictionary(texts.type)
                    coded = (texts.dictionary_decode() if is_coded else texts).dictionary_encode()
                    codes = {text: code for code, text in enumerate(coded.dictionary.to_pylist())}
                    rows = coded.indices.to_numpy(zero_copy_only=False).reshape(-1, len(joints))
                    same[lengths > 0] = (rows == [codes.get(joint, -1) for joint in joints]).all(axis=1)
                if not same.all():
                    row = int(np.flatnonzero(~same)[0])
                    raise InputError(
                        f"{self.path}: row {start + row + 1} of {name} holds {array[row].as_py()}; expected "
                        f"{joints} as in the first row; the order of the joints changes; sort every row by joint"
                    )
            start += len(batch)

    def in_blocks(self, columns: ColumnMap) -> tuple[int, Pieces]:
        def pieces(cells: Sequence[int], group: int = 0) -> Iterator[Cells]:
            names = list(dict.fromkeys(self.arrays[cell][0] for cell in cells))
            size = max(_BATCH_BYTES - self._file.metadata.num_rows * len(cells) // _NUMBERS_PER_BYTE, _FEWEST_BYTES)
            groups, rows = range(group, len(self._sizes)), min(_BATCH_ROWS, size // (8 * len(cells)))
            try:
                with _open(self.path, self._file.metadata) as file:
                    for batch in file.iter_batches(rows, groups, columns=names, use_threads=False):
                        table = _flat(batch)
                        arrays = {name: self._array(table, name, columns, 0) for name in names}
                        yield {cell: arrays[self.arrays[cell][0]][:, self.arrays[cell][1]] for cell in cells}
            except (pa.ArrowException, OSError) as error:
                raise InputError(f"{self.path}: {error}; the file is damaged or has changed; read it again") from error

        return self.groups[-1], pieces

    def pieces(self, columns: ColumnMap, name: str, rows: Rows) -> Iterator[Piece]:
        first = bisect(self.groups, rows[0]) - 1
        with _open(self.path, self._file.metadata) as file:  # each thread has a file object of its own
            for group, size in enumerate(self._sizes[first:], first):
                done = 0
                try:
                    for batch in file.iter_batches(_BATCH_ROWS, [group], [name], use_threads=False):
                        if self.groups[group] + done >= rows[1]:
                            return
                        yield 0, self._array(_flat(batch), name, columns, self.groups[group] + done)
                        done += len(batch)
                except MemoryError:  # Arrow's own is an ArrowException too
                    raise
                except (pa.ArrowException, OSError) as error:
                    self._damage[name, group] = size - done, " ".join(str(error).split())
                    stamps = {self.arrays[cell][0] for cell in columns.time.cells}
                    if {*range(len(self._sizes))} <= {number for name, number in self._damage if name in stamps}:
                        damage = "; ".join(finding.message for finding in self.findings())
                        what = f"a damaged Parquet file: {damage}; copy or record it again"
                        raise InputError(f"{self.path}: {what}") from error
                    yield 0, np.full((size - done, max(self._widths[name], 1)), np.nan)

    def _array(self, table: pa.Table, name: str, columns: ColumnMap, start: int) -> NDArray[Any]:
        """Return an array of a batch that begins at a row, (m, k)."""
        if columns.joint is not None and name == self.arrays[columns.joint][0]:
            return np.asarray(table[name].to_numpy().astype(str), object)[:, None]
        values = self._values(table[name].chunk(0), name, start)
        kind, time = self._types[name], columns.time
        is_integer = len(time.cells) > 1 or is_of(kind, "stamp") or pa.types.is_integer(kind)
        is_time = is_integer and name in {self.arrays[cell][0] for cell in time.cells}
        if is_time and values.dtype.kind == "f" and (lost := np.count_nonzero(np.isnan(values))):
            raise InputError(  # an integer has no value for a missing one
                f"{self.path}: {name} lacks {lost} stamps; expected one in every row; remove the rows without, or name "
                "another clock with --map t=<column>"
            )
        return values.reshape(len(values), -1)

    def findings(self) -> tuple[Finding, ...]:
        text, many = "{}: row group {} of {} is damaged, and its last {} rows are left out ({})", len(self._sizes)
        return tuple(
            Finding("damaged_numbers", text.format(name, n + 1, many, rows, why), amount=float(rows), damaged=True)
            for (name, n), (rows, why) in sorted(self._damage.items())
        )

    def _values(self, array: pa.Array, column: str, start: int) -> NDArray[Any]:
        """Return the numbers of one column of a batch: (m,), or (m, width) for lists; NaN where there is none."""
        width = self._widths[column]
        if width == 0:
            kind = array.type
            if not (is_of(kind, "number") or is_of(kind, "stamp") or pa.types.is_boolean(kind)):
                raise InputError(f"{self.path}: {column} holds {array.type}; expected numbers; name another with --map")
            return _integers_or_floats(array)
        lengths = array.value_lengths().fill_null(0).to_numpy(zero_copy_only=False)
        if not ((lengths == width) | (lengths == 0)).all():
            row = int(np.flatnonzero((lengths != width) & (lengths != 0))[0])
            raise InputError(
                f"{self.path}: row {start + row + 1} of {column} holds {lengths[row]} values; expected {width} as in "
                "the first row; name a column of constant length with --map"
            )
        values = np.full((len(array), width), np.nan)
        values[lengths == width] = _integers_or_floats(array.flatten()).reshape(-1, width)
        return values


def is_of(kind: pa.DataType, what: str) -> bool:
    """Return whether a type is one of KINDS; text may be in a dictionary."""
    inner = kind.value_type if what == "text" and pa.types.is_dictionary(kind) else kind
    return any(is_one(inner) for is_one in KINDS[what])


def _flat(table: pa.Table | pa.RecordBatch) -> pa.Table:
    """Return a table with the fields of structs as columns of dotted names."""
    found = table if isinstance(table, pa.Table) else pa.Table.from_batches([table])
    while any(pa.types.is_struct(field.type) for field in found.schema):
        found = found.flatten()
    return found


def _integers_or_floats(array: pa.Array) -> NDArray[Any]:
    """Return Arrow numbers as NumPy: stamps as int64, everything else as it is, NaN for null."""
    if is_of(array.type, "stamp"):
        array = array.cast(pa.int64())
    if pa.types.is_decimal(array.type) or pa.types.is_boolean(array.type):
        array = array.cast(pa.float64())
    # Arrow's own conversion loads pandas, half a second, which only nulls need.
    return np.asarray(array.to_numpy(zero_copy_only=False) if array.null_count else np.from_dlpack(array))


def _first_rows(file: ParquetFile, columns: Sequence[str]) -> dict[str, list[Any]]:
    """Return the first rows of list columns; nothing of a file without rows."""
    first = next(file.iter_batches(batch_size=_LOOK_ROWS, columns=columns), None) if columns else None
    if first is None:
        return {}
    table = _flat(first)
    return {name: table[name].to_pylist() for name in columns}


def topics(path: Path) -> tuple[Topic, ...]:
    """List the table of a Parquet file."""
    with opened(path) as file:
        rows, columns = file.metadata.num_rows, file.metadata.num_columns
    return (Topic(name=path.name, type=f"table of {columns} columns", messages=rows, readable=True),)
