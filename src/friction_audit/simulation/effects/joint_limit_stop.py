"""Joint limit stop: a soft wall at both ends of the range, mechanical or virtual."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

SPRING_DAMPER, QUADRATIC, EXPONENTIAL = range(3)

REFERENCE_RAD = 0.1  # depth at which the quadratic wall is as strong as the linear one. [rad]

WIDTH_RAD = 0.05  # distance over which the exponential wall grows by e. [rad]

# A person who gets so deep into an exponential wall does not exist; the number stays finite.
HIGHEST_EXPONENT = 20.0


@dataclass(frozen=True, kw_only=True, slots=True)
class JointLimitStop(HiddenEffect):
    """Two soft walls, at +at_rad and at -at_rad from the start pose."""

    summary = "a soft wall at both ends of the range"
    forms = ("spring_damper", "quadratic", "exponential")

    stiffness_nm_per_rad: float = strength(20.0, "stiffness of the walls", "N m/rad", upper=2000.0)
    at_rad: float = number(0.5, "where they stand, on both sides of the start pose", "rad")
    damping_s: float = number(0.02, "damping relative to the stiffness", "s", upper=0.2)
    form: int = SPRING_DAMPER


@compiled()
def _push(group: Record, depth: float, inward: float) -> float:
    """Return how hard one wall pushes back, not negative."""
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
def torque_nm(group: Record, q: float, velocity: float) -> float:
    """Return the torque of both walls, on the motor's side of the sensor. [N m]

    A wall never pulls and never gives back more than it took. Spring and damper as in the virtual walls of haptics
    (Colgate and Brown 1994), quadratic with the damping of Hunt and Crossley (1975), exponential as a repulsive
    potential that is felt before the stop.
    """
    return _push(group, -group.at_rad - q, -velocity) - _push(group, q - group.at_rad, velocity)
