"""Asymmetric viscous friction: it grows faster with speed in one direction than in the other."""

from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class AsymmetricViscous:
    """Viscous friction that differs between the directions.

    Attributes:
        half_difference_nms_per_rad: Half of the viscous coefficient forward less the one backward. [N m s/rad]
    """

    half_difference_nms_per_rad: float = 0.0


@compiled()
def extra_nm(group: Any, sign: float, speed: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return what friction gains at a speed in a direction of motion, +1 or -1; negative where it loses. [N m]

    Passive while the joint's viscous coefficient is at least the half difference.
    """
    return float(group.half_difference_nms_per_rad * sign * speed)


EFFECT = Effect(
    name="asymmetric_viscous",
    family="velocity",
    summary="viscous friction differs between the directions",
    group=AsymmetricViscous,
    strength="half_difference_nms_per_rad",
    parameters=(
        Parameter(
            name="half_difference_nms_per_rad",
            usual=0.03,
            meaning="half of the viscous coefficient forward less backward [N m s/rad]",
            low=float("-inf"),
        ),
    ),
)
