"""New files with the friction by joint: a template per format."""

import json
import re
from collections.abc import Sequence
from math import pi
from xml.sax.saxutils import quoteattr

from friction_audit import __version__
from friction_audit.effects.effect import SpeedFriction
from friction_audit.export.friction_law import ExportedJoint, number

NO_IDENTIFIER = re.compile(r"\W|^(?=\d)")  # what USD refuses in the name of a prim
NO_COMMENT = re.compile(r"[\x00-\x1f\\]")  # what ends a comment's line in C++ or continues it
NO_CELL = re.compile(r'[",\r\n]')  # what a cell of CSV holds in quotes
SIGN_WIDTH = 0.01  # rad/s: a few times the noise of a velocity that is differentiated from an encoder of 16 bit and up

# Joints with nothing else, to be copied; of MJCF a class of defaults per joint, for an ``<include>``.
URDF = """<robot name="friction">
% for j in joints
  <joint name={{ j.name | quoteattr }}>
    <dynamics damping="{{ j.viscous | number }}" friction="{{ j.coulomb | number }}"/>
  </joint>
% endfor
</robot>
"""
MJCF = """<mujoco>
  <default>
% for j in joints
    <default class={{ (j.name ~ "_friction") | quoteattr }}>
      <joint frictionloss="{{ j.coulomb | number }}" damping="{{ j.damping | map("number") | join(" ") }}"
          {%- if j.armature is not none %} armature="{{ j.armature | number }}"{% endif %}/>
    </default>
% endfor
  </default>
</mujoco>
"""
SDF = """<sdf version="1.9">
  <model name="friction">
% for j in joints
    <joint name={{ j.name | quoteattr }} type="revolute">
      <axis><dynamics><damping>{{ j.viscous | number }}</damping><friction>{{ j.coulomb | number }}</friction>
          {{- "" }}</dynamics></axis>
    </joint>
% endfor
  </model>
</sdf>
"""
# A layer in text form: sublayer or reference it, and put the joints under their own scope. The friction coefficient of
# a rotating axis is per degree in this schema (PhysX multiplies it by 180 / pi).
USD = """#usda 1.0
(
    defaultPrim = "joints"
)

over "joints"
{
% for j in joints
    over "{{ j.name | identifier }}" (
        prepend apiSchemas = ["PhysxJointAxisAPI:angular"]
    )
    {
        float physxJointAxis:angular:staticFrictionEffort = {{ j.static | number }}
        float physxJointAxis:angular:dynamicFrictionEffort = {{ j.coulomb | number }}
        float physxJointAxis:angular:viscousFrictionCoefficient = {{ (j.viscous * pi / 180.0) | number }}
% if j.armature is not none
        float physxJointAxis:angular:armature = {{ j.armature | number }}
% endif
    }
% endfor
}
"""
# The keyword arguments of an actuator's configuration, a dictionary each, by joint.
ISAAC_LAB = '''"""Joint friction by friction-audit {{ version }}, for the actuators of Isaac Lab.

    from joint_friction import FRICTION
    ImplicitActuatorCfg(joint_names_expr=list(FRICTION["friction"]), stiffness=..., damping=..., **FRICTION)

friction: static, N m; dynamic_friction: Coulomb, N m; viscous_friction: N m s/rad; armature: kg m^2.
"""

FRICTION = {
% for key, name in (("friction", "static"), ("dynamic_friction", "coulomb"), ("viscous_friction", "viscous"),
                    ("armature", "armature"))
% for some in [joints | rejectattr(name, "none") | list] if some
    '{{ key }}': {
{%- for j in some %}{{ ", " if loop.index > 1 else "" }}{{ j.name | repr }}: {{ j[name] | number }}{% endfor %}},
% endfor
% endfor
}
'''
# The parameters of a node, as a controller declares and reads them.
ROS2 = """/**:
  ros__parameters:
    joints: {{ joints | map(attribute="name") | list | json }}
    friction:
% for j in joints
      {{ j.name | json }}:
        static_nm: {{ j.static | decimal }}
        coulomb_nm: {{ j.coulomb | decimal }}
        viscous_nms_per_rad: {{ j.viscous | decimal }}
% endfor
"""
CPP = """// Joint friction by friction-audit {{ version }}. C++17, no allocation, no exception.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace friction_audit {

// Speed up to which the sign of the velocity rises linearly, so that the torque is bounded and continuous at
// standstill. [rad/s]
inline constexpr double kSignWidth = {{ sign_width }};

inline double sign_of(double dq) noexcept { return std::clamp(dq / kSignWidth, -1.0, 1.0); }
% if joints | sum("tables", [])
{##}
// Entry of a table at a place between two of its entries.
template <std::size_t N>
inline double between(const std::array<double, N>& table, double place) noexcept {
  const std::size_t k = std::min(static_cast<std::size_t>(place), N - 2);
  return table[k] + (place - static_cast<double>(k)) * (table[k + 1] - table[k]);
}
% endif
% for j in joints
{{ j.tables | join }}
// {{ j.name | comment }}
inline double friction_{{ j.joint }}(double dq) noexcept {
  const double way = sign_of(dq);
  [[maybe_unused]] const double pace = std::abs(dq);
  double friction = 0.0;
% for term in j.terms
  friction += {{ term }};
% endfor
  return friction;
}
% endfor
{##}
// Friction torque of a joint, 0 the first, at a velocity [rad/s]: add it to the command to compensate for it. [N m]
inline double friction(std::size_t joint, double dq) noexcept {
  switch (joint) {
% for j in joints
    case {{ loop.index0 }}: return friction_{{ j.joint }}(dq);
% endfor
    default: return 0.0;
  }
}

}  // namespace friction_audit
"""
CSV = """joint,name,static_nm,coulomb_nm,viscous_nms_per_rad,inertia_kg_m2,error_nm
% for j in joints
{{ j.joint }},{{ j.name | cell }},{{ j.static }},{{ j.coulomb }},{{ j.viscous }},{{ j.armature }},{{ j.error }}
% endfor
"""


# A line that is empty in the file is ``{##}`` after a line that begins with %.
def render(template: str, joints: Sequence[ExportedJoint]) -> bytes:
    """Return a new file."""
    from jinja2 import Environment, StrictUndefined

    made = Environment(line_statement_prefix="%", keep_trailing_newline=True, undefined=StrictUndefined)  # noqa: S701
    made.finalize = lambda value: "" if value is None else value
    made.globals = {"version": __version__, "sign_width": SIGN_WIDTH, "pi": pi}
    made.filters |= {
        "number": number,
        "decimal": decimal,
        "quoteattr": quoteattr,
        "json": json.dumps,
        "repr": repr,
        "identifier": lambda name: NO_IDENTIFIER.sub("_", name),
        "comment": lambda name: NO_COMMENT.sub("?", name),
        "cell": lambda name: '"{}"'.format(name.replace('"', '""')) if NO_CELL.search(name) else name,
    }
    return made.from_string(template).render(joints=[_values(joint) for joint in joints]).encode()


def _values(joint: ExportedJoint) -> dict[str, object]:
    law, (coulomb, viscous, *_) = joint.law, joint.fitted.coefficients
    formulas, tables = [], []
    for term in law.terms:
        assert isinstance(term.effect, SpeedFriction)
        name = f"k_{term.name}_{law.joint}"
        formula, table = term.effect.in_cpp(term.values, name)
        formulas.append(formula)
        if table is not None:
            wrapped = re.sub(r"(.{90,110}?) ", r"\1\n    ", ", ".join(map(repr, table.tolist())))
            tables.append(f"\ninline constexpr std::array<double, {len(table)}> {name}{{\n    {wrapped}}};\n")
    return {
        "joint": law.joint,
        "name": joint.name,
        "static": joint.static_nm,
        "coulomb": coulomb,
        "viscous": viscous,
        "damping": joint.damping,
        "error": joint.fitted.error_nm,
        "armature": law.inertia_kg_m2,
        "terms": formulas,
        "tables": tables,
    }


def decimal(value: float) -> str:
    """Return a number with a point: ROS 2 takes 0 for an integer and refuses it for a double."""
    text = number(value)
    return text if "." in text else text.replace("e", ".0e") if "e" in text else f"{text}.0"
