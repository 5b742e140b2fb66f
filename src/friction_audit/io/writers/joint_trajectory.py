"""A trajectory of joints -> CSV, and a trajectory_msgs/msg/JointTrajectory message in MCAP."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.io.writers.mcap import ros_channel, write_channels
from friction_audit.io.writers.ros_messages import MessageType, load_types
from friction_audit.io.writers.tables import NANOSECONDS, UNKNOWN_START_NS
from friction_audit.joint_log import Float

MESSAGE = MessageType(
    name="trajectory_msgs/msg/JointTrajectory",
    topic="/joint_trajectory_controller/joint_trajectory",  # of ros2_control
    ros=2,
    fields={},
    definitions={},
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
