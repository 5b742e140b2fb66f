"""What a writer is; the columns of a log as tables have them; tables of results, joint by joint; trajectories."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import encodable, printable
from friction_audit.joint_log import DERIVATIVE, JOINT_CHANNELS, Float, Int, JointLog
from friction_audit.presets import candidates

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa


NUMBERED = ("csv", "libfranka", "franka-state", "flat")  # endings of dialects that number the joints, without names


class Writer(NamedTuple):
    """A file format or dialect; of several of one suffix the first in WRITERS is its default."""

    name: str  # unique, e.g. "parquet", "rosbag1-franka-state"
    suffix: str  # file name ending with the dot, or "" for a directory
    write: Callable[[JointLog, Path], None]  # to a path that does not exist yet; the caller renames it into place
    summary: str  # one line for help and documentation
    lossless: bool = True  # reading the file back gives the same numbers to the bit, stamps of whole nanoseconds given
    holds: tuple[str, ...] = JOINT_CHANNELS  # channels that it has a place for
    joints: int | None = None  # number of joints that it holds, or None for any

    def lacks(self, log: JointLog) -> list[str]:
        """Return what a log has not and this dialect needs: one that does not hold all channels is for the effort."""
        joints, there = len(log.joint_names), log.channels()
        found = [] if "tau_J" in there or self.holds == JOINT_CHANNELS else [f"tau_J (the log has {', '.join(there)})"]
        return found + ([] if self.joints in (None, joints) else [f"{self.joints} joints (the log has {joints})"])

    def left_out(self, log: JointLog) -> tuple[str, ...]:
        """Return what of a log this dialect has no place for: channels, and the arm where joint names do not say it."""
        robot, named = log.source.robot, not self.name.endswith(NUMBERED)
        known = self.name.startswith("parquet") or (named and candidates(log.joint_names) == (robot,))
        known |= robot == "unknown" or (self.name, robot) == ("csv-libfranka-0.9", "panda")  # which is no other arm's
        lost = [] if known else [f"the name of the arm (read it with --robot {robot})"]
        if (unit := log.source.torque_unit) != "N m" and self.name not in ("parquet", "csv"):
            lost.append(f"the unit of the torque, {unit} (read it with --map tau_J=NAME:{unit})")
        return (*(name for name in log.channels() if name not in self.holds), *lost)


NANOSECONDS = 1_000_000_000
UNKNOWN_START_NS = NANOSECONDS  # first stamp of a log whose clock has no date; a stamp of 0 means 'not set' in ROS
ColumnOf = Float | Int | NDArray[np.object_]  # numbers, stamps or words


def stamps_ns(log: JointLog) -> Int:
    """Return the Unix time of every sample, shape (n,). [ns]"""
    start = UNKNOWN_START_NS if log.source.start_s is None else round(log.source.start_s * NANOSECONDS)
    return start + np.rint(log.t * NANOSECONDS).astype(np.int64)


def logged_channels(log: JointLog) -> dict[str, Float]:
    """Return the channels without a velocity that was made from q: whoever reads it would take it for a logged one."""
    return {name: array for name, array in log.channels().items() if log.source.channels.get(name) != DERIVATIVE}


def tidy_columns(log: JointLog) -> dict[str, ColumnOf]:
    """Return ``time`` [s], then ``q_1``, ``q_2``, ... of every channel that was recorded."""
    channels, current = logged_channels(log).items(), log.source.torque_unit
    units = {} if current == "N m" else {"tau_J": f" [{current}]"}
    columns = ((name, j, column) for name, a in channels for j, column in enumerate(a.T, start=1))
    return {"time": log.t, **{f"{name}_{j}{units.get(name, '')}": column for name, j, column in columns}}


Column = NDArray[Any] | Sequence[Any]  # numbers (NaN where there is none), flags, or words


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointRows:
    """The rows of one joint."""

    joint: int  # number for people
    name: str  # name in the log
    columns: Mapping[str, Column]  # by name, all of one length

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


class TidyTable(NamedTuple):
    """A table: one row per joint and the quantity of its name."""

    name: str  # what a file of it is called
    summary: str  # what a row is, in a line
    types: Mapping[str, type]  # what is in each column: str, int, float or bool
    time: str | None  # the column that says when a row was known [s], None for what the whole log says
    rows: tuple[JointRows, ...]  # joint after joint


# Columns that every table of joints begins with.
HEAD: dict[str, type] = {"joint": int, "name": str}

Lot = Mapping[str, Column]  # columns by name, all of one length
_FORMULA = tuple("=+-@\t\r\n\uff1d\uff0b\uff0d\uff20")  # of what a spreadsheet computes, full-width forms included


def write_table(table: TidyTable, path: Path, kind: str) -> None:
    """Write a table of joints as CSV or Parquet (a row group per joint)."""
    write_rows(HEAD | dict(table.types), _lots(table), path, kind)


def write_rows(types: Mapping[str, type], lots: Iterable[Lot], path: Path, kind: str) -> None:
    """Write lots of rows, numbers, words and flags, None where there is nothing; ``kind`` is "csv" or "parquet".

    CSV has numbers in the shortest form that reads back to the bit, and an empty cell for none.
    """
    from pyarrow.csv import CSVWriter
    from pyarrow.parquet import ParquetWriter

    rows = _arrow(types, lots, for_csv=kind == "csv")
    write = CSVWriter if kind == "csv" else partial(ParquetWriter, compression="zstd", write_page_checksum=True)
    with path.open("wb") as file, write(file, rows.schema) as writer:  # Arrow takes no name that is not UTF-8
        for batch in rows:
            writer.write_batch(batch)


def to_frame(table: TidyTable) -> "pd.DataFrame":
    """Return a table as a pandas frame; NaN or None where there is nothing."""
    frame: pd.DataFrame = _arrow(HEAD | dict(table.types), _lots(table)).read_pandas()
    return frame


def _lots(table: TidyTable) -> Iterator[Lot]:
    for rows in table.rows:
        if n := len(rows):
            yield {"joint": np.full(n, rows.joint), "name": [rows.name] * n, **rows.columns}


def _arrow(types: Mapping[str, type], lots: Iterable[Lot], *, for_csv: bool = False) -> "pa.RecordBatchReader":
    """Return each lot of rows as a batch; in CSV an apostrophe keeps a spreadsheet from computing a text."""
    import pyarrow as pa

    kinds = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in types.items()])

    def batches() -> "Iterator[pa.RecordBatch]":
        for lot in lots:
            columns = dict(lot)
            for name in (name for name, kind in types.items() if kind is str):
                texts = {text: text if text is None else encodable(text) for text in set(lot[name])}
                if for_csv:
                    plain = {text: printable(text) for text in texts if text is not None}
                    texts |= {text: f"'{own}" if text.startswith(_FORMULA) else own for text, own in plain.items()}
                columns[name] = [texts[text] for text in lot[name]]
            arrays = [pa.array(columns[n], kinds[k], from_pandas=None if k is str else True) for n, k in types.items()]
            yield pa.record_batch(arrays, schema=schema)

    return pa.RecordBatchReader.from_batches(schema, batches())


class Trajectory(NamedTuple):
    """A trajectory of n points and j joints."""

    names: tuple[str, ...]  # of the joints
    t: Float  # time from the start, shape (n,) [s]
    q: Float  # position, shape (n, j) [rad]
    dq: Float  # velocity [rad/s]
    ddq: Float  # acceleration [rad/s^2]


def write_trajectory_csv(trajectory: Trajectory, path: Path) -> None:
    """Write a row per point: time_s, then q, dq and ddq of every joint."""
    heads = ["time_s", *(f"{quantity}_{name}" for quantity in ("q", "dq", "ddq") for name in trajectory.names)]
    rows = np.column_stack(trajectory[1:])
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=",".join(heads), comments="", encoding="utf-8")
