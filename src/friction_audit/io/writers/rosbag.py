"""JointLog -> ROS 1 and ROS 2 bags, by rosbags."""

import shutil
import sqlite3
from contextlib import closing
from functools import partial
from pathlib import Path

from friction_audit.io.writers.ros_messages import (
    FRANKA_STATE,
    FRANKA_STATE_ROS1,
    JOINT_STATE,
    JOINT_STATE_ROS1,
    MessageType,
    encode,
    load_types,
)
from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog


def _write_rosbag1(message: MessageType, log: JointLog, path: Path, *, lz4: bool = False) -> None:
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


def _write_rosbag2(message: MessageType, log: JointLog, path: Path, *, storage: str = "SQLITE3") -> None:
    """Write a bag directory with one topic."""
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Rosbag2Writer

    types = load_types(message)
    with Rosbag2Writer(path, version=8, storage_plugin=StoragePlugin[storage]) as bag:
        connection = bag.add_connection(message.topic, message.name, typestore=types)
        for time, payload in encode(log, message, types):
            bag.write(connection, time, payload)


def _write_humble_db3(message: MessageType, log: JointLog, path: Path) -> None:
    """Write the storage file alone, without definitions of its messages, as ROS 2 Humble and older recorded it."""
    folder = path.with_name(f"{path.stem}_bag")
    _write_rosbag2(message, log, folder)
    (storage,) = folder.glob("*.db3")
    with closing(sqlite3.connect(storage)) as database, database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3, ros_distro = 'humble'")
    storage.replace(path)
    shutil.rmtree(folder)


BAGS = tuple(
    Writer(
        name=name,
        suffix=suffix,
        write=partial(write, message),
        summary=summary,
        holds=message.holds,
        joints=message.joints,
    )
    for name, suffix, write, message, summary in (
        ("rosbag1-joint-state", ".bag", _write_rosbag1, JOINT_STATE_ROS1, "ROS 1 bag of sensor_msgs/JointState"),
        ("rosbag1-franka-state", ".bag", partial(_write_rosbag1, lz4=True), FRANKA_STATE_ROS1,
         "ROS 1 bag of franka_msgs/FrankaState (franka_ros 0.10), lz4"),
        ("rosbag2-sqlite3", "", _write_rosbag2, JOINT_STATE,
         "ROS 2 bag directory of sensor_msgs/JointState, sqlite3 storage"),
        ("rosbag2-mcap", "", partial(_write_rosbag2, storage="MCAP"), JOINT_STATE,
         "ROS 2 bag directory of sensor_msgs/JointState, MCAP storage"),
        ("rosbag2-db3", ".db3", _write_humble_db3, JOINT_STATE,
         "single sqlite3 file of sensor_msgs/JointState, without definitions, as Humble records"),
        ("rosbag2-db3-franka-state", ".db3", _write_humble_db3, FRANKA_STATE,
         "single sqlite3 file of franka_msgs/msg/FrankaState (multipanda_ros2), without definitions"),
    )
)  # fmt: skip
