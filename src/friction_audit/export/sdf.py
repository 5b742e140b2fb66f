"""SDF of Gazebo: ``<damping>`` and ``<friction>`` in ``<axis><dynamics>`` of a joint."""

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import quoteattr

from friction_audit.errors import InputError
from friction_audit.export.target import ExportedJoint, Target
from friction_audit.export.urdf import TURNING, values_of
from friction_audit.export.xml_text import Edit, Tag, XmlText


def joints_of(sdf: XmlText) -> list[Tag]:
    """Return the joints that turn, in the order of the file."""
    return [tag for tag in sdf.root.walk() if tag.name == "joint" and tag.attributes.get("type") in TURNING]


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:
    """Write friction into a model; without one, the axes with nothing else, to be copied."""
    if into is None:
        heads = (f'    <joint name={quoteattr(joint.name)} type="revolute">' for joint in joints)
        axes = (f"      <axis>{_dynamics(joint)}</axis>\n    </joint>" for joint in joints)
        lines = (line for pair in zip(heads, axes, strict=True) for line in pair)
        opened = ('<sdf version="1.9">', '  <model name="friction">')
        return "\n".join((*opened, *lines, "  </model>", "</sdf>", "")).encode()
    return into.edited(_edits(joints, into))


def _edits(joints: Sequence[ExportedJoint], into: XmlText) -> Iterator[Edit]:
    tags = {tag.attributes["name"]: tag for tag in joints_of(into)}
    for joint in joints:
        axis = tags[joint.name].child("axis")
        if axis is None:
            raise InputError(f"{into.where}: joint {joint.name} has no <axis>; expected one; repair the file")
        dynamics = axis.child("dynamics")
        if dynamics is None:
            yield into.append(axis, _dynamics(joint))
            continue
        lacking = ""
        for name, value in values_of(joint).items():
            there = dynamics.child(name)
            if there is None:
                lacking += f"<{name}>{value}</{name}>"
            else:
                yield into.set_text(there, value)
        if lacking:
            yield into.append(dynamics, lacking)


def _dynamics(joint: ExportedJoint) -> str:
    return f"<dynamics>{''.join(f'<{key}>{value}</{key}>' for key, value in values_of(joint).items())}</dynamics>"


TARGET = Target(
    name="sdf",
    suffix=".sdf",
    summary="Coulomb and viscous friction in <dynamics> of the joints of a Gazebo model",
    highest_power=1,
    write=write,
    joints_of=joints_of,
)
