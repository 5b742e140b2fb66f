"""Arrays in memory -> Recording: what NumPy, MATLAB and LeRobot files and data frames share."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers.columns import MOST_JOINTS, ColumnMap
from friction_audit.io.readers.table import ColumnTable, Part
from friction_audit.io.readers.time_column import Clock, TimeColumn, to_clock
from friction_audit.joint_log import Finding

_NANOSECONDS = 1_000_000_000
_INDEX = "__index_level_0__"  # what Arrow calls an index without a name


class ArrayTable(ColumnTable):
    """Arrays by name, of shape (n,) or (n, k): numbers, dates, or the joints of a long table as text."""

    def __init__(self, path: Path, arrays: Mapping[str, NDArray[Any]], findings: tuple[Finding, ...] = ()) -> None:
        self._findings = findings
        self._cells: list[NDArray[Any]] = []
        names: list[str] = []
        for name, array in arrays.items():
            rows = array.reshape(len(array), -1)
            if rows.shape[1] > MOST_JOINTS:
                continue
            one = rows.shape[1] == 1
            names += [name] if one else [f"{name}[{column}]" for column in range(rows.shape[1])]
            self._cells += list(rows.T)
        super().__init__(path, names)

    def findings(self) -> tuple[Finding, ...]:
        """Return what was noticed when the arrays were read."""
        return self._findings

    def size(self, columns: ColumnMap) -> tuple[int, int]:
        """Return the number of samples, and the bytes of these columns."""
        wanted = [*columns.time.cells, *(cell for cells in columns.channels.values() for cell in cells)]
        samples = len(self._cells[columns.time.cells[0]])
        for cell in wanted:
            if len(self._cells[cell]) != samples:
                raise InputError(
                    f"{self.path}: {self.names[cell]} has {len(self._cells[cell])} samples, {columns.time.name} has "
                    f"{samples}; expected one row per sample; save arrays of shape (samples, joints)"
                )
        return samples, sum(self._cells[cell].nbytes for cell in wanted)

    def read_clock(self, time: TimeColumn) -> Clock:
        """Read all stamps."""
        stamps, unit = self._cells[time.cells[0]], time.unit
        if stamps.dtype.kind in "mM":
            stamps, unit = stamps.astype(f"{stamps.dtype.kind}8[ns]").astype(np.int64), "ns"
        elif len(time.cells) > 1:
            stamps = stamps.astype(np.int64) * _NANOSECONDS + self._cells[time.cells[1]].astype(np.int64)
        raw: NDArray[Any] = stamps.astype(np.int64 if stamps.dtype.kind in "iu" else np.float64)
        return to_clock(raw, unit, path=str(self.path))

    def read_rows(self, columns: ColumnMap, clock: Clock, rows: NDArray[np.bool_] | None) -> Part:
        """Read the channels, in the rows of a mask or in all."""
        kept = slice(None) if rows is None else rows
        channels = {c: np.empty((len(clock.t), len(cells)), order="F") for c, cells in columns.channels.items()}
        for channel, cells in columns.channels.items():
            for joint, cell in enumerate(cells):
                try:
                    channels[channel][:, joint] = self._cells[cell][kept]
                except (ValueError, TypeError) as error:
                    raise InputError(
                        f"{self.path}: {self.names[cell]} holds no numbers ({error}); name another column with --map"
                    ) from error
        labels = None if columns.joint is None else self._cells[columns.joint][kept].astype(object)
        return Part(clock=clock, channels=channels, joint=labels)


def arrays_of_frame(frame: Any, where: str) -> dict[str, NDArray[Any]]:  # noqa: ANN401 - a frame of any library
    """Return the columns of a pandas, polars or Arrow table, or of a mapping of names to arrays.

    An index of times without a name becomes the column ``time``.

    Raises:
        UsageError: If it is none of these.
        InputError: If it holds no rows, or lists of several lengths.
    """
    import pyarrow as pa

    if isinstance(frame, Mapping):
        arrays = {str(name): np.atleast_1d(np.asarray(values)) for name, values in frame.items()}
    else:
        try:
            table = pa.table(frame)
            arrays = {name: column_of(table, name) for name in table.column_names}
        except (TypeError, ValueError) as error:  # those of Arrow are ValueErrors
            if not hasattr(frame, "columns"):
                raise UsageError(
                    f"{where}: {type(frame).__name__}: expected a pandas or polars DataFrame, or a dict of arrays "
                    "by name"
                ) from error
            raise InputError(f"{where}: {error}; expected columns of numbers, or of lists of one length") from error
        if arrays.get(_INDEX, np.zeros(0)).dtype.kind in "mM":
            arrays = {"time": arrays.pop(_INDEX), **arrays}
    if not any(array.size for array in arrays.values()):
        raise InputError(f"{where}: 0 samples in {len(arrays)} columns; expected one row per sample")
    return {name: array for name, array in arrays.items() if array.size}


def column_of(table: Any, name: str) -> NDArray[Any]:  # noqa: ANN401 - a table of Arrow
    """Return a column, shape (n,), or (n, k) of lists of k elements.

    Raises:
        ValueError: If the lists differ in length.
    """
    import pyarrow as pa
    from pyarrow import compute

    column = table[name].combine_chunks()
    kinds = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
    if not any(is_kind(column.type) for is_kind in kinds):
        array: NDArray[Any] = column.to_numpy(zero_copy_only=False)
        return array
    if len(lengths := compute.unique(compute.list_value_length(column))) > 1:
        raise ValueError(f"{name} holds lists of {len(lengths)} lengths")
    values: NDArray[Any] = column.flatten().to_numpy(zero_copy_only=False)
    return values.reshape(len(column), -1)
