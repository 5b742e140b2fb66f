"""URDF: ``<dynamics damping="" friction=""/>`` of a joint."""

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import quoteattr

from friction_audit.export.target import ExportedJoint, Target, attributes, number
from friction_audit.export.xml_text import Edit, Tag, XmlText

TURNING = ("revolute", "continuous")


def joints_of(urdf: XmlText) -> list[Tag]:
    """Return the joints that turn, in the order of the file."""
    return [tag for tag in urdf.root.children if tag.name == "joint" and tag.attributes.get("type") in TURNING]


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a URDF; without one, the joints with nothing else, to be copied."""
    if into is None:
        lines = (
            f"  <joint name={quoteattr(joint.name)}>\n    <dynamics {attributes(values_of(joint))}/>\n  </joint>"
            for joint in joints
        )
        return "\n".join(('<robot name="friction">', *lines, "</robot>", "")).encode()
    return into.edited(_edits(joints, into))


def _edits(joints: Sequence[ExportedJoint], into: XmlText) -> Iterator[Edit]:
    tags = {tag.attributes["name"]: tag for tag in joints_of(into)}
    for joint in joints:
        tag = tags[joint.name]
        dynamics = tag.child("dynamics")
        yield (
            into.set_attributes(dynamics, values_of(joint))
            if dynamics
            else into.append(tag, f"<dynamics {attributes(values_of(joint))}/>")
        )


def values_of(joint: ExportedJoint) -> dict[str, str]:
    """Return damping and friction of a joint, as URDF and SDF name them."""
    return {"damping": number(joint.fitted.viscous_nms_per_rad), "friction": number(joint.fitted.coulomb_nm)}


TARGET = Target(
    name="urdf",
    suffix=".urdf",
    summary="Coulomb and viscous friction in <dynamics> of the joints of a URDF",
    highest_power=1,
    write=write,
    joints_of=joints_of,
)
