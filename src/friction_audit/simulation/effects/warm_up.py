"""Warm-up: friction falls while the joint gets warm."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter

AMBIENT, SELF_HEATING = range(2)


@dataclass(frozen=True, kw_only=True, slots=True)
class WarmUp:
    """Friction of a warm joint beside a cold one; warmth is 0 where cold and 1 where warm.

    Attributes:
        reduction: Share of the viscous friction that a warm joint has lost.
        coulomb_ratio: The Coulomb friction lost, as a share of that.
        time_s: Thermal time constant. [s]
        power_w: Friction power that keeps a joint warm, of the self-heating form. [W]
        cold_c: Temperature of a cold joint. [degC]
        rise_k: Temperature of a warm joint above it. [K]
        form: Index into the forms of the effect.
    """

    reduction: float = 0.0
    coulomb_ratio: float = 0.5
    time_s: float = 60.0
    power_w: float = 0.2
    cold_c: float = 25.0
    rise_k: float = 15.0
    form: int = AMBIENT


@compiled()
def advance(group: Any, warmth: float, friction_power_w: float, h: float) -> float:  # noqa: ANN401
    """Return the warmth after h: one heat capacity, one way out for the heat, solved exactly at constant power.

    Ambient: drives and electronics warm the joint whether it moves or not. Self-heating: its own friction does (Simoni
    et al. 2015), and at rest it cools down again; more than ``power_w`` makes it warmer than 1.
    """
    target = friction_power_w / group.power_w if group.form == SELF_HEATING else 1.0
    return float(warmth - (target - warmth) * math.expm1(-h / group.time_s))


@compiled()
def coulomb_factor(group: Any, warmth: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the Coulomb friction over that of the cold joint: falls about linearly, stays above 0."""
    lost = group.reduction * group.coulomb_ratio
    return float(1.0 / (1.0 + warmth * lost / (1.0 - lost)))


@compiled()
def viscous_factor(group: Any, warmth: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the viscous friction over that of the cold joint: exponential in temperature (Reynolds 1886)."""
    return float((1.0 - group.reduction) ** warmth)


def temperature_c(group: WarmUp, warmth: Float) -> Float:
    """Return the temperature at a warmth, shape as given. [degC]"""
    return group.cold_c + group.rise_k * warmth


EFFECT = Effect(
    name="warm_up",
    family="slow and events",
    summary="friction falls while the joint gets warm",
    group=WarmUp,
    strength="reduction",
    parameters=(
        Parameter(name="reduction", usual=0.5, meaning="share of viscous friction lost when warm", high=0.9),
        Parameter(name="coulomb_ratio", usual=0.5, meaning="Coulomb friction lost, as a share of that", high=1.0),
        Parameter(name="time_s", usual=60.0, meaning="thermal time constant [s]", low=0.1),
        Parameter(name="power_w", usual=0.2, meaning="friction power that keeps it warm, self-heating [W]", low=1e-6),
        Parameter(name="cold_c", usual=25.0, meaning="temperature when cold [degC]", low=-50.0, high=100.0),
        Parameter(name="rise_k", usual=15.0, meaning="rise of the temperature when warm [K]", high=100.0),
    ),
    forms=("ambient", "self_heating"),
)
