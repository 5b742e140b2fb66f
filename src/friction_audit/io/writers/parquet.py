"""JointLog -> Parquet: one column per channel and joint, or one list-valued column per channel."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.io.writers.tables import tidy_columns
from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    import pyarrow as pa


def write_parquet(log: JointLog, path: Path) -> None:
    """Write the tidy table: ``time`` [s], then ``q_1``, ``q_2``, ... in SI units."""
    import pyarrow as pa

    _write(pa.table({name: pa.array(column) for name, column in tidy_columns(log).items()}), log, path)


def write_parquet_lists(log: JointLog, path: Path) -> None:
    """Write ``time`` [s] and one column of lists per channel."""
    import pyarrow as pa

    lists = {
        name: pa.FixedSizeListArray.from_arrays(pa.array(channel.ravel(order="C")), channel.shape[1]).cast(
            pa.list_(pa.float64())
        )
        for name, channel in log.channels().items()
    }
    _write(pa.table({"time": pa.array(log.t), **lists}), log, path)


def _write(table: "pa.Table", log: JointLog, path: Path) -> None:
    """Write a table compressed, with the joints' names in its key-value metadata."""
    import pyarrow.parquet as pq

    notes = {"joint_names": json.dumps(log.joint_names), "robot": log.source.robot}
    if log.source.start_s is not None:
        notes["start_s"] = repr(log.source.start_s)
    if log.source.serial:
        notes["serial"] = log.source.serial
    pq.write_table(table.replace_schema_metadata(notes), path, compression="zstd", write_page_checksum=True)


PARQUET = Writer(
    name="parquet",
    suffix=".parquet",
    write=write_parquet,
    summary="tidy Parquet, one column per channel and joint; every channel, to the bit",
)
PARQUET_LISTS = Writer(
    name="parquet-lists",
    suffix=".parquet",
    write=write_parquet_lists,
    summary="Parquet with one list-valued column per channel",
)
