"""Asymmetric Coulomb friction: more of it in one direction than in the other."""

from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class AsymmetricCoulomb:
    """Coulomb friction that differs between the directions.

    Attributes:
        half_difference_nm: Half of the Coulomb level forward less the level backward. [N m]
    """

    half_difference_nm: float = 0.0


@compiled()
def extra_nm(group: Any, sign: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return what the Coulomb level gains in a direction of motion, +1 or -1; negative where it loses. [N m]

    Passive while the joint's Coulomb level is at least the half difference.
    """
    return float(group.half_difference_nm * sign)


EFFECT = Effect(
    name="asymmetric_coulomb",
    family="velocity",
    summary="Coulomb friction differs between the directions",
    group=AsymmetricCoulomb,
    strength="half_difference_nm",
    parameters=(
        Parameter(
            name="half_difference_nm",
            usual=0.08,
            meaning="half of Coulomb friction forward less backward [N m]",
            low=float("-inf"),
        ),
    ),
)
