"""Read a URDF: its joints with a motor, the inertias of its links, and its faults."""

from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from math import inf
from xml.etree import ElementTree as ET

import numpy as np

from friction_audit.errors import UsageError, few
from friction_audit.presets import FINGER
from friction_audit.robot.arm import Inertial

TURNING = ("revolute", "continuous")
# Joints with at most one position; a log has no column for those of a planar or floating joint.
_KNOWN = ("revolute", "continuous", "prismatic", "fixed")
_MOST_LINKS = 1000  # trees are walked by recursion, here and in MuJoCo
_ABSURD = 1e6  # no arm is as heavy or as long, in SI units
# MuJoCo refuses massless links and point masses, which URDFs have. It reads this inertia in place of each, rotated so
# that no special case is compiled; the true values are then written into the model.
_PLACEHOLDER = {
    "origin": {"xyz": "1 2 3", "rpy": "1 2 3"},
    "mass": {"value": "1"},
    "inertia": {"ixx": "3", "ixy": "0", "ixz": "0", "iyy": "4", "iyz": "0", "izz": "5"},
}


def parse_urdf(text: bytes, where: str) -> tuple[str, dict[str, tuple[Inertial, ...]]]:
    """Read a URDF. A joint counts if it turns, has a motor of its own (no mimic) and is no finger.

    Returns a URDF of links with placeholder inertias and of joints, those that count as unlimited hinges, all others
    fixed at zero; and the inertial parameters of the links, by name.
    """
    root = _root(text, where)
    if faults := _faults(root):
        raise UsageError(f"{where}: {'; '.join(few(faults, 10))}; repair the URDF, or give another one")
    # Children in the order of their joints' names: the order of columns of an arm with branches.
    joints = sorted(root.findall("joint"), key=lambda joint: joint.get("name", ""))
    own_motor = [one for one in joints if one.get("type") in TURNING and one.find("mimic") is None]
    counted = [one for one in own_motor if not FINGER.search(one.get("name", ""))]
    if not counted:
        raise UsageError(f"{where}: no revolute joint (fingers left out); expected the URDF of an arm")
    inertials = {link.get("name", ""): tuple(map(_inertial, link.findall("inertial"))) for link in root.findall("link")}
    if not any(one.mass > 0.0 for parts in inertials.values() for one in parts):
        raise UsageError(f"{where}: no link has a mass; expected a URDF with inertias, which gravity is computed from")
    bare = ET.Element("robot", name="arm")
    ET.SubElement(ET.SubElement(bare, "mujoco"), "compiler", fusestatic="false")
    for link in root.findall("link"):
        inertial = ET.SubElement(ET.SubElement(bare, "link", name=link.get("name", "")), "inertial")
        inertial.extend(ET.Element(tag, values) for tag, values in _PLACEHOLDER.items())
    for joint in joints:
        kind = "continuous" if joint in counted else "fixed"
        plain = ET.SubElement(bare, "joint", name=joint.get("name", ""), type=kind)
        plain.extend(part for part in joint if part.tag in ("origin", "parent", "child", "axis"))
    return ET.tostring(bare, encoding="unicode"), inertials


def limits_in(text: bytes, where: str, name: str) -> tuple[float, float, float]:
    """Return lowest and highest position and highest speed of a joint, infinite where it has none. [rad], [rad/s]"""
    joints = {one.get("name", ""): one for one in _root(text, where).findall("joint")}
    if name not in joints:
        raise UsageError(f"{where}: no joint {name}; its joints are {', '.join(joints)}; give the URDF of this arm")
    limit = joints[name].find("limit")
    values = {} if limit is None else limit.attrib
    try:
        low, high, speed = (float(values.get(key, "inf")) for key in ("lower", "upper", "velocity"))
    except ValueError as error:
        raise UsageError(f"{where}: limit of joint {name}: {error}; expected numbers; repair the URDF") from error
    endless = joints[name].get("type") == "continuous" or not low < high
    return (-inf, inf, speed) if endless else (low, high, speed)


def _root(text: bytes, where: str) -> ET.Element:
    try:
        root = ET.fromstring(text)  # noqa: S314  the user's own file, on the user's own machine
    except ET.ParseError as error:
        raise UsageError(f"{where}: not XML ({error}); expected a URDF (a .xacro must be expanded first)") from error
    if root.tag != "robot":
        raise UsageError(f"{where}: the outermost element is <{root.tag}>; expected <robot>, the root of a URDF")
    return root


def _inertial(element: ET.Element) -> Inertial:
    import mujoco as mj

    part = {one.tag: one for one in element}
    origin = part.get("origin", ET.Element("origin"))
    centre, angles = (np.array([float(x) for x in origin.get(name, "0 0 0").split()]) for name in ("xyz", "rpy"))
    quaternion, turned = np.empty(4), np.empty(9)
    mj.mju_euler2Quat(quaternion, angles, "XYZ")
    mj.mju_quat2Mat(turned, quaternion)
    axes = turned.reshape(3, 3)
    xx, xy, xz, yy, yz, zz = (float(part["inertia"].get(f"i{k}", "")) for k in ("xx", "xy", "xz", "yy", "yz", "zz"))
    inertia = axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axes.T
    return Inertial(float(part["mass"].get("value", "")), centre, inertia)


def _faults(root: ET.Element) -> list[str]:
    """Return the faults of links and joints; a URDF parser would drop such a part and its gravity in silence."""
    links, joints = root.findall("link"), root.findall("joint")
    if len(links) > _MOST_LINKS:
        return [f"{len(links)} links; expected at most {_MOST_LINKS}"]
    found = []
    for link in links:
        wrong = [one for inertial in link.findall("inertial") for one in _wrong_inertial(inertial)]
        found += [f"link {link.get('name')}: {one}" for one in wrong]
    for joint in joints:
        kind, wrong = joint.get("type"), list(_wrong_numbers(joint, "origin", 3, xyz="0 0 0", rpy="0 0 0"))
        axis = joint.find("axis")
        if axis is not None and kind != "fixed":
            bent = list(_wrong_numbers(joint, "axis", 3, xyz=""))
            still = not bent and not any(map(float, axis.get("xyz", "").split()))
            wrong += [*bent, f"axis {axis.get('xyz')!r} has no direction"] if still else bent
        if kind not in _KNOWN:
            wrong.append(f"type {kind}; expected one of {', '.join(_KNOWN)}")
        found += [f"joint {joint.get('name')}: {one}" for one in wrong]
    return found or list(_wrong_tree(links, joints))


def _wrong_inertial(inertial: ET.Element) -> Iterator[str]:
    missing = [tag for tag in ("mass", "inertia") if inertial.find(tag) is None]
    if missing:
        yield f"inertial without <{missing[0]}>"
        return
    yield from _wrong_numbers(inertial, "mass", 1, lowest=0.0, value="")
    yield from _wrong_numbers(inertial, "inertia", 1, lowest=0.0, ixx="", iyy="", izz="")
    yield from _wrong_numbers(inertial, "inertia", 1, ixy="", ixz="", iyz="")
    yield from _wrong_numbers(inertial, "origin", 3, xyz="0 0 0", rpy="0 0 0")


def _wrong_numbers(parent: ET.Element, tag: str, count: int, lowest: float = -inf, **defaults: str) -> Iterator[str]:
    """Yield the faulty attributes of an element, if there is one: each must hold ``count`` valid numbers."""
    element = parent.find(tag)
    if element is None:
        return
    for name, default in defaults.items():
        text = element.get(name, default)
        try:
            values = [float(part) for part in text.split()]
        except ValueError:
            values = []
        sound = all(lowest <= value and abs(value) < _ABSURD for value in values)
        if len(values) != count or "_" in text or not sound:
            plural = "a number" if count == 1 else f"{count} numbers"
            least = " of at least 0" if lowest == 0.0 else ""
            yield f"{tag} {name} {text!r}; expected {plural}{least} below {_ABSURD:g}"


def _wrong_tree(links: list[ET.Element], joints: list[ET.Element]) -> Iterator[str]:
    """Yield the faults because of which the links are not one tree."""
    names, ends = [link.get("name") for link in links], dict[str, list[str | None]]()
    for what, own in (("link", names), ("joint", [joint.get("name") for joint in joints])):
        yield from (f"{own.count(one)} {what}s of the name {one}" for one in dict.fromkeys(own) if own.count(one) > 1)
    for end in ("parent", "child"):
        ends[end] = [None if (part := joint.find(end)) is None else part.get("link") for joint in joints]
        pairs = ((joint, link) for joint, link in zip(joints, ends[end], strict=True) if link not in names)
        yield from (f"joint {joint.get('name')}: {end} link {link} is not in the file" for joint, link in pairs)
    below = ends["child"]
    yield from (f"link {link}: the child of two joints" for link in dict.fromkeys(below) if below.count(link) > 1)
    roots = {*names} - {*below}
    if links and len(roots) != 1:
        yield f"{len(roots)} links that are no child of a joint; expected one, the base"
    try:
        TopologicalSorter({child: [parent] for parent, child in zip(*ends.values(), strict=True)}).prepare()
    except CycleError as error:
        yield f"link {error.args[1][0]}: its joints form a loop"
