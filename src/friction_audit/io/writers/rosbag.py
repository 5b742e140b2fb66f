"""JointLog -> ROS 1 bag."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Literal

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


def write_rosbag2(log: JointLog, path: Path, message: MessageType, storage: Literal["SQLITE3", "MCAP"]) -> None:
    """Write a bag directory with one topic."""
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Rosbag2Writer

    types = load_types(message)
    with Rosbag2Writer(path, version=8, storage_plugin=StoragePlugin[storage]) as bag:
        connection = bag.add_connection(message.topic, message.name, typestore=types)
        for time, payload in encode(log, message, types):
            bag.write(connection, time, payload)


def write_humble_db3(log: JointLog, path: Path, message: MessageType) -> None:
    """Write the storage file alone, without definitions of its messages, as ROS 2 Humble and older recorded it."""
    folder = path.with_name(f"{path.stem}_bag")
    write_rosbag2(log, folder, message, "SQLITE3")
    (storage,) = folder.glob("*.db3")
    with closing(sqlite3.connect(storage)) as database, database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3, ros_distro = 'humble'")
    storage.replace(path)
    shutil.rmtree(folder)


ROSBAG2_SQLITE3 = Writer(
    name="rosbag2-sqlite3",
    suffix="",
    write=lambda log, path: write_rosbag2(log, path, JOINT_STATE, "SQLITE3"),
    summary="ROS 2 bag directory of sensor_msgs/JointState, sqlite3 storage",
    holds=tuple(JOINT_STATE.fields.values()),
    needs=("tau_J",),
)
ROSBAG2_MCAP = Writer(
    name="rosbag2-mcap",
    suffix="",
    write=lambda log, path: write_rosbag2(log, path, JOINT_STATE, "MCAP"),
    summary="ROS 2 bag directory of sensor_msgs/JointState, MCAP storage",
    holds=tuple(JOINT_STATE.fields.values()),
    needs=("tau_J",),
)
ROSBAG2_DB3_FRANKA_STATE = Writer(
    name="rosbag2-db3-franka-state",
    suffix=".db3",
    write=lambda log, path: write_humble_db3(log, path, FRANKA_STATE),
    summary="single sqlite3 file of franka_msgs/msg/FrankaState (multipanda_ros2), without definitions",
    holds=tuple(FRANKA_STATE.fields.values()),
    needs=("tau_J",),
    joints=7,
)
ROSBAG2_DB3 = Writer(
    name="rosbag2-db3",
    suffix=".db3",
    write=lambda log, path: write_humble_db3(log, path, JOINT_STATE),
    summary="single sqlite3 file of sensor_msgs/JointState, without definitions, as Humble records",
    holds=tuple(JOINT_STATE.fields.values()),
    needs=("tau_J",),
)
