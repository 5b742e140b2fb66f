"""Asymmetric Coulomb friction: more of it in one direction than in the other."""

from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import HiddenEffect, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class AsymmetricCoulomb(HiddenEffect):
    """Coulomb friction that differs between the directions."""

    summary = "Coulomb friction differs between the directions"
    same_law = ""

    half_difference_nm: float = strength(
        0.08, "half of Coulomb friction forward less backward", like="coulomb_half_difference_nm"
    )


@compiled()
def extra_nm(group: Record, sign: float) -> float:
    """Return what the Coulomb level gains in a direction of motion, +1 or -1; negative where it loses. [N m]

    Passive while the joint's Coulomb level is at least the half difference.
    """
    return float(group.half_difference_nm * sign)
