"""JointLog -> text tables: tidy, long, as bags are exported to CSV, and as libfranka's ``logToCSV`` writes them."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.io.readers.message_kinds import JOINT_STATE
from friction_audit.io.writers.tables import NANOSECONDS, ColumnOf, Writer, logged_channels, stamps_ns, tidy_columns
from friction_audit.joint_log import Float, JointLog

_STRUCTURE = re.compile('[,"]')  # a name with these needs quotes
_LIBFRANKA_JOINTS = 7
_STATE = ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered")
_COMMAND = {"q_d": 7, "dq_d": 7, "O_T_EE_d": 16, "O_dP_EE_d": 6, "tau_J_d": 7}  # field of a command -> its numbers


def _long(log: JointLog) -> dict[str, ColumnOf]:
    """One row per time and joint."""
    logged = logged_channels(log)
    fields = {field: logged[name].ravel(order="C") for name, field in JOINT_STATE.items() if name in logged}
    names = np.tile(np.array(_names(log), dtype=object), len(log.t))
    return {"time": np.repeat(log.t, len(log.joint_names)), "joint": names, **fields}


def _rostopic(log: JointLog) -> dict[str, ColumnOf]:
    """What ``rostopic echo -p`` prints of a JointState: stamps in nanoseconds, ``field.position0``, ..."""
    stamps = stamps_ns(log)
    head = {"%time": stamps, "field.header.seq": np.arange(len(stamps)), "field.header.stamp": stamps}
    return {**head, "field.header.frame_id": np.full(len(stamps), "", object), **_joint_state(log, "field.{}{}")}


def _bag_export(log: JointLog) -> dict[str, ColumnOf]:
    """What scripts that turn a bag into CSV make of a JointState: ``header.stamp.sec``, ``position.0``, ..."""
    seconds, nanoseconds = np.divmod(stamps_ns(log), NANOSECONDS)
    return {"header.stamp.sec": seconds, "header.stamp.nanosec": nanoseconds, **_joint_state(log, "{}.{}")}


def _joint_state(log: JointLog, template: str) -> dict[str, ColumnOf]:
    """Return the columns of a JointState, its joints' names first."""
    names = {template.format("name", j): np.full(len(log.t), name, object) for j, name in enumerate(_names(log))}
    arrays = logged_channels(log)
    fields = {field: arrays[channel].T for channel, field in JOINT_STATE.items() if channel in arrays}
    columns = {template.format(field, j): column for field, rows in fields.items() for j, column in enumerate(rows)}
    return {**names, **columns}


def _names(log: JointLog) -> list[str]:
    """Return the joints' names, each in one line: readers of such tables go by lines."""
    return [" ".join(name.splitlines()) for name in log.joint_names]


def _write(columns_of: Callable[[JointLog], dict[str, ColumnOf]], log: JointLog, path: Path) -> None:
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
    numbers: Float = np.column_stack([np.rint(log.t * 1000.0), *state, *command])
    line = f"%d,1,{formats[0]}{',,' if is_old else ','}{formats[1]}"
    np.savetxt(path, numbers, fmt=line, header=header, comments="", encoding="ascii")


_EFFORT: dict[str, Any] = {"holds": tuple(JOINT_STATE)}
_LIBFRANKA: dict[str, Any] = {
    "lossless": False, "holds": ("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered"), "joints": _LIBFRANKA_JOINTS
}  # fmt: skip
CSV_DIALECTS = (
    Writer("csv", ".csv", partial(_write, tidy_columns),
           "tidy CSV, one column per channel and joint; every channel, to the bit, without the joints' names"),
    Writer("csv-long", ".csv", partial(_write, _long),
           "one row per time and joint: time, joint, position, velocity, effort", **_EFFORT),
    Writer("csv-rostopic", ".csv", partial(_write, _rostopic),
           "as rostopic echo -p prints a sensor_msgs/JointState", **_EFFORT),
    Writer("csv-bag", ".csv", partial(_write, _bag_export),
           "as bag-to-CSV scripts write a sensor_msgs/JointState: position.0, velocity.0, effort.0", **_EFFORT),
    Writer("csv-libfranka", ".csv", partial(_write_libfranka, is_old=False),
           "libfranka logToCSV from 0.9.1 on: milliseconds, six digits", **_LIBFRANKA),
    Writer("csv-libfranka-0.9", ".csv", partial(_write_libfranka, is_old=True),
           "libfranka logToCSV up to 0.9.0: milliseconds, six digits, repeated names", **_LIBFRANKA),
)  # fmt: skip
