"""Arrays -> Recording: what NumPy, MATLAB and LeRobot files and data frames share; NumPy .npy, which is one array."""

from collections.abc import Mapping
from math import inf, prod
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers.clocks import Clock, TimeColumn, stamps_of, to_clock
from friction_audit.io.readers.columns import MOST_JOINTS, ColumnMap
from friction_audit.io.readers.reader import BY_NUMBER, ReadOptions, Topic
from friction_audit.io.readers.table import ColumnTable, Part, read_table
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Bool, Finding

_PLANE = 2
_INDEX = "__index_level_0__"  # what Arrow calls an index without a name


class ArrayTable(ColumnTable):
    """Arrays by name, of shape (n,) or (n, k): numbers, dates, or the joints of a long table as text."""

    def __init__(self, path: Path, arrays: Mapping[str, Any], findings: tuple[Finding, ...] = ()) -> None:
        """Keep arrays, or what has the shape and type of one and is read by ``load``."""
        self._arrays, self.damage = arrays, findings
        widths = {name: prod(array.shape[1:]) for name, array in arrays.items()}
        self._cells = [(name, cell) for name, n in widths.items() if n <= MOST_JOINTS for cell in range(n)]
        super().__init__(path, [name if widths[name] == 1 else f"{name}[{cell}]" for name, cell in self._cells])

    def load(self, name: str, rows: Bool | None = None) -> NDArray[Any]:
        """Return an array as (n, k), in the rows of a mask or in all."""
        array = self._arrays[name] if rows is None else self._arrays[name][rows]
        return array.reshape(len(array), -1)  # type: ignore[no-any-return]

    def size(self, columns: ColumnMap) -> tuple[int, int]:
        names = {self._cells[cell][0]: None for cell in columns.cells}
        samples = self._arrays[next(iter(names))].shape[0]
        for name in sorted(names):
            if (shape := self._arrays[name].shape)[0] != samples:
                what = f"{name} has shape {shape}, {columns.time.name} has {samples} samples"
                raise InputError(f"{self.path}: {what}; expected one row per sample; transpose it, or cut it to length")
        return samples, sum(int(self._arrays[name].nbytes) for name in names)

    def read_clock(self, time: TimeColumn, stop: float = inf) -> Clock:  # noqa: ARG002
        parts, unit = [self.load(name)[:, at] for name, at in (self._cells[cell] for cell in time.cells)], time.unit
        if parts[0].dtype.kind in "mM":
            parts, unit = [part.astype(f"{part.dtype.kind}8[ns]").astype(np.int64) for part in parts], "ns"
        return to_clock(stamps_of(parts), unit, path=str(self.path))

    def read_rows(self, columns: ColumnMap, clock: Clock, rows: Bool | None) -> Part:
        channels = {c: np.empty((len(clock.t), len(cells)), order="F") for c, cells in columns.channels.items()}
        for channel, cells in columns.channels.items():
            loaded: dict[str, NDArray[Any]] = {}
            for joint, cell in enumerate(cells):
                name, place = self._cells[cell]
                loaded = loaded if name in loaded else {name: self.load(name, rows)}  # one at a time is in memory
                try:
                    channels[channel][:, joint] = loaded[name][:, place]
                except (ValueError, TypeError) as error:
                    raise InputError(
                        f"{self.path}: {self.names[cell]} holds no numbers ({error}); name another column with --map"
                    ) from error
        if columns.joint is None:
            return Part(clock=clock, channels=channels)
        name, place = self._cells[columns.joint]
        return Part(clock=clock, channels=channels, joint=self.load(name, rows)[:, place].astype(object))


def arrays_of_frame(frame: Any, where: str) -> dict[str, NDArray[Any]]:  # noqa: ANN401 - a frame of any library
    """Return the columns of a pandas, polars or Arrow table, or of a mapping; an index of times becomes ``time``."""
    import pyarrow as pa

    if isinstance(frame, Mapping):
        arrays = {str(name): np.atleast_1d(np.asarray(values)) for name, values in frame.items()}
    else:
        try:
            table = pa.table(frame)
            arrays = {name: column_of(table, name) for name in table.column_names}
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


def column_of(table: Any, name: str) -> NDArray[Any]:  # noqa: ANN401 - a table of Arrow
    """Return a column, shape (n,), or (n, k) of lists of k elements; ValueError if they differ in length."""
    from pyarrow import compute

    from friction_audit.io.readers.arrow import is_of, whole

    column = whole(table[name])
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
        raise InputError(f"{path}: an array of {array.shape[1]} columns without names; {BY_NUMBER}")
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
