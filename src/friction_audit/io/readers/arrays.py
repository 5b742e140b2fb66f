"""Arrays in memory -> Recording: what NumPy, MATLAB and LeRobot files and data frames share."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.columns import MOST_JOINTS, ColumnMap
from friction_audit.io.readers.table import ColumnTable, Part
from friction_audit.io.readers.time_column import Clock, TimeColumn, to_clock

_NANOSECONDS = 1_000_000_000


class ArrayTable(ColumnTable):
    """Arrays by name, of shape (n,) or (n, k): numbers, dates, or the joints of a long table as text."""

    def __init__(self, path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
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
        if stamps.dtype.kind == "M":
            stamps, unit = stamps.astype("datetime64[ns]").astype(np.int64), "ns"
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
