"""Reading a URDF: which of its joints count, and whether it says enough for dynamics."""

import re
from xml.etree import ElementTree as ET

from friction_audit.errors import UsageError

TURNING = ("revolute", "continuous")
FINGER = re.compile("finger|gripper", re.IGNORECASE)
NO_LIMIT = {"lower": "-1e9", "upper": "1e9", "effort": "1e9", "velocity": "1e9"}


def joint_chain_xml(text: bytes, where: str) -> tuple[str, tuple[str, ...]]:
    """Return the URDF with continuous joints as revolute ones, and the names of the joints that count.

    A joint counts if it turns, has a motor of its own (no mimic) and is no finger. Continuous joints are rewritten
    because Pinocchio keeps them as a sine and a cosine, while a log holds an angle.

    Args:
        text: Content of the file.
        where: The file, for the messages.

    Raises:
        UsageError: If it is no URDF, no joint counts or there is no mass.
    """
    root = _root(text, where)
    turning = [joint for joint in root.findall("joint") if joint.get("type") in TURNING]
    counting = tuple(j.get("name", "") for j in turning if not FINGER.search(j.get("name", "")) and _own_motor(j))
    if not counting:
        raise UsageError(f"{where}: no revolute joint (fingers left out); expected the URDF of an arm")
    if not any(mass > 0 for mass in _masses(root, where)):
        raise UsageError(f"{where}: no link has a mass; expected a URDF with inertias, which gravity is computed from")
    for joint in turning:
        _limit_continuous(joint)
    return ET.tostring(root, encoding="unicode"), counting


def _root(text: bytes, where: str) -> ET.Element:
    try:
        root = ET.fromstring(text)  # noqa: S314  the user's own file, on the user's own machine
    except ET.ParseError as error:
        raise UsageError(f"{where}: not XML ({error}); expected a URDF (a .xacro must be expanded first)") from error
    if root.tag != "robot":
        raise UsageError(f"{where}: the outermost element is <{root.tag}>; expected <robot>, the root of a URDF")
    return root


def _masses(root: ET.Element, where: str) -> list[float]:
    try:
        return [float(mass.get("value", "")) for mass in root.iterfind("link/inertial/mass")]
    except ValueError as error:
        raise UsageError(f"{where}: a mass is not a number ({error}); expected <mass value=...> in kg") from error


def _own_motor(joint: ET.Element) -> bool:
    return joint.find("mimic") is None


def _limit_continuous(joint: ET.Element) -> None:
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit")
        limit.attrib.update({**NO_LIMIT, **{k: v for k, v in limit.attrib.items() if k in ("effort", "velocity")}})
