"""Nonlinear viscous friction: the part that grows with speed is not a straight line."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, must, number, strength

POWER, EYRING, ARCTAN, CUBIC = range(4)

BEND = 10.0
SMALL_SPEED_RAD_S = 0.02  # a friction that bends at a lower speed is a power of the speed


@dataclass(frozen=True, kw_only=True, slots=True)
class NonlinearViscous(HiddenEffect):
    """Friction on top of the straight viscous line."""

    summary = "friction grows with speed along a curve, not a line"
    forms = ("power", "eyring", "arctan", "cubic")

    torque_nm: float = strength(0.15, "extra friction at the reference speed", "N m")
    exponent: float = number(2.0, "exponent of the power form", lower=0.2, upper=4.0)
    speed_rad_s: float = number(1.0, "reference speed", "rad/s", lower=0.001)
    form: int = POWER

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        torque, exponent, bend = list(values.values())[:3]
        must(bend <= SMALL_SPEED_RAD_S, f"its friction that bends at {bend:g} rad/s is no power of the speed")
        return {"torque_nm": torque, "exponent": exponent, "speed_rad_s": 1.0, "form": "power"}


@compiled()
def extra_nm(group: Record, speed: float) -> float:
    """Return the friction on top of the viscous line at a speed (not negative, never falling). [N m]

    Power is Waiboer, Aarts and Jonker (2005); eyring is the shear thinning of a lubricant (Eyring 1936), arctan a curve
    that saturates, both bent at a tenth of the reference speed; cubic is the odd polynomial of Simoni et al. (2015).
    """
    ratio = speed / group.speed_rad_s
    if group.form == EYRING:
        return float(group.torque_nm * math.asinh(BEND * ratio) / math.asinh(BEND))
    if group.form == ARCTAN:
        return float(group.torque_nm * math.atan(BEND * ratio) / math.atan(BEND))
    if group.form == CUBIC:
        return float(group.torque_nm * ratio * ratio * ratio)
    return float(group.torque_nm * ratio**group.exponent)
