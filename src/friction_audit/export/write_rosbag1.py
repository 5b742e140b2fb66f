"""JointLog -> ROS 1 bag."""

from pathlib import Path

from friction_audit.export.ros_messages import encode
from friction_audit.export.ros_types import FRANKA_STATE_ROS1, JOINT_STATE_ROS1, MessageType, load_types
from friction_audit.export.writer import Writer
from friction_audit.joint_log import JointLog


def write_rosbag1(log: JointLog, path: Path, message: MessageType, *, lz4: bool = False) -> None:
    """Write one topic; ``lz4`` compresses, as ``rosbag record --lz4`` does."""
    from rosbags.rosbag1 import Writer as Rosbag1Writer

    types = load_types(message)
    bag = Rosbag1Writer(path)
    if lz4:
        bag.set_compression(Rosbag1Writer.CompressionFormat.LZ4)
    with bag:
        connection = bag.add_connection(message.topic, message.name, typestore=types)
        for time, payload in encode(log, message, types):
            bag.write(connection, time, payload)


ROSBAG1_JOINT_STATE = Writer(
    name="rosbag1-joint-state",
    suffix=".bag",
    write=lambda log, path: write_rosbag1(log, path, JOINT_STATE_ROS1),
    summary="ROS 1 bag of sensor_msgs/JointState",
    holds=tuple(JOINT_STATE_ROS1.fields.values()),
    needs=("tau_J",),
)
ROSBAG1_FRANKA_STATE = Writer(
    name="rosbag1-franka-state",
    suffix=".bag",
    write=lambda log, path: write_rosbag1(log, path, FRANKA_STATE_ROS1, lz4=True),
    summary="ROS 1 bag of franka_msgs/FrankaState (franka_ros 0.10), lz4",
    holds=tuple(FRANKA_STATE_ROS1.fields.values()),
    needs=("tau_J",),
    joints=7,
)
