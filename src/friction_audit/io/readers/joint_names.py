"""Names of joints and topics: which arm each belongs to, in which order, and which robot they say."""

import re
from collections.abc import Iterable, Sequence

from friction_audit.errors import InputError
from friction_audit.io.readers.reader import SeveralLogsError
from friction_audit.joint_log import Source
from friction_audit.presets import PRESETS, candidates

# Nodes that publish an arm's own state; they are no name of an arm, and their topics are not republished.
DRIVER_NODES = {"franka_state_controller", "franka_robot_state_broadcaster", "joint_state_broadcaster",
                 "joint_state_controller", "franka"}  # fmt: skip
UNNAMED_ARM = "joint"  # what an arm without prefix is called after the # of --topic
# panda_joint3, left_fr3_joint1, joint2: the arm before the word, the joint's number after it
_ARM_JOINT = re.compile(r"^(?:(?P<arm>.*?)_?)?joint_?(?P<number>\d+)$", re.IGNORECASE)
_FINGER = re.compile(r"finger|gripper", re.IGNORECASE)
_LAST_NUMBER = re.compile(r"(.*?)(\d+)")
_MAKE = re.compile("|".join(("franka", "lbr", r"fr3v\d_\d", *(one.pattern for one in PRESETS.values()))), re.IGNORECASE)
_FEWEST_OF_A_SECOND_ARM = 2  # a single numbered joint next to an arm (a lift, a gripper) is not a second arm


def arms_in(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Group joints by arm: prefix of the arm -> its joints in the order of their numbers, fingers left out.

    Where no name ends in ``joint`` and a number, there is one arm, "": names that differ in a number at their end alone
    (``A1``) in the order of the numbers, others in the order of the message.
    """
    bodies = [name for name in dict.fromkeys(names) if not is_finger(name)]
    numbered: dict[str, list[tuple[int, str]]] = {}
    for name in bodies:
        if match := _ARM_JOINT.match(name):
            numbered.setdefault(match["arm"] or "", []).append((int(match["number"]), name))
    if not numbered:
        return {"": _by_last_number(bodies)} if bodies else {}
    most = max(map(len, numbered.values()))
    return {
        arm: tuple(name for _, name in sorted(joints))
        for arm, joints in sorted(numbered.items())
        if len(joints) >= min(most, _FEWEST_OF_A_SECOND_ARM)
    }


def is_finger(name: str) -> bool:
    """Return True for joints of a gripper, which are no part of the arm."""
    return _FINGER.search(name) is not None


def _by_last_number(names: Sequence[str]) -> tuple[str, ...]:
    numbered = [(match[1], int(match[2]), name) for name in names if (match := _LAST_NUMBER.fullmatch(name))]
    if len(numbered) < len(names) or len({stem for stem, _, _ in numbered}) > 1:
        return tuple(names)
    return tuple(name for _, _, name in sorted(numbered))


def choose_arm(names: Sequence[str], wanted: str, *, path: str, topic: str = "") -> tuple[str, ...]:
    """Return the joints of the arm to read, in their order; SeveralLogsError if there are several to choose from."""
    arms = {arm or UNNAMED_ARM: joints for arm, joints in arms_in(names).items()}
    choices = " or ".join(f"--topic '{topic}#{arm}'" for arm in arms)
    where = f"on topic {topic}" if topic else "in this table"
    if wanted and wanted not in arms:
        raise InputError(
            f"{path}: no arm {wanted!r} {where}; it has {', '.join(arms) or 'no joints by name'}; "
            f"{f'choose with {choices}' if arms else 'leave --topic out'}"
        )
    if not wanted and len(arms) > 1:
        message = f"{path}: several arms {where if topic else 'in one log'}; choose one with {choices}"
        raise SeveralLogsError(message, [f"{topic}#{arm}" for arm in arms])
    return arms[wanted] if wanted else next(iter(arms.values()), ())


def arm_name(prefix: str) -> str:
    """Return what the prefix of joints calls their arm, or nothing where it is the make of the robot alone."""
    return "" if _MAKE.fullmatch(prefix) else prefix


def robot_of(names: Iterable[str]) -> str:
    """Return the name of the preset that the joints' names say, ``"unknown"`` where they say none or several."""
    robots = candidates(tuple(names))
    return robots[0] if len(robots) == 1 else "unknown"


def numbered_joints(count: int) -> tuple[str, ...]:
    """Name joints that carry no names: joint1..joint{count}."""
    return tuple(f"joint{number}" for number in range(1, count + 1))


def namespace(topic: str) -> str:
    """Return what stands before a topic's name, nodes of drivers left out: ``left`` of ``/left/joint_states``."""
    return "/".join(part for part in topic.strip("/").split("/")[:-1] if part not in DRIVER_NODES)


def arm_of_log(source: Source, joint_names: Sequence[str]) -> str:
    """Return the serial number or the name of the arm of a log, or nothing where the log has neither.

    ``left`` of joints called ``left_joint1``, or of a topic ``/left/joint_states``; nothing of ``panda_joint1``, which
    every Panda's are called.
    """
    if source.serial:
        return source.serial
    prefixes = list(arms_in(joint_names))
    named = arm_name(prefixes[0]) if len(prefixes) == 1 else ""
    return named or namespace(source.topic or "")
