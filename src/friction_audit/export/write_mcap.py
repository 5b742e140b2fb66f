"""JointLog -> MCAP with ROS messages."""

from pathlib import Path

from friction_audit.export.mcap_file import Channel, write_mcap
from friction_audit.export.ros_messages import encode
from friction_audit.export.ros_types import (
    FRANKA_ROBOT_STATE,
    FRANKA_ROBOT_STATE_FLAT,
    FRANKA_STATE,
    JOINT_STATE,
    JOINT_STATE_ROS1,
    MessageType,
    load_types,
)
from friction_audit.export.writer import Writer
from friction_audit.joint_log import JointLog


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
