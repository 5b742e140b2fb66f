"""Channels of messages -> MCAP file."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.io.writers.ros_messages import (
    FRANKA_ROBOT_STATE,
    FRANKA_ROBOT_STATE_FLAT,
    FRANKA_STATE,
    JOINT_STATE,
    JOINT_STATE_ROS1,
    MessageType,
    encode,
    load_types,
)
from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    from mcap.writer import Writer as McapWriter


@dataclass(frozen=True, kw_only=True, slots=True)
class Channel:
    """The channel and how its messages are written.

    Attributes:
        topic: Topic.
        schema: Name of the schema.
        schema_encoding: Language of the schema.
        schema_data: The schema.
        encoding: Encoding of the messages.
        profile: Profile of the file.
        notes: What else is said of the channel.
    """

    topic: str
    schema: str
    schema_encoding: str
    schema_data: bytes
    encoding: str
    profile: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)


def write_mcap(path: Path, channel: Channel, messages: Iterable[tuple[int, bytes]]) -> None:
    """Write messages of one channel, given with their time [ns], in chunks compressed with zstd."""
    write_channels(path, (channel,), ((time, 0, payload) for time, payload in messages))


def write_channels(path: Path, channels: Sequence[Channel], messages: Iterable[tuple[int, int, bytes]]) -> None:
    """Write messages, given with their time [ns] and the place of their channel, in chunks compressed with zstd.

    Args:
        path: Where to.
        channels: The channels; those of one schema name share the schema. The first one's profile is the file's.
        messages: In the order of time, so that a viewer reads each chunk once.
    """
    from mcap.writer import Writer as McapWriter

    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile=channels[0].profile if channels else "", library="friction-audit")
        numbers = _register(writer, channels)
        sequence = [0] * len(channels)
        for time, place, payload in messages:
            writer.add_message(numbers[place], log_time=time, publish_time=time, data=payload, sequence=sequence[place])
            sequence[place] += 1
        writer.finish()  # type: ignore[no-untyped-call]


def _register(writer: "McapWriter", channels: Sequence[Channel]) -> list[int]:
    """Tell the file which channels there are; return their numbers in it."""
    schemas: dict[str, int] = {}
    for one in channels:
        if one.schema not in schemas:
            schemas[one.schema] = writer.register_schema(one.schema, one.schema_encoding, one.schema_data)
    return [writer.register_channel(one.topic, one.encoding, schemas[one.schema], dict(one.notes)) for one in channels]


def write_ros_mcap(log: JointLog, path: Path, message: MessageType) -> None:
    """Write one topic of ROS 1 or ROS 2 messages with their definition."""
    types = load_types(message)
    ros1 = message.ros == 1
    definition, _ = types.generate_msgdef(message.name, ros_version=1 if ros1 else 2)
    channel = Channel(
        topic=message.topic,
        schema=message.name.replace("/msg/", "/") if ros1 else message.name,
        schema_encoding="ros1msg" if ros1 else "ros2msg",
        schema_data=definition.encode(),
        encoding="ros1" if ros1 else "cdr",
        profile="ros1" if ros1 else "ros2",
    )
    write_mcap(path, channel, encode(log, message, types))


def _writer(name: str, message: MessageType, summary: str, *, joints: int | None = 7) -> Writer:
    return Writer(
        name=name,
        suffix=".mcap",
        write=lambda log, path: write_ros_mcap(log, path, message),
        summary=summary,
        holds=tuple(message.fields.values()),
        needs=("tau_J",),
        joints=joints,
    )


MCAP = _writer("mcap", JOINT_STATE, "MCAP of sensor_msgs/msg/JointState (ROS 2)", joints=None)
MCAP_ROS1 = _writer("mcap-ros1", JOINT_STATE_ROS1, "MCAP of sensor_msgs/JointState (ROS 1)", joints=None)
MCAP_FRANKA_ROBOT_STATE = _writer(
    "mcap-franka-robot-state",
    FRANKA_ROBOT_STATE,
    "MCAP of franka_msgs/msg/FrankaRobotState, nested (franka_ros2 from v0.1.10)",
    joints=None,
)
MCAP_FRANKA_ROBOT_STATE_FLAT = _writer(
    "mcap-franka-robot-state-flat",
    FRANKA_ROBOT_STATE_FLAT,
    "MCAP of franka_msgs/msg/FrankaRobotState, flat (franka_ros2 up to v0.1.9)",
)
MCAP_FRANKA_STATE = _writer(
    "mcap-franka-state", FRANKA_STATE, "MCAP of franka_msgs/msg/FrankaState, lower case (multipanda_ros2)"
)
