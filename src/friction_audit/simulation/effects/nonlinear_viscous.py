"""Nonlinear viscous friction: the part that grows with speed is not a straight line."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

POWER, EYRING, ARCTAN, CUBIC = range(4)

BEND = 10.0


@dataclass(frozen=True, kw_only=True, slots=True)
class NonlinearViscous:
    """Friction on top of the straight viscous line.

    Attributes:
        torque_nm: Its size at the reference speed. [N m]
        exponent: Of the power form: below 1 it thins, above 1 it churns.
        speed_rad_s: The reference speed. [rad/s]
        form: Index into the forms of the effect.
    """

    torque_nm: float = 0.0
    exponent: float = 2.0
    speed_rad_s: float = 1.0
    form: int = POWER


@compiled()
def extra_nm(group: Any, speed: float) -> float:  # noqa: ANN401 - a record of numbers
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


EFFECT = Effect(
    name="nonlinear_viscous",
    family="velocity",
    summary="friction grows with speed along a curve, not a line",
    group=NonlinearViscous,
    strength="torque_nm",
    parameters=(
        Parameter(name="torque_nm", usual=0.15, meaning="extra friction at the reference speed [N m]"),
        Parameter(name="exponent", usual=2.0, meaning="exponent of the power form", low=0.2, high=4.0),
        Parameter(name="speed_rad_s", usual=1.0, meaning="reference speed [rad/s]", low=1e-3),
    ),
    forms=("power", "eyring", "arctan", "cubic"),
)
