"""What stands between the law of a compensator and the joint: passivity controller and torque limits."""

from dataclasses import dataclass
from math import inf

from friction_audit.replay.compensators.check import require_not_negative, require_positive


@dataclass(frozen=True, kw_only=True, slots=True)
class Guard:
    """Passivity controller and limits around a law of any kind.

    Attributes:
        passivity: If True, the passivity controller acts.
        initial_energy_j: E(0) of (21). [J]
        controller_in_interaction: If True, the interaction torque was measured while the passivity controller acted
            and the port energy (2) contains what it dissipated, as in every closed loop. False for a recording made
            without it: the ledger then adds what it would have dissipated, lest the same deficit be paid for again.
        minimum_speed_rad_s: The passivity controller does nothing below this speed. [rad/s]
        max_damping_nms_per_rad: Largest damping it may inject. [N m s/rad] A damper held for a tick brakes a mass m
            without overshoot up to m over the tick; the default is half of that for 0.1 kg m^2 at 1 kHz.
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
