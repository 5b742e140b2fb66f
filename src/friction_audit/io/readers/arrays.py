"""Arrays -> Recording: what NumPy, MATLAB and LeRobot files and data frames share; NumPy .npy, which is one array."""

from collections.abc import Iterator, Mapping, Sequence
from math import prod
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers.channel_names import parse_name
from friction_audit.io.readers.columns import MOST_JOINTS, ColumnMap
from friction_audit.io.readers.reader import ReadOptions, Topic, by_number
from friction_audit.io.readers.table import ALL, ColumnTable, Piece, Rows, read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding

_PLANE = 2
_INDEX = "__index_level_0__"  # what Arrow calls an index without a name


class ArrayTable(ColumnTable):
    """Arrays by name, of shape (n,) or (n, k): numbers, dates, or the joints of a long table as text."""

    def __init__(self, path: Path, arrays: Mapping[str, Any], findings: tuple[Finding, ...] = ()) -> None:
        """Keep arrays, or what has the shape and type of one and is read by ``pieces``."""
        self._arrays, self.damage = arrays, findings
        widths = {name: prod(array.shape[1:]) for name, array in arrays.items()}
        for name, width in widths.items():
            if width > MOST_JOINTS and len(arrays[name].shape) == _PLANE and parse_name(f"{name}[0]"):
                what = f"{name} has shape {arrays[name].shape}, more columns than an arm has joints"
                raise InputError(f"{path}: {what}; expected one row per sample; transpose it")
        self.arrays = [(name, cell) for name, n in widths.items() if n <= MOST_JOINTS for cell in range(n)]
        super().__init__(path, [name if widths[name] == 1 else f"{name}[{cell}]" for name, cell in self.arrays])

    def size(self, columns: ColumnMap) -> tuple[int, int, str | None]:
        names = {self.arrays[cell][0]: None for cell in columns.cells}
        samples = self._arrays[next(iter(names))].shape[0]
        for name in sorted(names):
            if (shape := self._arrays[name].shape)[0] != samples:
                what = f"{name} has shape {shape}, {columns.time.name} has {samples} samples"
                raise InputError(f"{self.path}: {what}; expected one row per sample; transpose it, or cut it to length")
        is_date = self._arrays[self.arrays[columns.time.cells[0]][0]].dtype.kind in "mM"
        unit = "ns" if is_date else columns.time.unit
        return samples, sum(int(self._arrays[name].nbytes) for name in names), unit

    def pieces(self, columns: ColumnMap, name: str, rows: Rows) -> Iterator[Piece]:  # noqa: ARG002
        yield 0, self._arrays[name].reshape(len(self._arrays[name]), -1)

    def columns(self, columns: ColumnMap, cells: Sequence[int], rows: Rows = ALL) -> Iterator[Piece]:
        """Yield numbers, dates as nanoseconds; the joints of a long table as words."""
        for cell, found in super().columns(columns, cells, rows):
            values, kind = found, found.dtype.kind
            if cell == columns.joint:
                values = values.astype(object)
            elif kind in "mM" and cell in columns.time.cells:
                values = values.astype(f"{kind}8[ns]").astype(np.int64)
            elif kind not in "fiu":
                try:
                    values = values.astype(np.float64)
                except (ValueError, TypeError) as error:
                    what = f"{self.names[cell]} holds no numbers ({error}); name another column with --map"
                    raise InputError(f"{self.path}: {what}") from error
            yield cell, values


def arrays_of_frame(frame: Any, where: str) -> dict[str, NDArray[Any]]:  # noqa: ANN401 - a frame of any library
    """Return the columns of a pandas, polars or Arrow table, or of a mapping; an index of times becomes ``time``."""
    import pyarrow as pa

    if isinstance(frame, Mapping):
        arrays = {str(name): np.atleast_1d(np.asarray(values)) for name, values in frame.items()}
    else:
        try:
            table = pa.table(frame)
            arrays = {name: _column_of(table, name) for name in table.column_names}
        except (TypeError, ValueError) as error:  # those of Arrow are ValueErrors
            if not hasattr(frame, "columns"):
                what = "expected a pandas or polars DataFrame, or a dict of arrays by name"
                raise UsageError(f"{where}: {type(frame).__name__}: {what}") from error
            raise InputError(f"{where}: {error}; expected columns of numbers, or of lists of one length") from error
        if arrays.get(_INDEX, np.zeros(0)).dtype.kind in "mM":
            arrays = {"time": arrays.pop(_INDEX), **arrays}
    if not any(array.size for array in arrays.values()):
        raise InputError(f"{where}: 0 samples in {len(arrays)} columns; expected one row per sample")
    return {name: array for name, array in arrays.items() if array.size}


def _column_of(table: Any, name: str) -> NDArray[Any]:  # noqa: ANN401 - a table of Arrow
    """Return a column, shape (n,), or (n, k) of lists of k elements; ValueError if they differ in length."""
    from pyarrow import compute

    from friction_audit.io.readers.parquet import is_of

    column = table[name]
    column = column.chunk(0) if column.num_chunks == 1 else column.combine_chunks()  # which would copy one too
    if not is_of(column.type, "list"):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    if len(lengths := compute.unique(compute.list_value_length(column))) > 1:
        raise ValueError(f"{name} holds lists of {len(lengths)} lengths")
    return np.asarray(column.flatten().to_numpy(zero_copy_only=False)).reshape(len(column), -1)


def read(path: Path, options: ReadOptions) -> Recording:
    """Read an array whose columns ``--map`` names by number, or whose fields have names."""
    array = _array(path)
    if array.dtype.names:
        return read_table(ArrayTable(path, {name: array[name] for name in array.dtype.names}), options)
    if not options.mapping:
        raise InputError(f"{path}: an array of {array.shape[1]} columns without names; {by_number(array.shape[1])}")
    return read_table(ArrayTable(path, {f"#{number}": column for number, column in enumerate(array.T, 1)}), options)


def topics(path: Path) -> tuple[Topic, ...]:
    """List the one array of the file."""
    return topics_of({path.name: _array(path)})


def topics_of(arrays: Mapping[str, Any]) -> tuple[Topic, ...]:
    """List arrays, or what has the shape and type of one, by name."""
    return tuple(
        Topic(name=name, type=f"array {array.shape} {array.dtype}", messages=array.shape[0], readable=True)
        for name, array in arrays.items()
    )


def _array(path: Path) -> NDArray[Any]:
    """Map the array into memory: only the columns that are asked for are read."""
    try:
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OSError, EOFError, OverflowError, SyntaxError, TokenError) as error:
        if "allow_pickle" in str(error) or "Python objects" in str(error):
            raise InputError(f"{path}: Python objects, which could run foreign code; save plain arrays") from error
        raise InputError(f"{path}: a damaged NumPy array: {error}; copy or save it again") from error
    is_plane = array.ndim == _PLANE and array.dtype.kind in "fiu"
    if not array.size or not (array.ndim == 1 if array.dtype.names else is_plane):
        what = f"an array of shape {array.shape} {array.dtype}; expected numbers of shape (samples, columns)"
        raise InputError(f"{path}: {what}; save the signals by name with numpy.savez")
    if array.dtype.names is None and array.shape[0] < array.shape[1]:
        rows, columns = array.shape
        raise InputError(f"{path}: {rows} rows, {columns} columns; expected one row per sample; save the transpose")
    return array
