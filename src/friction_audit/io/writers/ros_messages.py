"""ROS message types: the standard ones, and the generations of franka_msgs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.writers.tables import NANOSECONDS, stamps_ns
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


_OWN = "io/writers/franka_msgs"
_SHARED = "io/readers/franka_msgs"
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


BLOCK = 4096
"""Messages made at once."""

STAMP = np.array([0x12345678, 0x0BADF00D], dtype="<u4")
"""Seconds and nanoseconds that mark the place of the stamp in a serialised message."""

MARK = 7.654321e-210
"""Unlikely number; its multiples mark the places of the arrays."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Form:
    """A serialised message whose numbers are to be filled in.

    Attributes:
        payload: The bytes, shape (size,).
        arrays: Channel -> byte at which its array begins.
        stamp: Byte at which the header's stamp begins.
        robot_time: Byte of the robot's clock, or None.
    """

    payload: NDArray[np.uint8]
    arrays: dict[str, int]
    stamp: int
    robot_time: int | None


def encode(log: JointLog, message: MessageType, types: "Typestore") -> Iterator[tuple[int, bytes]]:
    """Yield (time [ns], serialised message) for every sample; a channel that was not recorded is NaN or empty."""
    form = _make_form(log, message, types)
    stamps = stamps_ns(log)
    for first in range(0, len(stamps), BLOCK):
        rows = slice(first, first + BLOCK)
        filled = _fill(form, log, stamps[rows], rows).tobytes()
        size = len(form.payload)
        for row, stamp in enumerate(stamps[rows].tolist()):
            yield stamp, filled[row * size : (row + 1) * size]


def _fill(form: Form, log: JointLog, stamps: NDArray[np.int64], rows: slice) -> NDArray[np.uint8]:
    """Return copies of the form with the numbers of some samples, shape (m, size)."""
    copies = np.repeat(form.payload[np.newaxis], len(stamps), axis=0)
    clock = np.column_stack(np.divmod(stamps, NANOSECONDS)).astype("<u4")
    _put(copies, form.stamp, clock)
    if form.robot_time is not None:
        _put(copies, form.robot_time, log.t[rows, np.newaxis])
    channels = log.channels()
    for name, place in form.arrays.items():
        _put(copies, place, channels[name][rows])
    return copies


def _put(copies: NDArray[np.uint8], place: int, numbers: NDArray[Any]) -> None:
    """Write rows of numbers into the copies, from a byte on."""
    data = np.ascontiguousarray(numbers).view(np.uint8)
    copies[:, place : place + data.shape[1]] = data


def _make_form(log: JointLog, message: MessageType, types: "Typestore") -> Form:
    """Serialise a message full of marks and find them in its bytes."""
    recorded = log.channels()
    sample = _blank(types, message.name)
    sample.header.stamp = types.types["builtin_interfaces/msg/Time"](sec=int(STAMP[0]), nanosec=int(STAMP[1]))
    for path in message.names:
        _set(sample, path, list(log.joint_names))
    marks = {name: MARK * (np.arange(len(log.joint_names)) + 100.0 * k) for k, name in enumerate(recorded, start=1)}
    for path, name in message.fields.items():
        if name in recorded:
            _set(sample, path, marks[name])
    if message.robot_time is not None:
        _set(sample, message.robot_time, MARK)
    serialise = types.serialize_ros1 if message.ros == 1 else types.serialize_cdr
    payload = bytes(serialise(sample, message.name))
    return Form(
        payload=np.frombuffer(payload, dtype=np.uint8),
        arrays={name: payload.index(marks[name].tobytes()) for name in message.fields.values() if name in recorded},
        stamp=payload.index(STAMP.tobytes()),
        robot_time=None if message.robot_time is None else payload.index(np.float64(MARK).tobytes()),
    )


def _set(sample: Any, path: str, value: object) -> None:  # noqa: ANN401
    """Set a field given by its dotted path."""
    *parents, name = path.split(".")
    for parent in parents:
        sample = getattr(sample, parent)
    setattr(sample, name, value)


def _blank(types: "Typestore", name: str) -> Any:  # noqa: ANN401
    """Return a message that says nothing: numbers NaN or 0, lists empty."""
    _, fields = types.fielddefs[name]
    return types.types[name](**{field: _blank_field(types, kind) for field, kind in fields})


def _blank_field(types: "Typestore", kind: Any) -> Any:  # noqa: ANN401
    from rosbags.interfaces import Nodetype

    node, detail = kind
    if node == Nodetype.NAME:
        return _blank(types, detail)
    if node == Nodetype.BASE:
        return _blank_base(detail[0])
    (element, (base, *_)), length = detail
    if element == Nodetype.NAME or base == "string":
        return [_blank_field(types, detail[0]) for _ in range(length if node == Nodetype.ARRAY else 0)]
    return np.full(length if node == Nodetype.ARRAY else 0, _blank_base(base), dtype=base)


def _blank_base(base: str) -> str | bool | int | float:
    if base == "string":
        return ""
    return float("nan") if base.startswith("float") else 0
