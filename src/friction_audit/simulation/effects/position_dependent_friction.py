"""Position-dependent friction: misaligned, worn or dirty places of the gear rub differently."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

SINUSOID, HARMONICS, PATCH = range(3)

SECOND_ORDER, THIRD_ORDER = math.sqrt(3.0), math.sqrt(7.0)
"""Orders of the harmonics relative to the first: bearing and gear parts of incommensurate pitch."""

FIRST_WEIGHT, SECOND_WEIGHT, THIRD_WEIGHT = 0.5, 0.3, 0.2

PATCH_SHARPNESS = 8.0
"""Concentration of the patch (of a von Mises density): half as high at 0.42 rad of the cycle from its centre."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PositionDependentFriction:
    """A Coulomb level that depends on the position.

    Attributes:
        share: Largest change relative to the level; negative for less friction in the patch.
        cycles_per_rev: Cycles per revolution of the joint.
        phase_rad: Phase of the cycle at q = 0; the patch is centred where the phase is 0. [rad]
        form: Index into the forms of the effect.
    """

    share: float = 0.0
    cycles_per_rev: float = 3.0
    phase_rad: float = 0.5
    form: int = SINUSOID


@compiled()
def _shape(form: int, angle: float, phase: float) -> float:
    """Return the relative change of the level at an angle of the cycle, between -1 and 1."""
    if form == HARMONICS:
        first = FIRST_WEIGHT * math.sin(angle + phase)
        second = SECOND_WEIGHT * math.sin(SECOND_ORDER * angle + phase)
        return float(first + second + THIRD_WEIGHT * math.sin(THIRD_ORDER * angle + phase))
    if form == PATCH:
        return float(math.exp(PATCH_SHARPNESS * (math.cos(angle + phase) - 1.0)))
    return float(math.sin(angle + phase))


@compiled()
def factor(group: Any, q: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the factor of the Coulomb level at a position: 1 on average, never below 0, so passive.

    Periodic after Armstrong-Helouvry, Control of Machines with Friction (1991), who found several spatial frequencies
    in one joint; the patch stands for a worn or dirty tooth.
    """
    change = _shape(group.form, group.cycles_per_rev * q, group.phase_rad)
    return float(max(0.0, 1.0 + group.share * change))


EFFECT = Effect(
    name="position_dependent_friction",
    family="load and place",
    summary="the Coulomb level depends on the position",
    group=PositionDependentFriction,
    strength="share",
    parameters=(
        Parameter(name="share", usual=0.4, meaning="largest change relative to the Coulomb level", low=-1.0, high=3.0),
        Parameter(name="cycles_per_rev", usual=3.0, meaning="cycles per revolution of the joint"),
        Parameter(name="phase_rad", usual=0.5, meaning="phase of the cycle at q = 0 [rad]", low=-math.inf),
    ),
    forms=("sinusoid", "harmonics", "patch"),
)
