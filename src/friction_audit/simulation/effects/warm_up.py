"""Warm-up: friction falls while the joint gets warm."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

AMBIENT, SELF_HEATING = range(2)


@dataclass(frozen=True, kw_only=True, slots=True)
class WarmUp(HiddenEffect):
    """Friction of a warm joint beside a cold one; warmth is 0 where cold and 1 where warm."""

    summary = "friction falls while the joint gets warm"
    forms = ("ambient", "self_heating")

    reduction: float = strength(0.5, "share of viscous friction lost when warm", upper=0.9)
    coulomb_ratio: float = number(0.5, "Coulomb friction lost, as a share of that", upper=1.0)
    time_s: float = number(60.0, "thermal time constant", like="warm_up_time_s")
    power_w: float = number(0.2, "friction power that keeps it warm, self-heating", "W", lower=1e-06)
    cold_c: float = number(25.0, "temperature when cold", "degC", lower=-50.0, upper=100.0)
    rise_k: float = number(15.0, "rise of the temperature when warm", "K", upper=100.0)
    form: int = AMBIENT


@compiled()
def advance(group: Record, warmth: float, friction_power_w: float, h: float) -> float:
    """Return the warmth after h: one heat capacity, one way out for the heat, solved exactly at constant power.

    Ambient: drives and electronics warm the joint whether it moves or not. Self-heating: its own friction does (Simoni
    et al. 2015), and at rest it cools down again; more than ``power_w`` makes it warmer than 1.
    """
    target = friction_power_w / group.power_w if group.form == SELF_HEATING else 1.0
    return float(warmth - (target - warmth) * math.expm1(-h / group.time_s))


@compiled()
def coulomb_factor(group: Record, warmth: float) -> float:
    """Return the Coulomb friction over that of the cold joint: falls about linearly, stays above 0."""
    lost = group.reduction * group.coulomb_ratio
    return float(1.0 / (1.0 + warmth * lost / (1.0 - lost)))


@compiled()
def viscous_factor(group: Record, warmth: float) -> float:
    """Return the viscous friction over that of the cold joint: exponential in temperature (Reynolds 1886)."""
    return float((1.0 - group.reduction) ** warmth)


def temperature_c(group: WarmUp, warmth: Float) -> Float:
    """Return the temperature at a warmth, shape as given. [degC]"""
    return group.cold_c + group.rise_k * warmth
