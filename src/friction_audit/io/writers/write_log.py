"""Write a log in any format, tables here; of the writers of an ending, the first is its default.

Text tables are tidy, long, as bags are exported to CSV, and as libfranka's ``logToCSV`` writes them.
"""

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import UsageError, near_misses
from friction_audit.io.files import whole_file
from friction_audit.io.readers.joint_states import JOINT_STATE
from friction_audit.io.writers.mcap import MCAP_DIALECTS
from friction_audit.io.writers.ros_messages import BAGS
from friction_audit.io.writers.tables import NANOSECONDS, ColumnOf, Writer, logged_channels, stamps_ns, tidy_columns
from friction_audit.joint_log import JointLog

_STRUCTURE = re.compile('[,"]')  # a name with these needs quotes
_LIBFRANKA_JOINTS = 7
_STATE = ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered")
_COMMAND = {"q_d": 7, "dq_d": 7, "O_T_EE_d": 16, "O_dP_EE_d": 6, "tau_J_d": 7}  # field of a command -> its numbers


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


def _long(log: JointLog) -> dict[str, ColumnOf]:
    """One row per time and joint."""
    logged = logged_channels(log)
    fields = {field: logged[name].ravel(order="C") for name, field in JOINT_STATE.items() if name in logged}
    names = np.tile(np.array(_names(log), dtype=object), len(log.t))
    return {"time": np.repeat(log.t, len(log.joint_names)), "joint": names, **fields}


def _joint_state(log: JointLog, *, rostopic: bool) -> dict[str, ColumnOf]:
    """What ``rostopic echo -p`` prints of a JointState, or what scripts that turn a bag into CSV make of it."""
    stamps, logged = stamps_ns(log), logged_channels(log)
    columns: dict[str, ColumnOf] = {}
    if rostopic:
        columns |= {"%time": stamps, "field.header.seq": np.arange(len(stamps)), "field.header.stamp": stamps}
        columns["field.header.frame_id"] = np.full(len(stamps), "", object)
    else:
        columns["header.stamp.sec"], columns["header.stamp.nanosec"] = np.divmod(stamps, NANOSECONDS)
    template = "field.{}{}" if rostopic else "{}.{}"
    for joint, name in enumerate(_names(log)):
        columns[template.format("name", joint)] = np.full(len(stamps), name, object)
    for channel, field in JOINT_STATE.items():
        for joint, column in enumerate(logged[channel].T if channel in logged else ()):
            columns[template.format(field, joint)] = column
    return columns


def _names(log: JointLog) -> list[str]:
    """Return the joints' names, each in one line: readers of such tables go by lines."""
    return [" ".join(name.splitlines()) for name in log.joint_names]


def _write_csv(columns_of: Callable[[JointLog], dict[str, ColumnOf]], log: JointLog, path: Path) -> None:
    """Write numbers in the shortest form that reads back to the bit, and names as they are, to be read back."""
    import pyarrow as pa
    from pyarrow import csv

    columns = columns_of(log)
    names = {name for column in columns.values() if column.dtype == object for name in column.tolist()}
    special = any(_STRUCTURE.search(name) for name in names)
    options = csv.WriteOptions(include_header=False, quoting_style="needed" if special else "none")
    with path.open("wb") as stream:
        stream.write((",".join(columns) + "\n").encode())
        csv.write_csv(pa.table({name: pa.array(column) for name, column in columns.items()}), stream, options)


def _write_libfranka(log: JointLog, path: Path, *, is_old: bool) -> None:
    """Write milliseconds, success rate, state and command, with six digits as a C++ stream does by default.

    The header up to 0.9.0 has blanks, repeated names, and a column that holds nothing.
    """
    recorded, blank = logged_channels(log), np.full_like(log.q, np.nan)
    # A robot held by hand is asked to stay where it is; a command is a torque if one was recorded, and no motion.
    filled = {"q_d": log.q, "dq": blank, "dq_d": np.zeros_like(log.q), "tau_ext_hat_filtered": blank}
    state = [recorded.get(field, filled.get(field, log.q)) for field in _STATE]
    command = [np.zeros((len(log.t), size)) for size in _COMMAND.values()]
    command[-1] = recorded.get("tau_J_d", blank)
    if is_old:
        spaced = [", ".join(f"{field}[{i}]" for i in range(_LIBFRANKA_JOINTS)) for field in _STATE]
        asked = [", ".join(f"{field}[{i}]" for i in range(size)) for field, size in _COMMAND.items()]
        header = f"duration, success rate, {','.join(spaced)},sent commands,{','.join(asked)}"
    else:
        names = [f"state.{field}[{i}]" for field in _STATE for i in range(_LIBFRANKA_JOINTS)]
        names += [f"cmd.{field}[{i}]" for field, size in _COMMAND.items() for i in range(size)]
        header = ",".join(["time", "success_rate", *names])
    formats = [",".join(["%g"] * sum(array.shape[1] for array in arrays)) for arrays in (state, command)]
    numbers = np.column_stack([np.rint(log.t * 1000.0), *state, *command])
    line = f"%d,1,{formats[0]}{',,' if is_old else ','}{formats[1]}"
    np.savetxt(path, numbers, fmt=line, header=header, comments="", encoding="ascii")


_EFFORT: dict[str, Any] = {"holds": tuple(JOINT_STATE)}
_LIBFRANKA: dict[str, Any] = {
    "lossless": False, "holds": ("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered"), "joints": _LIBFRANKA_JOINTS
}  # fmt: skip
WRITERS: tuple[Writer, ...] = (
    Writer("parquet", ".parquet", _write_parquet,
           "tidy Parquet, one column per channel and joint; every channel, to the bit"),
    Writer("parquet-lists", ".parquet", partial(_write_parquet, lists=True),
           "Parquet with one list-valued column per channel"),
    Writer("csv", ".csv", partial(_write_csv, tidy_columns),
           "tidy CSV, one column per channel and joint; every channel, to the bit, without the joints' names"),
    Writer("csv-long", ".csv", partial(_write_csv, _long),
           "one row per time and joint: time, joint, position, velocity, effort", **_EFFORT),
    Writer("csv-rostopic", ".csv", partial(_write_csv, partial(_joint_state, rostopic=True)),
           "as rostopic echo -p prints a sensor_msgs/JointState", **_EFFORT),
    Writer("csv-bag", ".csv", partial(_write_csv, partial(_joint_state, rostopic=False)),
           "as bag-to-CSV scripts write a sensor_msgs/JointState: position.0, velocity.0, effort.0", **_EFFORT),
    Writer("csv-libfranka", ".csv", partial(_write_libfranka, is_old=False),
           "libfranka logToCSV from 0.9.1 on: milliseconds, six digits", **_LIBFRANKA),
    Writer("csv-libfranka-0.9", ".csv", partial(_write_libfranka, is_old=True),
           "libfranka logToCSV up to 0.9.0: milliseconds, six digits, repeated names", **_LIBFRANKA),
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
