"""Joint limit stop: a soft wall at both ends of the range, mechanical or virtual."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

SPRING_DAMPER, QUADRATIC, EXPONENTIAL = range(3)

REFERENCE_RAD = 0.1
"""Depth at which the quadratic wall is as strong as the linear one. [rad]"""

WIDTH_RAD = 0.05
"""Distance over which the exponential wall grows by e. [rad]"""

HIGHEST_EXPONENT = 20.0
"""A person who gets so deep into an exponential wall does not exist; the number stays finite."""


@dataclass(frozen=True, kw_only=True, slots=True)
class JointLimitStop:
    """Two soft walls, at +at_rad and at -at_rad from the start pose.

    Attributes:
        stiffness_nm_per_rad: Of the walls; of the exponential form at the stop. [N m/rad]
        at_rad: Where they stand. [rad]
        damping_s: Damping relative to the stiffness. [s]
        form: Index into the forms of the effect.
    """

    stiffness_nm_per_rad: float = 0.0
    at_rad: float = 0.5
    damping_s: float = 0.02
    form: int = SPRING_DAMPER


@compiled()
def _push(group: Any, depth: float, inward: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return how hard one wall pushes back, not negative.

    Args:
        group: A ``JointLimitStop``.
        depth: Distance beyond the stop.
        inward: Speed further into the wall.
    """
    if group.form == EXPONENTIAL:
        depth = WIDTH_RAD * math.exp(min(depth / WIDTH_RAD, HIGHEST_EXPONENT))
        return float(group.stiffness_nm_per_rad * depth * max(0.0, 1.0 + inward * group.damping_s / WIDTH_RAD))
    if depth <= 0.0:
        return 0.0
    if group.form == QUADRATIC:
        push = depth * depth / REFERENCE_RAD * max(0.0, 1.0 + inward * group.damping_s / REFERENCE_RAD)
        return float(group.stiffness_nm_per_rad * push)
    return float(group.stiffness_nm_per_rad * max(0.0, depth + group.damping_s * inward))


@compiled()
def torque_nm(group: Any, q: float, velocity: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the torque of both walls, on the motor's side of the sensor. [N m]

    A wall never pulls and never gives back more than it took. Spring and damper as in the virtual walls of haptics
    (Colgate and Brown 1994), quadratic with the damping of Hunt and Crossley (1975), exponential as a repulsive
    potential that is felt before the stop.

    Args:
        group: A ``JointLimitStop``.
        q: Position from the start pose. [rad]
        velocity: Velocity. [rad/s]
    """
    return _push(group, -group.at_rad - q, -velocity) - _push(group, q - group.at_rad, velocity)


EFFECT = Effect(
    name="joint_limit_stop",
    family="load and place",
    summary="a soft wall at both ends of the range",
    group=JointLimitStop,
    strength="stiffness_nm_per_rad",
    parameters=(
        Parameter(name="stiffness_nm_per_rad", usual=20.0, meaning="stiffness of the walls [N m/rad]", high=2e3),
        Parameter(name="at_rad", usual=0.5, meaning="where they stand, on both sides of the start pose [rad]"),
        Parameter(name="damping_s", usual=0.02, meaning="damping relative to the stiffness [s]", high=0.2),
    ),
    forms=("spring_damper", "quadratic", "exponential"),
)
