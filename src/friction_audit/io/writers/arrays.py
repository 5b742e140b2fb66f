"""JointLog -> Parquet (a column per channel and joint, or a list-valued one per channel) and NumPy archives."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.io.writers.tables import Writer, tidy_columns
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    import pyarrow as pa


def _write_parquet(log: JointLog, path: Path) -> None:
    import pyarrow as pa

    _write(pa.table({name: pa.array(column) for name, column in tidy_columns(log).items()}), log, path)


def _write_parquet_lists(log: JointLog, path: Path) -> None:
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


def _write_npz(log: JointLog, path: Path) -> None:
    """Write one array of shape (n, j) per channel; ``time`` is in milliseconds and has shape (n, 1)."""
    # Row by row, so that a reader gets all joints of a part at once.
    arrays: dict[str, Any] = {name: np.ascontiguousarray(array) for name, array in log.channels().items()}
    arrays["time"] = np.round(log.t * 1000.0, 6)[:, np.newaxis]
    with path.open("wb") as stream:
        np.savez_compressed(stream, joint_names=np.array(log.joint_names), **arrays)


PARQUET = Writer(
    name="parquet",
    suffix=".parquet",
    write=_write_parquet,
    summary="tidy Parquet, one column per channel and joint; every channel, to the bit",
)
PARQUET_LISTS = Writer(
    name="parquet-lists",
    suffix=".parquet",
    write=_write_parquet_lists,
    summary="Parquet with one list-valued column per channel",
)
NPZ = Writer(
    name="npz",
    suffix=".npz",
    write=_write_npz,
    summary="NumPy archive with the keys of panda-py's get_log(); milliseconds, other numbers to the bit",
    lossless=False,
)
