"""Write a log in any format, Parquet and NumPy archives here; of the writers of an ending, the first is its default."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import UsageError, near_misses
from friction_audit.io.files import whole_file
from friction_audit.io.writers.csv import CSV_DIALECTS
from friction_audit.io.writers.mcap import MCAP_DIALECTS
from friction_audit.io.writers.ros_messages import BAGS
from friction_audit.io.writers.tables import Writer, logged_channels, tidy_columns
from friction_audit.joint_log import JointLog


def _write_parquet(log: JointLog, path: Path, *, lists: bool = False) -> None:
    """Write a compressed table, of scalars or of lists, with the joints' names in its key-value metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: pa.array(column) for name, column in ({"time": log.t} if lists else tidy_columns(log)).items()}
    for name, channel in logged_channels(log).items() if lists else ():
        of_one_length = pa.FixedSizeListArray.from_arrays(pa.array(channel.ravel(order="C")), channel.shape[1])
        columns[name] = of_one_length.cast(pa.list_(pa.float64()))
    notes = {"joint_names": json.dumps(log.joint_names), "robot": log.source.robot}
    if log.source.start_s is not None:
        notes["start_s"] = repr(log.source.start_s)
    if log.source.serial:
        notes["serial"] = log.source.serial
    pq.write_table(pa.table(columns).replace_schema_metadata(notes), path, compression="zstd", write_page_checksum=True)


def _write_npz(log: JointLog, path: Path) -> None:
    """Write one array of shape (n, j) per channel; ``time`` is in milliseconds and has shape (n, 1)."""
    # Row by row, so that a reader gets all joints of a part at once.
    arrays: dict[str, Any] = {name: np.ascontiguousarray(array) for name, array in logged_channels(log).items()}
    arrays["time"] = np.round(log.t * 1000.0, 6)[:, np.newaxis]
    with path.open("wb") as stream:
        np.savez_compressed(stream, joint_names=np.array(log.joint_names), **arrays)


WRITERS: tuple[Writer, ...] = (
    Writer("parquet", ".parquet", _write_parquet,
           "tidy Parquet, one column per channel and joint; every channel, to the bit"),
    Writer("parquet-lists", ".parquet", partial(_write_parquet, lists=True),
           "Parquet with one list-valued column per channel"),
    *CSV_DIALECTS,
    Writer("npz", ".npz", _write_npz,
           "NumPy archive with the keys of panda-py's get_log(); milliseconds, other numbers to the bit",
           lossless=False),
    *BAGS,
    *MCAP_DIALECTS,
)  # fmt: skip


def write_log(log: JointLog, path: Path, *, dialect: str | None = None, overwrite: bool = False) -> Writer:
    """Write a log whole or not at all, with the writer of a dialect or of the file name's ending, which is returned."""
    writer = choose_writer(path, dialect)
    check_fit(log, writer)
    with whole_file(path, overwrite=overwrite) as draft:
        writer.write(log, draft)
    return writer


def choose_writer(path: Path, dialect: str | None = None) -> Writer:
    """Return the writer of a dialect, or the first one of the file name's ending."""
    suffix = path.suffix.lower()
    ending = f"{path}: ending {suffix or 'missing'}"
    found = next((one for one in WRITERS if (one.name == dialect if dialect else one.suffix == suffix != "")), None)
    if found is None and dialect is None:
        endings = ", ".join(dict.fromkeys(writer.suffix for writer in WRITERS if writer.suffix))
        raise UsageError(f"{ending}: expected one of {endings}, or name a --dialect")
    if found is None:
        names = [writer.name for writer in WRITERS]
        raise UsageError(f"--dialect {dialect}: expected one of {', '.join(names)}{near_misses(str(dialect), names)}")
    if found.suffix not in ("", suffix):
        raise UsageError(f"{ending}: the dialect {dialect} writes {found.suffix}; rename it")
    return found


def check_fit(log: JointLog, writer: Writer) -> None:
    """Refuse what the dialect cannot hold and say which dialects can."""
    if lacks := writer.lacks(log):
        able = ", ".join(other.name for other in WRITERS if not other.lacks(log))
        needs = f"{log.source.path}: the dialect {writer.name} needs {' and '.join(lacks)}"
        raise UsageError(f"{needs}; choose one that can hold the log: {able}")
