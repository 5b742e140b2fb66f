"""What stands between the law of a compensator and the joint: passivity controller and torque limits."""

from dataclasses import dataclass
from math import inf

from friction_audit.replay.compensators.check import require_not_negative, require_positive


@dataclass(frozen=True, kw_only=True, slots=True)
class Guard:
    """Passivity controller and limits, as the compensator of the paper has them, around a law of any other kind.

    Attributes:
        passivity: If True, the passivity controller acts.
        initial_energy_j: E(0) of (21). [J]
        controller_in_interaction: As in ``EnergyCompensator``.
        minimum_speed_rad_s: The passivity controller does nothing below this speed. [rad/s]
        max_damping_nms_per_rad: Largest damping it may inject. [N m s/rad]
        max_torque_nm: Largest torque of compensation and passivity controller together. [N m]
        max_torque_rate_nm_s: Fastest change of it. [N m/s]

    Raises:
        UsageError: If a number is out of range.
    """

    passivity: bool = False
    initial_energy_j: float = 0.0
    controller_in_interaction: bool = True
    minimum_speed_rad_s: float = 0.01
    max_damping_nms_per_rad: float = 50.0
    max_torque_nm: float = inf
    max_torque_rate_nm_s: float = inf

    def __post_init__(self) -> None:
        """Check the ranges."""
        require_not_negative("compensator", self, "initial_energy_j")
        require_positive("compensator", self, "minimum_speed_rad_s", "max_damping_nms_per_rad")
        require_positive("compensator", self, "max_torque_nm", "max_torque_rate_nm_s")
