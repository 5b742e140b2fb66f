"""Stribeck: friction falls from its level at rest to the Coulomb level as the speed rises."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

EXPONENTIAL, LORENTZIAN, PIECEWISE = range(3)


@dataclass(frozen=True, kw_only=True, slots=True)
class Stribeck:
    """Friction above the Coulomb level at low speed.

    Attributes:
        excess_nm: At rest. [N m]
        speed_rad_s: Speed over which it goes. [rad/s]
        exponent: Of the exponential form: 1 (Bo and Pavelescu) or 2 (Gaussian).
        form: Index into the forms of the effect.
    """

    excess_nm: float = 0.0
    speed_rad_s: float = 0.1
    exponent: float = 2.0
    form: int = EXPONENTIAL


@compiled()
def excess_nm(group: Any, speed: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the friction above the Coulomb level at a speed (not negative). [N m]"""
    ratio = speed / group.speed_rad_s
    if group.form == LORENTZIAN:
        return float(group.excess_nm / (1.0 + ratio * ratio))
    if group.form == PIECEWISE:
        return float(group.excess_nm * max(0.0, 1.0 - ratio))
    return float(group.excess_nm * math.exp(-(ratio**group.exponent)))


EFFECT = Effect(
    name="stribeck",
    family="velocity",
    summary="friction falls from rest to the Coulomb level as the speed rises",
    group=Stribeck,
    strength="excess_nm",
    parameters=(
        Parameter(name="excess_nm", usual=0.15, meaning="friction at rest above the Coulomb level [N m]"),
        Parameter(name="speed_rad_s", usual=0.1, meaning="speed over which it falls [rad/s]", low=1e-4),
        Parameter(name="exponent", usual=2.0, meaning="exponent of the exponential form", low=0.5, high=4.0),
    ),
    forms=("exponential", "lorentzian", "piecewise"),
)
