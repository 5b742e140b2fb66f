"""Output torque regulation with inertia shaping: the measured torque fed back makes motor and friction smaller.

A. Albu-Schaeffer, C. Ott, G. Hirzinger: A unified passivity-based control framework for position, torque and impedance
control of flexible joint robots, International Journal of Robotics Research 26(1), 2007.
"""

import math
from dataclasses import dataclass, field
from typing import Any

from friction_audit.compensation.compensators.law import Guard, numbers_of, require_finite, require_positive
from friction_audit.compiled import compiled


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRegulation:
    """u = (B / B_theta - 1) F_m, so that B_theta ddq = F_m - (B_theta / B) tau_f.

    The torque does not depend on the velocity: nothing chatters at standstill, and a joint breaks away at B_theta / B
    of its friction.

    Raises:
        UsageError: If a number is not above zero.
    """

    inertia_kg_m2: float  # motor inertia B as assumed [kg m^2]
    desired_inertia_kg_m2: float  # B_theta; above B the joint gets heavier [kg m^2]
    cutoff_hz: float = math.inf  # corner of the first-order low-pass on F_m; infinite for none [Hz]
    guard: Guard = field(default_factory=Guard)  # passivity controller and limits

    def __post_init__(self) -> None:
        require_positive("torque regulation", self, *(GROUP.names or ()))
        require_finite("torque regulation", self, "inertia_kg_m2", "desired_inertia_kg_m2")

    @property
    def torque_gain(self) -> float:
        """B / B_theta - 1."""
        return self.inertia_kg_m2 / self.desired_inertia_kg_m2 - 1.0


GROUP = numbers_of(TorqueRegulation)


@compiled()
def advance(group: Any, memory: Any, interaction_nm: float, dt: float) -> None:  # noqa: ANN401 - records
    """Filter the torque just read; the first one is taken as it is."""
    share = 1.0 if memory.ticks == 0 else -math.expm1(-2.0 * math.pi * group.cutoff_hz * dt)
    memory.filtered_interaction_nm += share * (interaction_nm - memory.filtered_interaction_nm)


@compiled()
def torque_nm(group: Any, memory: Any) -> float:  # noqa: ANN401 - records
    """Return the torque that shapes the inertia. [N m]"""
    return float((group.inertia_kg_m2 / group.desired_inertia_kg_m2 - 1.0) * memory.filtered_interaction_nm)
