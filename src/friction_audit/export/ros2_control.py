"""Parameters of a ROS 2 node: friction by joint, as a controller declares and reads them."""

import json
from collections.abc import Sequence

from friction_audit.export.target import ExportedJoint, Target, number
from friction_audit.export.xml_text import XmlText


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the parameter file."""
    lines = [
        "/**:",
        "  ros__parameters:",
        f"    joints: {json.dumps([joint.name for joint in joints])}",
        "    friction:",
    ]
    for joint in joints:
        values = {
            "static_nm": joint.static_nm,
            "coulomb_nm": joint.fitted.coulomb_nm,
            "viscous_nms_per_rad": joint.fitted.viscous_nms_per_rad,
        }
        lines.append(f"      {json.dumps(joint.name)}:")
        lines += [f"        {key}: {_float(value)}" for key, value in values.items()]
    return "\n".join((*lines, "")).encode()


def _float(value: float) -> str:
    """Return a number with a point: ROS 2 takes 0 for an integer and refuses it for a double."""
    text = number(value)
    return text if "." in text else text.replace("e", ".0e") if "e" in text else f"{text}.0"


TARGET = Target(
    name="ros2-control",
    suffix=".yaml",
    summary="friction by joint as parameters of a ROS 2 controller",
    highest_power=1,
    write=write,
)
