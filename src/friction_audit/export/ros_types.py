"""ROS message types: the standard ones, and the generations of franka_msgs."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_OWN = "export/franka_msgs"
_SHARED = "ingest/franka_msgs"
"""Data beside the readers, which know the wire layouts; their code is not touched."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageType:
    """A message type that holds joint states.

    Attributes:
        name: Name as ROS 2 spells it.
        topic: Topic on which it is published.
        ros: 1 or 2.
        fields: Path of an array -> channel.
        names: Paths of the lists of joint names.
        robot_time: Path of the robot's own clock, or None.
        definitions: Type -> file of its definition, for types that ROS does not come with.
    """

    name: str
    topic: str
    ros: int
    fields: Mapping[str, str]
    names: tuple[str, ...] = ()
    robot_time: str | None = None
    definitions: Mapping[str, str]


def load_types(message: MessageType) -> "Typestore":
    """Return the types that a message is made of."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if message.ros == 1 else Stores.ROS2_HUMBLE)
    for name, place in message.definitions.items():
        text = (files("friction_audit") / place).read_text(encoding="utf-8")
        store.register(get_types_from_msg(text, name))
    return store


def _joint_state(ros: int) -> MessageType:
    return MessageType(
        name="sensor_msgs/msg/JointState",
        topic="/joint_states",
        ros=ros,
        fields={"position": "q", "velocity": "dq", "effort": "tau_J"},
        names=("name",),
        definitions={},
    )


JOINT_STATE_ROS1 = _joint_state(1)
JOINT_STATE = _joint_state(2)

FRANKA_STATE_ROS1 = MessageType(
    name="franka_msgs/msg/FrankaState",
    topic="/franka_state_controller/franka_states",
    ros=1,
    fields={name: name for name in ("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered")},
    robot_time="time",
    definitions={
        "franka_msgs/msg/Errors": f"{_OWN}/Errors_41.msg",
        "franka_msgs/msg/FrankaState": f"{_OWN}/FrankaState_ros1.msg",
    },
)
"""franka_ros 0.10."""

_LOWER_CASE = {
    "q": "q",
    "dq": "dq",
    "tau_j": "tau_J",
    "tau_j_d": "tau_J_d",
    "tau_ext_hat_filtered": "tau_ext_hat_filtered",
}

FRANKA_STATE = MessageType(
    name="franka_msgs/msg/FrankaState",
    topic="/franka_robot_state_broadcaster/robot_state",
    ros=2,
    fields=_LOWER_CASE,
    robot_time="time",
    definitions={
        "franka_msgs/msg/Errors": f"{_OWN}/Errors_41.msg",
        "franka_msgs/msg/FrankaState": f"{_SHARED}/FrankaState_multipanda.msg",
    },
)
"""multipanda_ros2, the fork for the Panda."""

FRANKA_ROBOT_STATE_FLAT = MessageType(
    name="franka_msgs/msg/FrankaRobotState",
    topic="/franka_robot_state_broadcaster/robot_state",
    ros=2,
    fields=_LOWER_CASE,
    robot_time="time",
    definitions={
        "franka_msgs/msg/Errors": f"{_OWN}/Errors_36.msg",
        "franka_msgs/msg/FrankaRobotState": f"{_SHARED}/FrankaState_flat.msg",
    },
)
"""franka_ros2 up to v0.1.9."""

FRANKA_ROBOT_STATE = MessageType(
    name="franka_msgs/msg/FrankaRobotState",
    topic="/franka_robot_state_broadcaster/robot_state",
    ros=2,
    fields={
        "measured_joint_state.position": "q",
        "measured_joint_state.velocity": "dq",
        "measured_joint_state.effort": "tau_J",
        "desired_joint_state.effort": "tau_J_d",
        "tau_ext_hat_filtered.effort": "tau_ext_hat_filtered",
    },
    names=("measured_joint_state.name", "desired_joint_state.name", "tau_ext_hat_filtered.name"),
    robot_time="time",
    definitions={
        "franka_msgs/msg/Errors": f"{_OWN}/Errors_36.msg",
        "franka_msgs/msg/CollisionIndicators": f"{_SHARED}/CollisionIndicators.msg",
        "franka_msgs/msg/Elbow": f"{_SHARED}/Elbow.msg",
        "franka_msgs/msg/FrankaRobotState": f"{_SHARED}/FrankaRobotState_nested.msg",
    },
)
"""franka_ros2 from v0.1.10 on."""
