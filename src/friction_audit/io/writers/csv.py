"""JointLog -> text tables: tidy, long, and as bags are exported to CSV."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.writers.tables import NANOSECONDS, ColumnOf, joint_columns, stamps_ns, tidy_columns
from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog

JOINT_STATE_FIELDS = {"q": "position", "dq": "velocity", "tau_J": "effort"}
"""Channel -> field of a sensor_msgs/JointState."""

JOINT_STATE_CHANNELS = tuple(JOINT_STATE_FIELDS)

STRUCTURE = re.compile('[,"]')
"""Characters of a name that needs quotes."""


def write_tidy(log: JointLog, path: Path) -> None:
    """Write ``time`` [s], then ``q_1``, ``q_2``, ...; every number so that it reads back to the bit."""
    write_columns(tidy_columns(log), path)


def write_long(log: JointLog, path: Path) -> None:
    """Write one row per time and joint: ``time``, ``joint``, ``position``, ``velocity``, ``effort``."""
    joints = len(log.joint_names)
    fields = {JOINT_STATE_FIELDS[name]: log.channels()[name].ravel(order="C") for name in JOINT_STATE_CHANNELS}
    names = np.tile(np.array(_names(log), dtype=object), len(log.t))
    write_columns({"time": np.repeat(log.t, joints), "joint": names, **fields}, path)


def write_rostopic(log: JointLog, path: Path) -> None:
    """Write what ``rostopic echo -p`` prints of a JointState: stamps in nanoseconds, ``field.position0``, ..."""
    stamps = stamps_ns(log)
    head: dict[str, ColumnOf] = {
        "%time": stamps,
        "field.header.seq": np.arange(len(stamps)),
        "field.header.stamp": stamps,
        "field.header.frame_id": _constant("", len(stamps)),
    }
    names = {f"field.name{j}": _constant(name, len(stamps)) for j, name in enumerate(_names(log))}
    write_columns({**head, **names, **_joint_state(log, "field.{field}{joint}")}, path)


def write_bag_export(log: JointLog, path: Path) -> None:
    """Write what scripts that turn a bag into CSV make of a JointState: ``header.stamp.sec``, ``position.0``, ..."""
    stamps = stamps_ns(log)
    head: dict[str, ColumnOf] = {
        "header.stamp.sec": stamps // NANOSECONDS,
        "header.stamp.nanosec": stamps % NANOSECONDS,
    }
    names = {f"name.{j}": _constant(name, len(stamps)) for j, name in enumerate(_names(log))}
    write_columns({**head, **names, **_joint_state(log, "{field}.{joint}")}, path)


def write_columns(columns: dict[str, ColumnOf], path: Path) -> None:
    """Write columns of numbers and names, numbers in the shortest form that reads back to the bit.

    Names are written as they are, unlike in tables of results: a log is read back, with the same names.
    """
    import pyarrow as pa
    from pyarrow import csv

    names = {name for column in columns.values() if column.dtype == object for name in column.tolist()}
    special = any(STRUCTURE.search(name) for name in names)
    options = csv.WriteOptions(include_header=False, quoting_style="needed" if special else "none")
    with path.open("wb") as stream:
        stream.write((",".join(columns) + "\n").encode())
        csv.write_csv(pa.table({name: pa.array(column) for name, column in columns.items()}), stream, options)


def _names(log: JointLog) -> list[str]:
    """Return the joints' names, each in one line: readers of such tables go by lines."""
    return [" ".join(name.splitlines()) for name in log.joint_names]


def _joint_state(log: JointLog, name: str) -> dict[str, ColumnOf]:
    """Return the columns of a JointState, named by a pattern."""
    return joint_columns(
        log, lambda channel, joint: name.format(field=JOINT_STATE_FIELDS[channel], joint=joint), JOINT_STATE_CHANNELS
    )


def _constant(word: str, rows: int) -> NDArray[np.object_]:
    return np.full(rows, word, dtype=object)


CSV = Writer(
    name="csv",
    suffix=".csv",
    write=write_tidy,
    summary="tidy CSV, one column per channel and joint; every channel, to the bit, without the joints' names",
)
CSV_LONG = Writer(
    name="csv-long",
    suffix=".csv",
    write=write_long,
    summary="one row per time and joint: time, joint, position, velocity, effort",
    holds=JOINT_STATE_CHANNELS,
    needs=("tau_J",),
)
CSV_ROSTOPIC = Writer(
    name="csv-rostopic",
    suffix=".csv",
    write=write_rostopic,
    summary="as rostopic echo -p prints a sensor_msgs/JointState",
    holds=JOINT_STATE_CHANNELS,
    needs=("tau_J",),
)
CSV_BAG = Writer(
    name="csv-bag",
    suffix=".csv",
    write=write_bag_export,
    summary="as bag-to-CSV scripts write a sensor_msgs/JointState: position.0, velocity.0, effort.0",
    holds=JOINT_STATE_CHANNELS,
    needs=("tau_J",),
)
