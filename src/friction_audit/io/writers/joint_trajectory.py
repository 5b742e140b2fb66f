"""A trajectory of joints -> CSV, and a trajectory_msgs/msg/JointTrajectory message in MCAP."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.io.writers.mcap import Channel, write_channels
from friction_audit.io.writers.tables import NANOSECONDS, UNKNOWN_START_NS
from friction_audit.joint_log import Float

MESSAGE = "trajectory_msgs/msg/JointTrajectory"
TOPIC = "/joint_trajectory_controller/joint_trajectory"  # of ros2_control


class Trajectory(NamedTuple):
    """A trajectory of n points and j joints."""

    names: tuple[str, ...]  # of the joints
    t: Float  # time from the start, shape (n,) [s]
    q: Float  # position, shape (n, j) [rad]
    dq: Float  # velocity [rad/s]
    ddq: Float  # acceleration [rad/s^2]


def write_csv(trajectory: Trajectory, path: Path) -> None:
    """Write a row per point: time_s, then q, dq and ddq of every joint."""
    heads = [f"{quantity}_{name}" for quantity in ("q", "dq", "ddq") for name in trajectory.names]
    rows = np.column_stack([trajectory.t, trajectory.q, trajectory.dq, trajectory.ddq])
    np.savetxt(
        path, rows, fmt="%.9g", delimiter=",", header=",".join(["time_s", *heads]), comments="", encoding="utf-8"
    )


def write_mcap(trajectory: Trajectory, path: Path) -> None:
    """Write the whole trajectory as one message, as ROS 2 records it."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types: Any = store.types
    time, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    none, moments = np.zeros(0), np.rint(trajectory.t * NANOSECONDS).astype(np.int64)
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=q,
            velocities=dq,
            accelerations=ddq,
            effort=none,
            time_from_start=duration(sec=int(moment // NANOSECONDS), nanosec=int(moment % NANOSECONDS)),
        )
        for moment, q, dq, ddq in zip(moments, trajectory.q, trajectory.dq, trajectory.ddq, strict=True)
    ]
    header = types["std_msgs/msg/Header"](stamp=time(sec=0, nanosec=0), frame_id="")
    message = types[MESSAGE](header=header, joint_names=list(trajectory.names), points=points)
    definition, _ = store.generate_msgdef(MESSAGE, ros_version=2)
    channel = Channel(
        topic=TOPIC,
        schema=MESSAGE,
        schema_encoding="ros2msg",
        schema_data=definition.encode(),
        encoding="cdr",
        profile="ros2",
    )
    write_channels(path, (channel,), [(UNKNOWN_START_NS, 0, bytes(store.serialize_cdr(message, MESSAGE)))])
