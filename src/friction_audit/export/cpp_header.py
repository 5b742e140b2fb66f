"""A C++17 header with the friction law of every joint, for a control loop: no allocation, bounded at standstill."""

import re
from collections.abc import Callable, Mapping, Sequence
from math import exp, pi, sqrt

from friction_audit import __version__
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.nonlinear_viscous import CARREAU, TABLE, bend_table
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
    tabled = [term for joint in joints for term in joint.law.terms if _sharpness(term)]
    parts += [READ_TABLE] if tabled else []
    for joint in joints:
        lines = [
            f"  friction += {EXPRESSIONS[term.name](_values(term), f'kBend{joint.law.joint}')};"
            for term in joint.law.terms
        ]
        parts += [_table(term, joint.law.joint) for term in joint.law.terms if _sharpness(term)]
        parts.append(
            f"\n// {_comment(joint.name)}\n"
            f"inline double friction_{joint.law.joint}(double dq) noexcept {{\n"
            "  const double way = sign_of(dq);\n"
            "  [[maybe_unused]] const double pace = std::abs(dq);\n"
            "  double friction = 0.0;\n" + "\n".join(lines) + "\n  return friction;\n}\n"
        )
    cases = (f"    case {k}: return friction_{joint.law.joint}(dq);" for k, joint in enumerate(joints))
    return "".join((*parts, TAIL.format(cases="\n".join(cases)))).encode()


def _values(term: FittedTerm) -> dict[str, float]:
    return dict(zip((one.name for one in term.effect.parameters), term.values, strict=True))


def _sharpness(term: FittedTerm) -> float:
    return _values(term).get("curved_viscous_sharpness", 0.0)


def _coulomb(at: Mapping[str, float], _: str) -> str:
    return f"{at['coulomb_nm']!r} * way"


def _viscous(at: Mapping[str, float], _: str) -> str:
    return f"{at['viscous_nms_per_rad']!r} * dq"


def _stribeck(at: Mapping[str, float], _: str) -> str:
    power = f"std::pow(pace / {at['stribeck_speed_rad_s']!r}, {at['stribeck_exponent']!r})"
    return f"{at['stribeck_excess_nm']!r} * way * std::exp(-{power})"


def _curved(at: Mapping[str, float], table: str) -> str:
    """Carreau's curve, or with another sharpness the distribution of Student's t, over its value at 1 rad/s."""
    exponent, speed = at["curved_viscous_exponent"], at["curved_viscous_speed_rad_s"]
    sharpness = at["curved_viscous_sharpness"]
    squares = f"({speed * speed!r} + pace * pace) / {speed * speed + 1.0!r}"
    if sharpness == 0.0:
        return f"{at['curved_viscous_nm']!r} * way * pace * std::pow({squares}, {(exponent - 1.0) / 2.0!r})"
    steep = sqrt(CARREAU / (CARREAU * exp(sharpness))) / speed
    per_angle = (TABLE - 1) / (pi / 2.0)
    bend = "between({0}, std::atan({1} * {2!r}) * {3!r})"
    here, at_one = (bend.format(table, pace, steep, per_angle) for pace in ("pace", "1.0"))
    return f"{at['curved_viscous_nm']!r} * way * {here} / {at_one} * std::pow({squares}, {exponent / 2.0!r})"


EXPRESSIONS: Mapping[str, Callable[[Mapping[str, float], str], str]] = {
    "coulomb": _coulomb,
    "viscous": _viscous,
    "stribeck": _stribeck,
    "nonlinear_viscous": _curved,
}
"""Torque of each term that follows from the velocity and is dissipated, as C++."""


def _table(term: FittedTerm, joint: int) -> str:
    entries = ", ".join(f"{value!r}" for value in bend_table(CARREAU * exp(_sharpness(term))).tolist())
    wrapped = re.sub(r"(.{90,110}?) ", r"\1\n    ", entries)
    return f"\ninline constexpr std::array<double, {TABLE}> kBend{joint}{{\n    {wrapped}}};\n"


def _comment(name: str) -> str:
    """Return a name that cannot end a comment's line nor continue it."""
    return re.sub(r"[\x00-\x1f\\]", "?", name)


TARGET = Target(
    name="cpp",
    suffix=".hpp",
    summary="C++17 header with the friction law of every joint for a control loop",
    highest_power=None,
    write=write,
)
