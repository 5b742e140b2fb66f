"""Files of plain text that hold static, Coulomb and viscous friction by joint: USD, Isaac Lab, ROS 2 and a table."""

import json
import re
from collections.abc import Sequence
from math import pi

from friction_audit import __version__
from friction_audit.export.target import ExportedJoint, Target, number
from friction_audit.export.xml_text import XmlText

NO_IDENTIFIER = re.compile(r"\W|^(?=\d)")  # what USD refuses in the name of a prim
AXIS = "physxJointAxis:angular"


def write_usd(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write a layer in text form: sublayer or reference it, and put the joints under their own scope.

    The friction coefficient of a rotating axis is per degree in this schema (PhysX multiplies it by 180 / pi).
    """
    lines = ["#usda 1.0", "(", '    defaultPrim = "joints"', ")", "", 'over "joints"', "{"]
    for joint in joints:
        values = {
            "staticFrictionEffort": joint.static_nm,
            "dynamicFrictionEffort": joint.fitted.coulomb_nm,
            "viscousFrictionCoefficient": joint.fitted.viscous_nms_per_rad * pi / 180.0,
        }
        inertia = joint.law.inertia_kg_m2
        values |= {} if inertia is None else {"armature": inertia}
        lines += [
            f'    over "{NO_IDENTIFIER.sub("_", joint.name)}" (',
            '        prepend apiSchemas = ["PhysxJointAxisAPI:angular"]',
            "    )",
            "    {",
            *(f"        float {AXIS}:{key} = {number(value)}" for key, value in values.items()),
            "    }",
        ]
    return "\n".join((*lines, "}", "")).encode()


ISAAC_LAB_HEAD = f'''"""Joint friction by friction-audit {__version__}, for the actuators of Isaac Lab.

    from joint_friction import FRICTION
    ImplicitActuatorCfg(joint_names_expr=list(FRICTION["friction"]), stiffness=..., damping=..., **FRICTION)

friction: static, N m; dynamic_friction: Coulomb, N m; viscous_friction: N m s/rad; armature: kg m^2.
"""
'''


def write_isaac_lab(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the keyword arguments of an actuator's configuration as a Python module: a dictionary each, by joint."""
    values = {
        "friction": {j.name: j.static_nm for j in joints},
        "dynamic_friction": {j.name: j.fitted.coulomb_nm for j in joints},
        "viscous_friction": {j.name: j.fitted.viscous_nms_per_rad for j in joints},
        "armature": {j.name: j.law.inertia_kg_m2 for j in joints if j.law.inertia_kg_m2 is not None},
    }
    lines = [ISAAC_LAB_HEAD, "FRICTION = {"]
    for key, by_joint in values.items():
        if by_joint:
            inside = ", ".join(f"{name!r}: {number(value)}" for name, value in by_joint.items())
            lines.append(f"    {key!r}: {{{inside}}},")
    return "\n".join((*lines, "}", "")).encode()


def write_ros2_control(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the parameters of a node, as a controller declares and reads them."""
    names = json.dumps([joint.name for joint in joints])
    lines = ["/**:", "  ros__parameters:", f"    joints: {names}", "    friction:"]
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


def write_csv(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write a table, a row per joint."""
    import pandas as pd

    rows = [
        {
            "joint": joint.law.joint,
            "name": joint.name,
            "static_nm": joint.static_nm,
            "coulomb_nm": joint.fitted.coulomb_nm,
            "viscous_nms_per_rad": joint.fitted.viscous_nms_per_rad,
            "inertia_kg_m2": joint.law.inertia_kg_m2,
            "error_nm": joint.fitted.error_nm,
        }
        for joint in joints
    ]
    return pd.DataFrame(rows).to_csv(index=False, lineterminator="\n").encode()


USD = Target(
    name="usd",
    suffixes=(".usda",),
    summary="PhysX joint friction and armature of Isaac Sim as a USD layer",
    write=write_usd,
    armature=True,
)
ISAAC_LAB = Target(
    name="isaac-lab",
    suffixes=(".py",),
    summary="static, dynamic and viscous friction and armature for the actuators of Isaac Lab",
    write=write_isaac_lab,
    armature=True,
)
ROS2_CONTROL = Target(
    name="ros2-control",
    suffixes=(".yaml",),
    summary="friction by joint as parameters of a ROS 2 controller",
    write=write_ros2_control,
)
CSV = Target(
    name="csv",
    suffixes=(".csv",),
    summary="table of static, Coulomb and viscous friction",
    write=write_csv,
    armature=True,
)
