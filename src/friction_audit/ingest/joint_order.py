"""Which of a message's joints belong to an arm, and in which order: by name, never by index."""

import re
from collections.abc import Sequence

ARM_JOINT = re.compile(r"^(?:(?P<arm>.*?)_?)?joint_?(?P<number>[1-9]\d*)$")
"""``panda_joint3``, ``left_fr3_joint1``, ``joint2``: the arm before the word, the joint's number after it."""

ROBOTS = (("panda", re.compile(r"(?:^|_)(?:panda|fer)(?:_|\d|$)")), ("fr3", re.compile(r"(?:^|_)fr3(?:_|v\d|\d|$)")))

MINIMUM_JOINTS_BESIDE_AN_ARM = 2
"""A single numbered joint beside an arm (a lift, a gripper) is not a second arm."""


def arms_in(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Group joints by arm.

    Args:
        names: Joint names in the order of the message.

    Returns:
        Prefix of the arm -> its joints in the order of their numbers, fingers left out. Where no name ends in a
        joint's number, there is one arm, "", with the joints in the order of the message.
    """
    bodies = [name for name in dict.fromkeys(names) if "finger" not in name.lower()]
    numbered: dict[str, list[tuple[int, str]]] = {}
    for name in bodies:
        if match := ARM_JOINT.match(name):
            numbered.setdefault(match["arm"] or "", []).append((int(match["number"]), name))
    if not numbered:
        return {"": tuple(bodies)} if bodies else {}
    most = max(map(len, numbered.values()))
    return {
        arm: tuple(name for _, name in sorted(joints))
        for arm, joints in sorted(numbered.items())
        if len(joints) >= min(most, MINIMUM_JOINTS_BESIDE_AN_ARM)
    }


def robot_of(names: Sequence[str]) -> str:
    """Return ``"panda"``, ``"fr3"`` or ``"unknown"`` from the prefix of the joint names."""
    prefixes = {match["arm"] or "" for name in names if (match := ARM_JOINT.match(name))}
    robots = {robot for robot, pattern in ROBOTS for prefix in prefixes if pattern.search(prefix)}
    return robots.pop() if len(robots) == 1 else "unknown"


def numbered_joints(count: int) -> tuple[str, ...]:
    """Name the joints of a message that carries no names: joint1..joint{count}."""
    return tuple(f"joint{number}" for number in range(1, count + 1))
