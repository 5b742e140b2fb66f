"""LuGre friction as a model-based compensator: bristles of its own, driven by the measured velocity.

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky: A new model for control of systems with friction, IEEE
Transactions on Automatic Control 40(3), 1995. Passivity: N. Barahanov, R. Ortega, Necessary and sufficient conditions
for passivity of the LuGre friction model, IEEE Transactions on Automatic Control 45(4), 2000.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

from friction_audit.compensation.compensators.law import (
    Guard,
    numbers_of,
    require_finite,
    require_not_negative,
    require_positive,
)
from friction_audit.compiled import compiled
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class LugreCompensation:
    """u = sigma0 z + sigma1 dz/dt + sigma2 dq, with dz/dt = dq - sigma0 |dq| z / g(dq).

    g(dq) = Fc + (Fs - Fc) exp(-(dq/vs)^2). At standstill the bristles hold their torque; in a tick it changes by no
    more than sigma0 times the displacement, so that noise of the velocity does not make it chatter.

    Raises:
        UsageError: If a number is out of range.
    """

    coulomb_nm: float  # fc [N m]
    breakaway_nm: float  # fs [N m]
    viscous_nms_per_rad: float  # sigma2 [N m s/rad]
    stribeck_rad_s: float = 0.05  # vs [rad/s]
    stiffness_nm_per_rad: float = 300.0  # sigma0 [N m/rad]
    damping_nms_per_rad: float = 0.0  # sigma1 [N m s/rad]
    guard: Guard = field(default_factory=Guard)  # passivity controller and limits

    def __post_init__(self) -> None:
        require_finite("LuGre compensation", self, *(GROUP.names or ()))
        require_positive("LuGre compensation", self, "coulomb_nm", "stribeck_rad_s", "stiffness_nm_per_rad")
        require_not_negative("LuGre compensation", self, "viscous_nms_per_rad", "damping_nms_per_rad")
        if self.breakaway_nm < self.coulomb_nm:
            raise UsageError(
                f"LuGre compensation: breakaway_nm {self.breakaway_nm:g}: expected coulomb_nm {self.coulomb_nm:g} "
                f"or more"
            )

    def scaled(self, factor: float) -> Self:
        """Return it with every torque times a factor."""
        torques = ("coulomb_nm", "breakaway_nm", "viscous_nms_per_rad", "stiffness_nm_per_rad", "damping_nms_per_rad")
        return replace(self, **{name: factor * getattr(self, name) for name in torques})


GROUP = numbers_of(LugreCompensation)


@compiled()
def level_nm(group: Any, dq: float) -> float:  # noqa: ANN401 - a record
    """Return g(dq), the friction of steady sliding without its viscous part. [N m]"""
    ratio = dq / group.stribeck_rad_s
    return float(group.coulomb_nm + (group.breakaway_nm - group.coulomb_nm) * math.exp(-ratio * ratio))


@compiled()
def advance(group: Any, memory: Any, dq: float, dt: float) -> None:  # noqa: ANN401 - records
    """Bend the bristles over the past interval; exact for the mean of the two velocities.

    An explicit step is unstable as soon as sigma0 |dq| dt > 2 g, which the speeds of an arm reach.
    """
    mean = 0.5 * (memory.dq + dq)
    level = level_nm(group, mean)
    steady = math.copysign(level / group.stiffness_nm_per_rad, mean)
    share = -math.expm1(-group.stiffness_nm_per_rad * abs(mean) * dt / level)
    memory.bristle_rad += share * (steady - memory.bristle_rad)


@compiled()
def torque_nm(group: Any, memory: Any, dq: float) -> float:  # noqa: ANN401 - records
    """Return the torque that aids the motion. [N m]"""
    rate = dq - group.stiffness_nm_per_rad * abs(dq) * memory.bristle_rad / level_nm(group, dq)
    elastic = group.stiffness_nm_per_rad * memory.bristle_rad
    return float(elastic + group.damping_nms_per_rad * rate + group.viscous_nms_per_rad * dq)
