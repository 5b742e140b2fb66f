"""A C++17 header with the friction law of every joint, for a control loop: no allocation, bounded at standstill."""

import re
from collections.abc import Sequence

from friction_audit import __version__
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.export.target import ExportedJoint, Target
from friction_audit.export.xml_text import XmlText

SIGN_WIDTH = 0.01  # rad/s: a few times the noise of a velocity that is differentiated from an encoder of 16 bit and up

HEAD = f"""// Joint friction by friction-audit {__version__}. C++17, no allocation, no exception.
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
READ_TABLE = """
// Entry of a table at a place between two of its entries.
template <std::size_t N>
inline double between(const std::array<double, N>& table, double place) noexcept {
  const std::size_t k = std::min(static_cast<std::size_t>(place), N - 2);
  return table[k] + (place - static_cast<double>(k)) * (table[k + 1] - table[k]);
}
"""
TAIL = """
// Friction torque of a joint, 0 the first, at a velocity [rad/s]: add it to the command to compensate for it. [N m]
inline double friction(std::size_t joint, double dq) noexcept {{
  switch (joint) {{
{cases}
    default: return 0.0;
  }}
}}

}}  // namespace friction_audit
"""


def write(joints: Sequence[ExportedJoint], into: XmlText | None) -> bytes:  # noqa: ARG001 - as every target
    """Write the header."""
    parts = [HEAD]
    tables = {joint.law.joint: [_table(term, joint.law.joint) for term in joint.law.terms] for joint in joints}
    parts += [READ_TABLE] if any(map(any, tables.values())) else []
    for joint in joints:
        number = joint.law.joint
        terms = (term.effect.in_cpp(term.values, table_name(term, number)) for term in joint.law.terms)
        lines = [f"  friction += {expression};" for expression in terms]
        parts += tables[number]
        parts.append(
            f"\n// {_comment(joint.name)}\n"
            f"inline double friction_{joint.law.joint}(double dq) noexcept {{\n"
            "  const double way = sign_of(dq);\n"
            "  [[maybe_unused]] const double pace = std::abs(dq);\n"
            "  double friction = 0.0;\n" + "\n".join(lines) + "\n  return friction;\n}\n"
        )
    cases = (f"    case {k}: return friction_{joint.law.joint}(dq);" for k, joint in enumerate(joints))
    return "".join((*parts, TAIL.format(cases="\n".join(cases)))).encode()


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


def _comment(name: str) -> str:
    """Return a name that cannot end a comment's line nor continue it."""
    return re.sub(r"[\x00-\x1f\\]", "?", name)


TARGET = Target(
    name="cpp",
    suffixes=(".hpp", ".h"),
    summary="C++17 header with the friction law of every joint for a control loop",
    highest_power=None,
    write=write,
)
