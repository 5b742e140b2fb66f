"""The one table of foreign names: what a column or a field may be called, and which channel that is."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from friction_audit.io.readers.joint_names import is_finger

# Channel -> names in use, lower case, the best first.
ALIASES: dict[str, tuple[str, ...]] = {
    "q": ("q", "actual_q", "joint_positions", "joint_position", "positions", "position", "joint_pos", "pos",
          "joint_angles", "joint_angle", "angle"),
    "dq": ("dq", "actual_qd", "qdot", "q_dot", "joint_velocities", "joint_velocity", "velocities", "velocity",
           "joint_vel", "vel"),
    "tau_J": ("tau_j", "motor_torques_measured", "tau_measured", "joint_torques", "joint_torque", "joint_efforts",
              "joint_effort", "efforts", "effort", "torques", "torque", "tau", "actual_current_as_torque",
              "actual_current", "joint_currents",
              "joint_current", "motor_currents", "motor_current", "currents", "current"),
    "tau_J_d": ("tau_j_d", "motor_torques_desired", "tau_desired", "tau_d"),
    "tau_ext_hat_filtered": ("tau_ext_hat_filtered", "tau_ext_hat", "tau_j_ext", "tau_ext", "motor_torques_external",
                             "external_joint_torques", "external_torques", "external_torque", "tau_external"),
    "gravity": ("gravity", "tau_gravity", "gravity_torques", "gravity_torque", "tau_g", "g"),
    "tau_interaction": ("tau_interaction", "interaction_torques", "interaction_torque", "tau_int", "f_m"),
    "tau_compensation": ("tau_compensation", "tau_comp", "friction_compensation"),
    "tau_passivity": ("tau_passivity", "tau_pc"),
    "temperature": ("temperature", "temperatures", "joint_temperatures", "joint_temperature",
                    "motor_temperature", "temp"),
}  # fmt: skip

_CHANNEL_OF = {alias: (channel, rank) for channel, aliases in ALIASES.items() for rank, alias in enumerate(aliases)}
_QUANTITY = "|".join(re.escape(alias) for alias in sorted(_CHANNEL_OF, key=len, reverse=True))
_HEAD = r"(?P<head>(?:.*[./])?)"
_UNIT = r"(?:[ _]*(?P<unit>\[[a-zA-Z][^\]]*\]|\([^)]*\)|(?<=_)(?:rad_s|rads|rad|deg_s|degs|deg|nm|degc)))?"
_NUMBERED_JOINT = r"(?P<joint>\w*?joint_?(?P<number>\d+))"
_NAMED_JOINT = r"(?P<joint>(?!\w*joints|\w*joint_?state)\w*joint\w*)"
_PATTERNS = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        rf"{_HEAD}{_NUMBERED_JOINT}[./_ ](?P<quantity>{_QUANTITY}){_UNIT}",
        rf"{_HEAD}{_NAMED_JOINT}[./](?P<quantity>{_QUANTITY}){_UNIT}",
        rf"{_HEAD}(?P<quantity>{_QUANTITY}){_UNIT}(?:\[(?P<index>\d+)\])?",
        rf"{_HEAD}(?P<quantity>{_QUANTITY}){_UNIT}[._ ]?(?P<index>\d+)",
        rf"{_HEAD}(?P<quantity>{_QUANTITY})(?:\[(?P<index>\d+)\]|[._ ]?(?P<index2>\d+)){_UNIT}",
        rf"{_HEAD}(?P<quantity>{_QUANTITY})[./_ ]{_NUMBERED_JOINT}{_UNIT}",
        rf"{_HEAD}(?P<quantity>{_QUANTITY})[./]{_NAMED_JOINT}{_UNIT}",
    )
)
_COMMANDED = re.compile(r"(?:^|[^a-z])(?:desired|cmd|commands?|commanded|target|goal|reference|action)(?:[^a-z]|$)")
_MOTOR_SIDE = re.compile(r"motor_state")
_EXTERNAL = re.compile(r"tau_ext|external")
_SAYS_AMPERE = re.compile(r"[\[(](?P<bracket>m?A|milliamps?)[\])]|[_:](?P<suffix>m?A)(?![a-zA-Z])")
_SAYS_CURRENT = re.compile(
    r"(?:(?:^|[^a-zA-Z])(?i:currents?|curr|amps?|amperes?|i_(?:motor|\{i\}|\d+))|Current)(?![a-z])"
)
_SAYS_TORQUE = re.compile(r"torque|effort|tau|nm(?![a-z])|moment", re.IGNORECASE)
_ELEMENT = re.compile(r"(?P<head>(?:.*[./])?)(?P<stem>[^\W\d][^./]*?)(?:\[(?P<a>\d+)\]|[._]?(?P<b>\d+))")
_LABEL = re.compile(r"(?:joint_)?names?", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True, slots=True)
class ForeignName:
    """What a column's name says."""

    channel: str  # channel of JointLog
    rank: int  # place in the table of aliases; the smallest is the best
    template: str  # the name with {i} for the joint's number, or {joint} for its name
    index: int | None  # the joint's number as written, 0- or 1-based, or None
    joint: str | None  # the joint's name, or None
    degrees: bool  # true if the name says degrees


def parse_name(name: str) -> ForeignName | None:
    """Return what a column's name says, or None if it is no joint channel."""
    text = name.strip()
    if is_finger(text):
        return None
    match = next((found for pattern in _PATTERNS if (found := pattern.fullmatch(text))), None)
    if match is None:
        return None
    parts = match.groupdict()
    named, rank = _CHANNEL_OF[parts["quantity"].lower()]
    channel = _in_context(named, parts["head"].lower())
    if channel is None:
        return None
    place = next((group for group in ("index", "index2", "number", "joint") if parts.get(group) is not None), None)
    template = text
    if place is not None:
        start, stop = match.span(place)
        template = text[:start] + ("{joint}" if place == "joint" else "{i}") + text[stop:]
    return ForeignName(
        channel=channel,
        rank=rank,
        template=template,
        index=None if place in (None, "joint") else int(parts[place or ""]),
        joint=parts.get("joint"),
        degrees="deg" in (parts["unit"] or "").lower() and named in ("q", "dq"),
    )


def torque_unit(name: str) -> str:
    """Return the unit of a torque column, ``"N m"`` unless its name says motor current.

    ``current_torque`` is the torque at present, and no current.
    """
    ampere = _SAYS_AMPERE.search(name)
    if ampere is not None:
        return "mA" if (ampere["bracket"] or ampere["suffix"]).startswith("m") else "A"
    return "A" if _SAYS_CURRENT.search(name) and not _SAYS_TORQUE.search(name) else "N m"


def is_label(name: str) -> bool:
    """Return True for an element that holds a joint's name, such as ``field.name3``."""
    match = _ELEMENT.fullmatch(name.strip())
    return match is not None and _LABEL.fullmatch(match["stem"]) is not None


def labels_of(names: Sequence[str], joints: Mapping[str, str]) -> dict[int, str]:
    """Return position of a column -> its joint, where joint names stand next to the numbers as in a JointState.

    Args:
        names: Names of the columns, ``field.position3`` is of the same message and index as ``field.name3``.
        joints: Name of an element that holds a joint's name -> that name: ``field.name3`` -> ``panda_joint1``.
    """
    labels = {_place(name): joint for name, joint in joints.items()}
    labels.pop(None, None)
    places = [_place(name) for name in names]
    return {cell: labels[place] for cell, place in enumerate(places) if place in labels}


def _place(name: str) -> tuple[str, int] | None:
    """Return the message ``field.`` and the index 3 of ``field.position.3``."""
    match = _ELEMENT.fullmatch(name.strip())
    return None if match is None else (match["head"], int(match["a"] or match["b"]))


def _in_context(channel: str, head: str) -> str | None:
    """Return the channel after a look at what stands before the quantity: a commanded effort is tau_J_d."""
    if _COMMANDED.search(head):
        return "tau_J_d" if channel in ("tau_J", "tau_J_d") else None
    if _MOTOR_SIDE.search(head):
        return None
    if _EXTERNAL.search(head):
        return "tau_ext_hat_filtered" if channel in ("tau_J", "tau_ext_hat_filtered") else None
    return channel


_SERIAL_KEYS = {f"{whose}serial{what}" for whose in ("", "robot_", "arm_") for what in ("", "_number")}


def serial_in(notes: Mapping[str, str]) -> str:
    """Return the serial number among notes by name, or nothing; case and dashes of names do not matter."""
    found = {key.strip().lower().replace("-", "_").replace(" ", "_"): value.strip() for key, value in notes.items()}
    return next((found[key] for key in sorted(_SERIAL_KEYS & found.keys()) if found[key]), "")
