"""Asymmetric viscous friction: it grows faster with speed in one direction than in the other."""

from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import HiddenEffect, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class AsymmetricViscous(HiddenEffect):
    """Viscous friction that differs between the directions."""

    summary = "viscous friction differs between the directions"
    same_law = ""

    half_difference_nms_per_rad: float = strength(
        0.03, "half of the viscous coefficient forward less backward", like="viscous_half_difference_nms_per_rad"
    )


@compiled()
def extra_nm(group: Record, sign: float, speed: float) -> float:
    """Return what friction gains at a speed in a direction of motion, +1 or -1; negative where it loses. [N m]

    Passive while the joint's viscous coefficient is at least the half difference.
    """
    return float(group.half_difference_nms_per_rad * sign * speed)
