"""Friction in the file of a robot: URDF, MJCF of MuJoCo and SDF of Gazebo; all else of a user's file stays as it is."""

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import quoteattr

from friction_audit.errors import InputError
from friction_audit.export.friction_law import ExportedJoint, Target, number
from friction_audit.export.xml_text import Edit, Tag, XmlText

TURNING, HINGE = ("revolute", "continuous"), "hinge"


def _attributes(values: dict[str, str]) -> str:
    return " ".join(f"{key}={quoteattr(value)}" for key, value in values.items())


def _dynamics(joint: ExportedJoint) -> dict[str, str]:
    """Return damping and friction of a joint, as URDF and SDF name them."""
    return {"damping": number(joint.fitted.viscous_nms_per_rad), "friction": number(joint.fitted.coulomb_nm)}


def turning_joints(robot: XmlText) -> list[Tag]:
    """Return the joints of a URDF or SDF that turn, in the order of the file."""
    return [tag for tag in robot.root.walk() if tag.name == "joint" and tag.attributes.get("type") in TURNING]


def write_urdf(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a URDF; without one, the joints with nothing else, to be copied."""
    if into is None:
        lines = (
            f"  <joint name={quoteattr(joint.name)}>\n    <dynamics {_attributes(_dynamics(joint))}/>\n  </joint>"
            for joint in joints
        )
        return "\n".join(('<robot name="friction">', *lines, "</robot>", "")).encode()
    tags = {tag.attributes["name"]: tag for tag in turning_joints(into)}
    pairs = [(tags[joint.name], _dynamics(joint)) for joint in joints]
    return into.edited(
        into.set_attributes(there, values)
        if (there := tag.child("dynamics"))
        else into.append(tag, f"<dynamics {_attributes(values)}/>")
        for tag, values in pairs
    )


def mjcf_joints(mjcf: XmlText) -> list[Tag]:
    """Return the named hinges of the bodies, in the order of the file; a joint without a type is one."""
    return [
        tag
        for tag in mjcf.root.walk()
        if tag.name == "joint"
        and tag.parent is not None
        and tag.parent.name == "body"
        and "name" in tag.attributes
        and tag.attributes.get("type", HINGE) == HINGE
    ]


def write_mjcf(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a model; without one, a class of defaults per joint, for an ``<include>``."""
    if into is None:
        lines = (
            f"    <default {_attributes({'class': f'{joint.name}_friction'})}>\n"
            f"      <joint {_attributes(_mjcf_values(joint))}/>\n    </default>"
            for joint in joints
        )
        return "\n".join(("<mujoco>", "  <default>", *lines, "  </default>", "</mujoco>", "")).encode()
    tags = {tag.attributes["name"]: tag for tag in mjcf_joints(into)}
    return into.edited(into.set_attributes(tags[joint.name], _mjcf_values(joint)) for joint in joints)


def _mjcf_values(joint: ExportedJoint) -> dict[str, str]:
    """Return the attributes of a joint: MuJoCo 4 takes coefficients of dq, dq |dq| and dq^3 as its damping.

    Where only the first is needed only that is written, which every version reads.
    """
    fitted = joint.fitted
    damping = [fitted.viscous_nms_per_rad, fitted.quadratic_nms2_per_rad2, fitted.cubic_nms3_per_rad3]
    while len(damping) > 1 and damping[-1] == 0.0:
        damping.pop()
    values = {"frictionloss": number(fitted.coulomb_nm), "damping": " ".join(map(number, damping))}
    inertia = joint.law.inertia_kg_m2
    return values if inertia is None else values | {"armature": number(inertia)}


def write_sdf(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a model; without one, the axes with nothing else, to be copied."""
    if into is None:
        lines = (
            f'    <joint name={quoteattr(joint.name)} type="revolute">\n'
            f"      <axis><dynamics>{_elements(_dynamics(joint))}</dynamics></axis>\n    </joint>"
            for joint in joints
        )
        opened = ('<sdf version="1.9">', '  <model name="friction">')
        return "\n".join((*opened, *lines, "  </model>", "</sdf>", "")).encode()
    return into.edited(_sdf_edits(joints, into))


def _sdf_edits(joints: Sequence[ExportedJoint], into: XmlText) -> Iterator[Edit]:
    tags = {tag.attributes["name"]: tag for tag in turning_joints(into)}
    for joint in joints:
        axis, values = tags[joint.name].child("axis"), _dynamics(joint)
        if axis is None:
            raise InputError(f"{into.where}: joint {joint.name} has no <axis>; expected one; repair the file")
        dynamics = axis.child("dynamics")
        if dynamics is None:
            yield into.append(axis, f"<dynamics>{_elements(values)}</dynamics>")
            continue
        there = {name: tag for name in values if (tag := dynamics.child(name)) is not None}
        yield from (into.set_text(tag, values[name]) for name, tag in there.items())
        if lacking := {name: value for name, value in values.items() if name not in there}:
            yield into.append(dynamics, _elements(lacking))


def _elements(values: dict[str, str]) -> str:
    return "".join(f"<{key}>{value}</{key}>" for key, value in values.items())


URDF = Target(
    name="urdf",
    suffixes=(".urdf",),
    summary="Coulomb and viscous friction in <dynamics> of the joints of a URDF",
    write=write_urdf,
    joints_of=turning_joints,
)
MJCF = Target(
    name="mjcf",
    suffixes=(".xml",),
    summary="frictionloss, damping (linear to cubic) and armature of the joints of a MuJoCo model",
    highest_power=3,
    write=write_mjcf,
    armature=True,
    joints_of=mjcf_joints,
)
SDF = Target(
    name="sdf",
    suffixes=(".sdf",),
    summary="Coulomb and viscous friction in <dynamics> of the joints of a Gazebo model",
    write=write_sdf,
    joints_of=turning_joints,
)
