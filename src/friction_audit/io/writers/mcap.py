"""MCAP files: of a log as ROS 1, ROS 2 and foxglove.JointStates messages, of tables of results, of a trajectory."""

import heapq
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib.resources import files
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.errors import encodable
from friction_audit.io.readers.joint_states import JOINT_STATE
from friction_audit.io.writers import ros_messages as ros
from friction_audit.io.writers.tables import (
    NANOSECONDS,
    UNKNOWN_START_NS,
    JointRows,
    TidyTable,
    Trajectory,
    Writer,
    logged_channels,
    stamps_ns,
)
from friction_audit.joint_log import JointLog


class Channel(NamedTuple):
    """A channel, its schema, and how its messages are written."""

    topic: str
    schema: str  # its name
    schema_encoding: str
    schema_data: bytes
    encoding: str
    profile: str = ""  # of the file
    notes: Mapping[str, str] = {}


def write_channels(path: Path, channels: Sequence[Channel], messages: Iterable[tuple[int, int, bytes]]) -> None:
    """Write messages in the order of time: time [ns], place of the channel, payload; channels may share a schema."""
    from mcap.writer import Writer as McapWriter

    sequences = [count() for _ in channels]
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile=channels[0].profile if channels else "", library="friction-audit")
        found = {one.schema: (one.schema_encoding, one.schema_data) for one in channels}
        schemas = {name: writer.register_schema(name, *schema) for name, schema in found.items()}
        keys = [writer.register_channel(c.topic, c.encoding, schemas[c.schema], dict(c.notes)) for c in channels]
        for time, place, payload in messages:
            number = next(sequences[place])
            writer.add_message(keys[place], log_time=time, publish_time=time, data=payload, sequence=number)
        writer.finish()  # type: ignore[no-untyped-call]


def ros_channel(message: ros.MessageType, types: ros.Typestore) -> Channel:
    """Return the channel of a topic of ROS 1 or ROS 2 messages, with their definition."""
    definition, _ = types.generate_msgdef(message.name, ros_version=message.ros)
    name, profile = message.name.replace("/msg/", "/") if message.ros == 1 else message.name, f"ros{message.ros}"
    return Channel(message.topic, name, f"{profile}msg", definition.encode(), ros.ENCODINGS[message.ros], profile)


def _write_ros(message: ros.MessageType, log: JointLog, path: Path) -> None:
    types = ros.load_types(message)
    messages = ((time, 0, payload) for time, payload in ros.encode(log, message, types))
    write_channels(path, (ros_channel(message, types),), messages)


_SCHEMA = "foxglove.JointStates"
_DEFINITIONS = files("friction_audit.io.writers") / "foxglove"


def _descriptors() -> Any:  # noqa: ANN401 - a FileDescriptorSet
    """Return the schema as protobuf."""
    from google.protobuf import descriptor_pb2, text_format, timestamp_pb2

    found: Any = descriptor_pb2.FileDescriptorSet()
    timestamp_pb2.DESCRIPTOR.CopyToProto(found.file.add())
    return text_format.Merge((_DEFINITIONS / "JointStates.txtpb").read_text(encoding="utf-8"), found)


def _write_foxglove(log: JointLog, path: Path, *, encoding: str) -> None:
    """Write messages with their schema, in JSON or protobuf; numbers read back to the bit from either."""
    from google.protobuf.message_factory import GetMessages

    descriptors = _descriptors()
    joint_states: Any = GetMessages(descriptors.file)[_SCHEMA]
    is_json, logged = encoding == "json", logged_channels(log)
    fields = {name: field for name, field in JOINT_STATE.items() if name in logged}

    def messages() -> Iterator[tuple[int, int, bytes]]:
        for stamp, *rows in zip(stamps_ns(log).tolist(), *(logged[name] for name in fields), strict=True):
            numbers = zip(log.joint_names, *(row.tolist() for row in rows), strict=True)
            joints = [dict(zip(("name", *fields.values()), joint, strict=True)) for joint in numbers]
            sec, nsec = divmod(stamp, NANOSECONDS)
            if is_json:
                message = {"timestamp": {"sec": sec, "nsec": nsec}, "joints": joints}
                yield stamp, 0, json.dumps(message, separators=(",", ":")).encode()
            else:
                filled = joint_states(timestamp={"seconds": sec, "nanos": nsec}, joints=joints)
                yield stamp, 0, filled.SerializeToString()

    schema = descriptors.SerializeToString()
    if is_json:
        schema = json.dumps(json.loads((_DEFINITIONS / "JointStates.json").read_text(encoding="utf-8"))).encode()
    channel = Channel("/joint_states", _SCHEMA, "jsonschema" if is_json else encoding, schema, encoding)
    write_channels(path, (channel,), messages())


MCAP_DIALECTS = (
    ros.ros_writer("mcap", ".mcap", _write_ros, ros.JOINT_STATE_ROS2, "MCAP of sensor_msgs/msg/JointState (ROS 2)"),
    ros.ros_writer("mcap-franka-robot-state", ".mcap", _write_ros, ros.FRANKA_ROBOT_STATE,
               "MCAP of franka_msgs/msg/FrankaRobotState, nested (franka_ros2 from v0.1.10)"),
    ros.ros_writer("mcap-franka-robot-state-flat", ".mcap", _write_ros, ros.FRANKA_ROBOT_STATE_FLAT,
               "MCAP of franka_msgs/msg/FrankaRobotState, flat (franka_ros2 up to v0.1.9)"),
    ros.ros_writer("mcap-franka-state", ".mcap", _write_ros, ros.FRANKA_STATE,
               "MCAP of franka_msgs/msg/FrankaState, lower case (multipanda_ros2)"),
    ros.ros_writer("mcap-ros1", ".mcap", _write_ros, ros.JOINT_STATE_ROS1, "MCAP of sensor_msgs/JointState (ROS 1)"),
    Writer("mcap-json", ".mcap", partial(_write_foxglove, encoding="json"),
           "MCAP of foxglove.JointStates as JSON", holds=tuple(JOINT_STATE)),
    Writer("mcap-protobuf", ".mcap", partial(_write_foxglove, encoding="protobuf"),
           "MCAP of foxglove.JointStates as protobuf", holds=tuple(JOINT_STATE)),
)  # fmt: skip

_BLOCK = 8192  # rows that are turned into messages at once
_JSON_TYPES = {str: "string", int: "integer", float: "number", bool: "boolean"}


def write_topics(tables: Sequence[TidyTable], log: JointLog, path: Path) -> None:
    """Write every table, a topic per joint, in the order of time; a part of a log has the stamps that it has there."""
    channels, streams = list[Channel](), list[Iterator[tuple[int, int, bytes]]]()
    for table, rows in ((one, rows) for one in tables for rows in one.rows if len(rows)):
        title, types = f"friction_audit.{table.name}", {n: {"type": _JSON_TYPES[k]} for n, k in table.types.items()}
        schema = {"title": title, "description": table.summary, "type": "object", "properties": types}
        topic, notes = f"/friction_audit/joint_{rows.joint}/{table.name}", {"joint": str(rows.joint)}
        notes["joint_name"] = encodable(rows.name)
        streams.append(_messages(table, rows, log, len(channels)))
        channels.append(Channel(topic, title, "jsonschema", json.dumps(schema).encode(), "json", notes=notes))
    write_channels(path, channels, heapq.merge(*streams))


def _messages(table: TidyTable, rows: JointRows, log: JointLog, place: int) -> Iterator[tuple[int, int, bytes]]:
    """Yield time in the log [ns], place of the channel and message of every row, without missing numbers."""
    begun, skipped_s = log.source.start_s, log.source.skipped_s
    start_ns = round((UNKNOWN_START_NS / NANOSECONDS + skipped_s if begun is None else begun) * NANOSECONDS)
    for first in range(0, len(rows), _BLOCK):
        part = slice(first, first + _BLOCK)
        cells = [rows.columns[name][part] for name in table.types]
        last = np.full(len(cells[0]), log.duration_s)
        times = last if table.time is None else np.asarray(rows.columns[table.time][part], dtype=np.float64)
        stamps = start_ns + np.rint(np.clip(times, 0.0, log.duration_s) * NANOSECONDS).astype(np.int64)
        for stamp, row in zip(stamps.tolist(), zip(*cells, strict=True), strict=True):
            named = {
                name: kind(value)
                for (name, kind), value in zip(table.types.items(), row, strict=True)
                if value is not None and (kind is not float or math.isfinite(value))
            }
            yield stamp, place, json.dumps(named, separators=(",", ":")).encode()


_TRAJECTORY = ros.MessageType(
    name="trajectory_msgs/msg/JointTrajectory",
    topic="/joint_trajectory_controller/joint_trajectory",  # of ros2_control
    ros=2,
    fields={},
)


def write_trajectory(trajectory: Trajectory, path: Path) -> None:
    """Write the whole trajectory as one message, as ROS 2 records it."""
    store = ros.load_types(_TRAJECTORY)
    types: Any = store.types
    time, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    none, stamps = np.zeros(0), np.rint(trajectory.t * NANOSECONDS).astype(np.int64)
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=q,
            velocities=dq,
            accelerations=ddq,
            effort=none,
            time_from_start=duration(*map(int, divmod(stamp, NANOSECONDS))),
        )
        for stamp, q, dq, ddq in zip(stamps, *trajectory[2:], strict=True)
    ]
    header = types["std_msgs/msg/Header"](stamp=time(sec=0, nanosec=0), frame_id="")
    message = types[_TRAJECTORY.name](header=header, joint_names=list(trajectory.names), points=points)
    payload = bytes(store.serialize_cdr(message, _TRAJECTORY.name))
    write_channels(path, (ros_channel(_TRAJECTORY, store),), [(UNKNOWN_START_NS, 0, payload)])
