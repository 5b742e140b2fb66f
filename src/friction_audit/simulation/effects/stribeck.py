"""Stribeck: friction falls from its level at rest to the Coulomb level as the speed rises."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

EXPONENTIAL, LORENTZIAN, PIECEWISE = range(3)


@dataclass(frozen=True, kw_only=True, slots=True)
class Stribeck(HiddenEffect):
    """Friction above the Coulomb level at low speed."""

    summary = "friction falls from rest to the Coulomb level as the speed rises"
    forms = ("exponential", "lorentzian", "piecewise")
    same_law = "exponential"

    excess_nm: float = strength(0.15, "friction at rest above the Coulomb level", like="stribeck_excess_nm")
    speed_rad_s: float = number(0.1, "speed over which it falls", like="stribeck_speed_rad_s")
    exponent: float = number(2.0, "exponent of the exponential form", like="stribeck_exponent")
    form: int = EXPONENTIAL


@compiled()
def excess_nm(group: Record, speed: float) -> float:
    """Return the friction above the Coulomb level at a speed (not negative). [N m]"""
    ratio = speed / group.speed_rad_s
    if group.form == LORENTZIAN:
        return float(group.excess_nm / (1.0 + ratio * ratio))
    if group.form == PIECEWISE:
        return float(group.excess_nm * max(0.0, 1.0 - ratio))
    return float(group.excess_nm * math.exp(-(ratio**group.exponent)))
