"""Which message fields are which channel: the table of joint state messages.

A definition is matched by its fields, not by its type's name: any message that has the fields of a row is readable.
Field names are compared without regard to case, since ROS 2 forced lower case on libfranka's names.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageKind:
    """One family of joint state messages.

    Attributes:
        rank: Preference when a file holds several; the smallest wins.
        fields: Channel -> dotted path of its array.
        required: Channels of which a definition must have all.
        names: Path of the joint names, if the message carries them.
        robot_time: Path of the robot's own clock. [s]
        stamps: Paths of the source's time stamp, the first one present is taken.
        elements: Path of a list with one entry per joint; the other paths then lie within an entry.
    """

    rank: int
    fields: Mapping[str, str]
    required: tuple[str, ...]
    names: str | None = None
    robot_time: str | None = None
    stamps: tuple[str, ...] = ("header.stamp",)
    elements: str | None = None


KINDS: tuple[MessageKind, ...] = (
    # nested FrankaRobotState
    MessageKind(
        rank=0,
        fields={
            "q": "measured_joint_state.position",
            "dq": "measured_joint_state.velocity",
            "tau_J": "measured_joint_state.effort",
            "tau_J_d": "desired_joint_state.effort",
            "tau_ext_hat_filtered": "tau_ext_hat_filtered.effort",
        },
        required=("q", "dq", "tau_J"),
        names="measured_joint_state.name",
        robot_time="time",
    ),
    # FrankaState
    MessageKind(
        rank=0,
        fields={
            "q": "q",
            "dq": "dq",
            "tau_J": "tau_J",
            "tau_J_d": "tau_J_d",
            "tau_ext_hat_filtered": "tau_ext_hat_filtered",
            "gravity": "gravity",
            "tau_interaction": "tau_interaction",
            "tau_compensation": "tau_compensation",
            "tau_passivity": "tau_passivity",
            "temperature": "temperature",
        },
        required=("q", "dq"),
        names="name",
        robot_time="time",
        stamps=("header.stamp", "stamp"),
    ),
    # JointState
    MessageKind(
        rank=1,
        fields={"q": "position", "dq": "velocity", "tau_J": "effort"},
        required=("q", "dq", "tau_J"),
        names="name",
        stamps=("header.stamp", "timestamp", "stamp"),
    ),
    # foxglove JointStates
    MessageKind(
        rank=1,
        fields={"q": "position", "dq": "velocity", "tau_J": "effort"},
        required=(),
        names="name",
        stamps=("timestamp",),
        elements="joints",
    ),
)
"""In the order in which a definition is tried."""


def match_kind(paths: Iterable[str]) -> MessageKind | None:
    """Find the kind that a message with these fields belongs to, its paths spelled as the message spells them.

    Args:
        paths: Dotted paths of all fields of the message, lists of entries included.
    """
    spelled = {path.lower(): path for path in paths}
    for kind in KINDS:
        wanted = (kind.elements,) if kind.elements else tuple(kind.fields[channel] for channel in kind.required)
        if all(path.lower() in spelled for path in wanted):
            return kind if kind.elements else _spell(kind, spelled)
    return None


def _spell(kind: MessageKind, spelled: Mapping[str, str]) -> MessageKind:
    fields = {channel: spelled[path.lower()] for channel, path in kind.fields.items() if path.lower() in spelled}
    return replace(
        kind,
        fields=fields,
        names=spelled.get((kind.names or "").lower()),
        robot_time=spelled.get((kind.robot_time or "").lower()),
        stamps=tuple(spelled[path] for path in kind.stamps if path in spelled),
    )
