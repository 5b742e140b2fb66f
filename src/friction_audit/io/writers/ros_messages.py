"""ROS messages of a log, serialised many at a time; bags of them by rosbags."""

import shutil
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from functools import partial, reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.joint_states import JOINT_STATE, ROBOT_STATE
from friction_audit.io.readers.message_decoder import find_layout, franka_types
from friction_audit.io.writers.tables import NANOSECONDS, Writer, logged_channels, stamps_ns
from friction_audit.joint_log import JointLog

_BLOCK = 4096  # messages made at once
Typestore = Any  # of rosbags, which takes long to import
ENCODINGS = {1: "ros1", 2: "cdr"}  # generation of ROS -> how its messages are serialised


class MessageType(NamedTuple):
    """A message type that holds joint states."""

    name: str  # name as ROS 2 spells it
    topic: str  # topic on which it is published
    ros: int  # 1 or 2
    fields: Mapping[str, str]  # channel -> path of its array
    names: tuple[str, ...] = ()  # paths of the lists of joint names
    robot_time: str | None = None  # path of the robot's own clock, or None
    joints: int | None = None  # number of joints that it holds, or None for any
    definitions: tuple[str, ...] = ()  # files in readers/franka_msgs/ of what ROS does not come with, its own at last


JOINT_STATE_ROS2 = MessageType(
    name="sensor_msgs/msg/JointState", topic="/joint_states", ros=2, fields=JOINT_STATE, names=("name",)
)
JOINT_STATE_ROS1 = JOINT_STATE_ROS2._replace(ros=1)
FRANKA_STATE_ROS1 = MessageType(  # franka_ros 0.10
    name="franka_msgs/msg/FrankaState",
    topic="/franka_state_controller/franka_states",
    ros=1,
    fields={name: name for name in ROBOT_STATE},
    robot_time="time",
    joints=7,
    definitions=("Errors_41", "FrankaState_ros1"),
)
FRANKA_STATE = FRANKA_STATE_ROS1._replace(  # multipanda_ros2, the fork for the Panda
    topic="/franka_robot_state_broadcaster/robot_state",
    ros=2,
    fields={name: name.lower() for name in ROBOT_STATE},
    definitions=("Errors_41", "FrankaState_multipanda"),
)
FRANKA_ROBOT_STATE_FLAT = FRANKA_STATE._replace(  # franka_ros2 up to v0.1.9
    name="franka_msgs/msg/FrankaRobotState", definitions=("Errors_36", "FrankaState_flat")
)
FRANKA_ROBOT_STATE = FRANKA_ROBOT_STATE_FLAT._replace(  # franka_ros2 from v0.1.10 on
    fields=ROBOT_STATE,
    names=("measured_joint_state.name", "desired_joint_state.name", "tau_ext_hat_filtered.name"),
    joints=None,
    definitions=("Errors_36", "CollisionIndicators", "Elbow", "FrankaRobotState_nested"),
)


def load_types(message: MessageType) -> Typestore:
    """Return the types that a message is made of."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if message.ros == 1 else Stores.ROS2_HUMBLE)
    store.register(franka_types(message.definitions, message.name))
    return store


def encode(log: JointLog, message: MessageType, types: Typestore) -> Iterator[tuple[int, bytes]]:
    """Yield (time [ns], serialised message) for every sample; a channel that was not recorded is NaN or empty.

    One message is serialised by rosbags; the numbers of each sample are written into copies of its bytes.
    """
    if not log.t.size:
        return
    sample, recorded = _blank(types, (2, message.name)), logged_channels(log)
    arrays: dict[str, NDArray[Any]] = {path: recorded[c] for c, path in message.fields.items() if c in recorded}
    filled: dict[str, Any] = {path: list(log.joint_names) for path in message.names}
    filled |= {path: np.ascontiguousarray(array[0]) for path, array in arrays.items()}
    for path, value in filled.items():
        *parents, name = path.split(".")
        setattr(reduce(getattr, parents, sample), name, value)
    serialise = types.serialize_ros1 if message.ros == 1 else types.serialize_cdr
    form = bytes(serialise(sample, message.name))
    places = find_layout(form, message.name, types.fielddefs, encoding=ENCODINGS[message.ros]).numbers
    if message.robot_time is not None:
        arrays[message.robot_time] = log.t[:, np.newaxis]
    stamps = stamps_ns(log)
    arrays["header.stamp.sec"] = np.column_stack(np.divmod(stamps, NANOSECONDS)).astype("<u4")  # and nanosec after it
    for begin in range(0, len(stamps), _BLOCK):
        rows = slice(begin, begin + _BLOCK)
        copies = np.repeat(np.frombuffer(form, np.uint8)[np.newaxis], len(stamps[rows]), axis=0)
        for path, array in arrays.items():
            data, place = np.ascontiguousarray(array[rows]).view(np.uint8), places[path][1]
            copies[:, place : place + data.shape[1]] = data
        payloads = copies.tobytes()
        for row, stamp in enumerate(stamps[rows].tolist()):
            yield stamp, payloads[row * len(form) : (row + 1) * len(form)]


def _blank(types: Typestore, kind: Any) -> Any:  # noqa: ANN401
    """Return a field, or a message, that says nothing: numbers NaN or 0, lists empty."""
    from rosbags.interfaces import Nodetype

    node, detail = kind
    if node == Nodetype.NAME:
        return types.types[detail](**{name: _blank(types, inner) for name, inner in types.fielddefs[detail][1]})
    if node == Nodetype.BASE:
        return {"s": "", "f": float("nan")}.get(detail[0][0], 0)  # string, float32 and float64
    (element, (base, *_)), length = detail
    size = length if node == Nodetype.ARRAY else 0
    if element == Nodetype.NAME or base == "string":
        return [_blank(types, detail[0]) for _ in range(size)]
    return np.full(size, _blank(types, detail[0]), dtype=base)


def _write_bag(message: MessageType, log: JointLog, path: Path, *, storage: str = "SQLITE3", lz4: bool = False) -> None:
    """Write one topic: a ROS 1 bag, compressed as ``rosbag record --lz4`` does, or the directory of a ROS 2 bag."""
    from rosbags import rosbag1, rosbag2

    types = load_types(message)
    bag: Any
    if message.ros == 1:
        bag = rosbag1.Writer(path)
        if lz4:
            bag.set_compression(rosbag1.Writer.CompressionFormat.LZ4)
    else:
        bag = rosbag2.Writer(path, version=8, storage_plugin=rosbag2.StoragePlugin[storage])
    with bag:
        connection = bag.add_connection(message.topic, message.name, typestore=types)
        for time, payload in encode(log, message, types):
            bag.write(connection, time, payload)


def _write_humble_db3(message: MessageType, log: JointLog, path: Path) -> None:
    """Write the storage file alone, without definitions of its messages, as ROS 2 Humble and older recorded it."""
    folder = path.with_name(f"{path.stem}_bag")
    _write_bag(message, log, folder)
    (storage,) = folder.glob("*.db3")
    with closing(sqlite3.connect(storage)) as database, database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3, ros_distro = 'humble'")
    storage.replace(path)
    shutil.rmtree(folder)


def ros_writer(
    name: str, suffix: str, write: Callable[[MessageType, JointLog, Path], None], message: MessageType, summary: str
) -> Writer:
    """Return what writes a log as messages of one type."""
    return Writer(name, suffix, partial(write, message), summary, holds=tuple(message.fields), joints=message.joints)


BAGS = (
    ros_writer("rosbag1-joint-state", ".bag", _write_bag, JOINT_STATE_ROS1, "ROS 1 bag of sensor_msgs/JointState"),
    ros_writer("rosbag1-franka-state", ".bag", partial(_write_bag, lz4=True), FRANKA_STATE_ROS1,
               "ROS 1 bag of franka_msgs/FrankaState (franka_ros 0.10), lz4"),
    ros_writer("rosbag2-sqlite3", "", _write_bag, JOINT_STATE_ROS2,
               "ROS 2 bag directory of sensor_msgs/JointState, sqlite3 storage"),
    ros_writer("rosbag2-mcap", "", partial(_write_bag, storage="MCAP"), JOINT_STATE_ROS2,
               "ROS 2 bag directory of sensor_msgs/JointState, MCAP storage"),
    ros_writer("rosbag2-db3", ".db3", _write_humble_db3, JOINT_STATE_ROS2,
               "single sqlite3 file of sensor_msgs/JointState, without definitions, as Humble records"),
    ros_writer("rosbag2-db3-franka-state", ".db3", _write_humble_db3, FRANKA_STATE,
               "single sqlite3 file of franka_msgs/msg/FrankaState (multipanda_ros2), without definitions"),
)  # fmt: skip
