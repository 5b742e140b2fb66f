"""Reading a URDF: which of its joints count, and whether it says enough for dynamics."""

import re
from collections.abc import Iterator
from math import inf
from xml.etree import ElementTree as ET

from friction_audit.errors import UsageError

TURNING = ("revolute", "continuous")
FINGER = re.compile("finger|gripper", re.IGNORECASE)
_KNOWN = ("revolute", "continuous", "prismatic", "fixed")
"""Joints with one position or none; a log has no place for that of a planar or floating one."""
_MOST_LINKS = 1000
"""Pinocchio goes from link to link by recursion, and ends the program where the stack does."""
_ABSURD = 1e6
"""No arm is as heavy or as long, in SI units."""
_SHOWN = 10
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
    faults = _faults(root)
    if faults:
        more = f" and {len(faults) - _SHOWN} more" if len(faults) > _SHOWN else ""
        raise UsageError(f"{where}: {'; '.join(faults[:_SHOWN])}{more}; repair the URDF, or give another one")
    turning = [joint for joint in root.findall("joint") if joint.get("type") in TURNING]
    counting = tuple(j.get("name", "") for j in turning if not FINGER.search(j.get("name", "")) and _own_motor(j))
    if not counting:
        raise UsageError(f"{where}: no revolute joint (fingers left out); expected the URDF of an arm")
    if not any(float(mass.get("value", "0")) > 0.0 for mass in root.iterfind("link/inertial/mass")):
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


def _faults(root: ET.Element) -> list[str]:
    """Return what is wrong with links and joints; the URDF parser drops such a part, and its gravity, in silence."""
    links, joints = root.findall("link"), root.findall("joint")
    if len(links) > _MOST_LINKS:
        return [f"{len(links)} links; expected at most {_MOST_LINKS}"]
    found = []
    for link in links:
        for inertial in link.findall("inertial"):
            wrong = [*_wrong_inertial(inertial), *_wrong_origin(inertial, "inertial origin")]
            found += [f"link {link.get('name')}: {one}" for one in wrong]
    for joint in joints:
        wrong = [*_wrong_origin(joint, "origin"), *_wrong_axis(joint)]
        if joint.get("type") not in _KNOWN:
            wrong.append(f"type {joint.get('type')}; expected one of {', '.join(_KNOWN)}")
        found += [f"joint {joint.get('name')}: {one}" for one in wrong]
    return found


def _wrong_inertial(inertial: ET.Element) -> Iterator[str]:
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        yield f"inertial without <{'mass' if mass is None else 'inertia'}>"
        return
    yield from _wrong_numbers("mass", mass.get("value", ""), 1, lowest=0.0)
    for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        lowest = 0.0 if name[1] == name[2] else -inf
        yield from _wrong_numbers(f"inertia {name}", inertia.get(name, ""), 1, lowest=lowest)


def _wrong_origin(parent: ET.Element, what: str) -> Iterator[str]:
    origin = parent.find("origin")
    if origin is None:
        return
    for name in ("xyz", "rpy"):
        yield from _wrong_numbers(f"{what} {name}", origin.get(name, "0 0 0"), 3)


def _wrong_axis(joint: ET.Element) -> Iterator[str]:
    axis = joint.find("axis")
    if axis is None or joint.get("type") == "fixed":
        return
    text = axis.get("xyz", "")
    wrong = list(_wrong_numbers("axis", text, 3))
    yield from wrong
    if not wrong and not any(map(float, text.split())):
        yield f"axis {text!r} has no direction"


def _wrong_numbers(what: str, text: str, count: int, lowest: float = -inf) -> Iterator[str]:
    try:
        values = [float(part) for part in text.split()]
    except ValueError:
        values = []
    if len(values) != count or "_" in text or not all(lowest <= value and abs(value) < _ABSURD for value in values):
        plural = "a number" if count == 1 else f"{count} numbers"
        yield f"{what} {text!r}; expected {plural}{' of at least 0' if lowest == 0.0 else ''} below {_ABSURD:g}"


def _own_motor(joint: ET.Element) -> bool:
    return joint.find("mimic") is None


def _limit_continuous(joint: ET.Element) -> None:
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit")
        limit.attrib.update({**NO_LIMIT, **{k: v for k, v in limit.attrib.items() if k in ("effort", "velocity")}})
