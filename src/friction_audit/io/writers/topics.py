"""TidyTables and trajectories -> MCAP; of tables a topic per table and joint: JSON messages with their schema."""

import heapq
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.errors import encodable
from friction_audit.io.writers.mcap import Channel, ros_channel, write_channels
from friction_audit.io.writers.ros_messages import MessageType, load_types
from friction_audit.io.writers.tables import NANOSECONDS, UNKNOWN_START_NS, JointRows, TidyTable
from friction_audit.joint_log import Float, JointLog

_BLOCK = 8192  # rows that are turned into messages at once
_JSON_TYPES = {str: "string", int: "integer", float: "number", bool: "boolean"}


def write_topics(tables: Sequence[TidyTable], log: JointLog, path: Path) -> None:
    """Write every table, a topic per joint, in the order of time; a part of a log has the stamps that it has there."""
    own = [(table, rows) for table in tables for rows in table.rows if len(rows)]
    streams = [_messages(table, rows, log, place) for place, (table, rows) in enumerate(own)]
    write_channels(path, [_channel(*one) for one in own], heapq.merge(*streams))


def _channel(table: TidyTable, rows: JointRows) -> Channel:
    """Return the topic of a table's rows of one joint; a number that there is not is left out of the message."""
    title, properties = f"friction_audit.{table.name}", {n: {"type": _JSON_TYPES[k]} for n, k in table.types.items()}
    schema = {"title": title, "description": table.summary, "type": "object", "properties": properties}
    topic, notes = f"/friction_audit/joint_{rows.joint}/{table.name}", {"joint": str(rows.joint)}
    notes["joint_name"] = encodable(rows.name)
    return Channel(topic, title, "jsonschema", json.dumps(schema).encode(), "json", notes=notes)


def _messages(table: TidyTable, rows: JointRows, log: JointLog, place: int) -> Iterator[tuple[int, int, bytes]]:
    """Yield time [ns], place of the channel and message of every row; no stamp lies outside the log."""
    begun, skipped_s = log.source.start_s, log.source.skipped_s
    start_ns = round((UNKNOWN_START_NS / NANOSECONDS + skipped_s if begun is None else begun) * NANOSECONDS)
    for first in range(0, len(rows), _BLOCK):
        part = slice(first, first + _BLOCK)
        cells = [rows.columns[name][part] for name in table.types]
        last = np.full(len(cells[0]), log.duration_s)
        moments = last if table.time is None else np.asarray(rows.columns[table.time][part], dtype=np.float64)
        stamps = start_ns + np.rint(np.clip(moments, 0.0, log.duration_s) * NANOSECONDS).astype(np.int64)
        for stamp, row in zip(stamps.tolist(), zip(*cells, strict=True), strict=True):
            named = {
                name: kind(value)
                for (name, kind), value in zip(table.types.items(), row, strict=True)
                if value is not None and (kind is not float or math.isfinite(value))
            }
            yield stamp, place, json.dumps(named, separators=(",", ":")).encode()


MESSAGE = MessageType(
    name="trajectory_msgs/msg/JointTrajectory",
    topic="/joint_trajectory_controller/joint_trajectory",  # of ros2_control
    ros=2,
    fields={},
)


class Trajectory(NamedTuple):
    """A trajectory of n points and j joints."""

    names: tuple[str, ...]  # of the joints
    t: Float  # time from the start, shape (n,) [s]
    q: Float  # position, shape (n, j) [rad]
    dq: Float  # velocity [rad/s]
    ddq: Float  # acceleration [rad/s^2]


def write_csv(trajectory: Trajectory, path: Path) -> None:
    """Write a row per point: time_s, then q, dq and ddq of every joint."""
    heads = ["time_s", *(f"{quantity}_{name}" for quantity in ("q", "dq", "ddq") for name in trajectory.names)]
    rows = np.column_stack(trajectory[1:])
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=",".join(heads), comments="", encoding="utf-8")


def write_mcap(trajectory: Trajectory, path: Path) -> None:
    """Write the whole trajectory as one message, as ROS 2 records it."""
    store = load_types(MESSAGE)
    types: Any = store.types
    time, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    none, moments = np.zeros(0), np.rint(trajectory.t * NANOSECONDS).astype(np.int64)
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=q,
            velocities=dq,
            accelerations=ddq,
            effort=none,
            time_from_start=duration(*map(int, divmod(moment, NANOSECONDS))),
        )
        for moment, q, dq, ddq in zip(moments, *trajectory[2:], strict=True)
    ]
    header = types["std_msgs/msg/Header"](stamp=time(sec=0, nanosec=0), frame_id="")
    message = types[MESSAGE.name](header=header, joint_names=list(trajectory.names), points=points)
    payload = bytes(store.serialize_cdr(message, MESSAGE.name))
    write_channels(path, (ros_channel(MESSAGE, store),), [(UNKNOWN_START_NS, 0, payload)])
