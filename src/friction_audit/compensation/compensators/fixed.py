"""Coulomb and viscous friction that are given: with the true values, an oracle."""

import math
from dataclasses import dataclass, replace
from typing import Any, Self

from friction_audit.compiled import compiled
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class FixedCompensation:
    """A compensator that never learns: u = coulomb sgn(dq) + viscous dq outside the dead-band, else 0."""

    coulomb_nm: float  # Coulomb friction compensated [N m]
    viscous_nms_per_rad: float  # viscous friction compensated [N m s/rad]
    dead_band_rad_s: float = 0.02  # speed up to which it stays silent [rad/s]

    def __post_init__(self) -> None:
        if not self.dead_band_rad_s >= 0:
            raise UsageError(f"fixed compensation: dead_band_rad_s {self.dead_band_rad_s:g}: expected zero or more")

    def scaled(self, factor: float) -> Self:
        """Return it with every torque times a factor."""
        return replace(self, coulomb_nm=factor * self.coulomb_nm, viscous_nms_per_rad=factor * self.viscous_nms_per_rad)


@compiled()
def torque_nm(settings: Any, memory: Any, dq: float) -> float:  # noqa: ANN401 - records
    """Return the torque that aids the motion. [N m]"""
    share = 1.0 if abs(dq) > settings.dead_band_rad_s else 0.0
    return float(share * (memory.coulomb_nm * math.copysign(1.0, dq) + memory.viscous_nms_per_rad * dq))
