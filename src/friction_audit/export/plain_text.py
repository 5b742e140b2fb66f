"""Files of plain text with the friction by joint: USD, Isaac Lab, ROS 2, a table, and a C++ header with the law."""

import json
import re
from collections.abc import Sequence
from math import pi

from friction_audit import __version__
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.export.friction_law import ExportedJoint, Target, number
from friction_audit.export.xml_text import XmlText

NO_IDENTIFIER = re.compile(r"\W|^(?=\d)")  # what USD refuses in the name of a prim
NO_COMMENT = re.compile(r"[\x00-\x1f\\]")  # what ends a comment's line in C++ or continues it
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


SIGN_WIDTH = 0.01  # rad/s: a few times the noise of a velocity that is differentiated from an encoder of 16 bit and up

CPP_HEAD = f"""// Joint friction by friction-audit {__version__}. C++17, no allocation, no exception.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace friction_audit {{

// Speed up to which the sign of the velocity rises linearly, so that the torque is bounded and continuous at
// standstill. [rad/s]
inline constexpr double kSignWidth = {SIGN_WIDTH!r};

inline double sign_of(double dq) noexcept {{ return std::clamp(dq / kSignWidth, -1.0, 1.0); }}
"""
CPP_TABLE = """
// Entry of a table at a place between two of its entries.
template <std::size_t N>
inline double between(const std::array<double, N>& table, double place) noexcept {
  const std::size_t k = std::min(static_cast<std::size_t>(place), N - 2);
  return table[k] + (place - static_cast<double>(k)) * (table[k + 1] - table[k]);
}
"""
CPP_TAIL = """
// Friction torque of a joint, 0 the first, at a velocity [rad/s]: add it to the command to compensate for it. [N m]
inline double friction(std::size_t joint, double dq) noexcept {{
  switch (joint) {{
{cases}
    default: return 0.0;
  }}
}}

}}  // namespace friction_audit
"""


def write_cpp(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the header."""
    parts = [CPP_HEAD]
    tables = {joint.law.joint: [_table(term, joint.law.joint) for term in joint.law.terms] for joint in joints}
    parts += [CPP_TABLE] if any(map(any, tables.values())) else []
    for joint in joints:
        number = joint.law.joint
        terms = (term.effect.in_cpp(term.values, table_name(term, number)) for term in joint.law.terms)
        lines = [f"  friction += {expression};" for expression in terms]
        parts += tables[number]
        parts.append(
            f"\n// {NO_COMMENT.sub('?', joint.name)}\n"
            f"inline double friction_{joint.law.joint}(double dq) noexcept {{\n"
            "  const double way = sign_of(dq);\n"
            "  [[maybe_unused]] const double pace = std::abs(dq);\n"
            "  double friction = 0.0;\n" + "\n".join(lines) + "\n  return friction;\n}\n"
        )
    cases = (f"    case {k}: return friction_{joint.law.joint}(dq);" for k, joint in enumerate(joints))
    return "".join((*parts, CPP_TAIL.format(cases="\n".join(cases)))).encode()


def table_name(term: FittedTerm, joint: int) -> str:
    """Return what the table of a term is called."""
    return f"k_{term.name}_{joint}"


def _table(term: FittedTerm, joint: int) -> str:
    table = term.effect.cpp_table(term.values)
    if table is None:
        return ""
    wrapped = re.sub(r"(.{90,110}?) ", r"\1\n    ", ", ".join(map(repr, table.tolist())))
    name = table_name(term, joint)
    return f"\ninline constexpr std::array<double, {len(table)}> {name}{{\n    {wrapped}}};\n"


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
CPP = Target(
    name="cpp",
    suffixes=(".hpp", ".h"),
    summary="C++17 header with the friction law of every joint for a control loop",
    highest_power=None,
    write=write_cpp,
)
