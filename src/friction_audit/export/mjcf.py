"""MJCF of MuJoCo: ``frictionloss``, ``damping`` and ``armature`` of a joint.

MuJoCo 4 takes up to three coefficients of damping: of dq, dq |dq| and dq^3. Where only the first is needed only that is
written, which every version reads.
"""

from collections.abc import Sequence

from friction_audit.export.target import ExportedJoint, Target, attributes, number
from friction_audit.export.xml_text import Tag, XmlText

HINGE = "hinge"


def joints_of(mjcf: XmlText) -> list[Tag]:
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


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a model; without one, a class of defaults per joint, for an ``<include>``."""
    if into is None:
        names = (attributes({"class": f"{joint.name}_friction"}) for joint in joints)
        pairs = zip(names, joints, strict=True)
        lines = (
            f"    <default {name}>\n      <joint {attributes(_values(one))}/>\n    </default>" for name, one in pairs
        )
        return "\n".join(("<mujoco>", "  <default>", *lines, "  </default>", "</mujoco>", "")).encode()
    tags = {tag.attributes["name"]: tag for tag in joints_of(into)}
    return into.edited(into.set_attributes(tags[joint.name], _values(joint)) for joint in joints)


def _values(joint: ExportedJoint) -> dict[str, str]:
    fitted = joint.fitted
    damping = [fitted.viscous_nms_per_rad, fitted.quadratic_nms2_per_rad2, fitted.cubic_nms3_per_rad3]
    while len(damping) > 1 and damping[-1] == 0.0:
        damping.pop()
    values = {"frictionloss": number(fitted.coulomb_nm), "damping": " ".join(map(number, damping))}
    inertia = joint.law.inertia_kg_m2
    return values if inertia is None else values | {"armature": number(inertia)}


TARGET = Target(
    name="mjcf",
    suffix=".xml",
    summary="frictionloss, damping (linear to cubic) and armature of the joints of a MuJoCo model",
    highest_power=3,
    write=write,
    armature=True,
    joints_of=joints_of,
)
