"""Position-dependent friction: misaligned, worn or dirty places of the gear rub differently."""

import math
from dataclasses import dataclass
from math import inf

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import (
    Given,
    HiddenEffect,
    Setting,
    Values,
    must,
    number,
    strength,
    within_half_turn,
)

SINUSOID, HARMONICS, PATCH = range(3)

# Orders of the harmonics relative to the first: bearing and gear parts of incommensurate pitch.
SECOND_ORDER, THIRD_ORDER = math.sqrt(3.0), math.sqrt(7.0)

FIRST_WEIGHT, SECOND_WEIGHT, THIRD_WEIGHT = 0.5, 0.3, 0.2

# Concentration of the patch (of a von Mises density): half as high at 0.42 rad of the cycle from its centre.
PATCH_SHARPNESS = 8.0
WIDE_RAD = 10.0  # a wave under a bell of this width fills the whole range


@dataclass(frozen=True, kw_only=True, slots=True)
class PositionDependentFriction(HiddenEffect):
    """A Coulomb level that depends on the position."""

    summary = "the Coulomb level depends on the position"
    forms = ("sinusoid", "harmonics", "patch")

    share: float = strength(0.4, "largest change relative to the Coulomb level", lower=-1.0, upper=3.0)
    cycles_per_rev: float = number(3.0, "cycles per revolution of the joint", like="position_friction_order")
    phase_rad: float = number(0.5, "phase of the cycle at q = 0", "rad", lower=-inf)
    form: int = SINUSOID

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine, order, centre, width = values.values()
        must(width >= WIDE_RAD, "its wave fills the whole range")
        must(setting.joint.coulomb_nm > 0.0, "its wave is a share of the Coulomb friction, which is none")
        share = math.hypot(cosine, sine) / setting.joint.coulomb_nm
        phase = within_half_turn(math.atan2(cosine, sine) - order * centre)
        return {"share": share, "cycles_per_rev": order, "phase_rad": phase, "form": "sinusoid"}


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
def factor(group: Record, q: float) -> float:
    """Return the factor of the Coulomb level at a position: 1 on average, never below 0, so passive.

    Periodic after Armstrong-Helouvry, Control of Machines with Friction (1991), who found several spatial frequencies
    in one joint; the patch stands for a worn or dirty tooth.
    """
    change = _shape(group.form, group.cycles_per_rev * q, group.phase_rad)
    return float(max(0.0, 1.0 + group.share * change))
