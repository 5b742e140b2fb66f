"""What the compensators share: bounds of their numbers, passivity controller and limits, the ramped sign function."""

import math
from dataclasses import dataclass, field, fields, replace
from math import inf, isfinite
from typing import ClassVar, Self

from friction_audit.compiled import compiled
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class Numbers:
    """Settings whose plain numbers are finite, unless their default is infinite, and within bounds."""

    where: ClassVar[str] = "compensator"  # what messages call them
    positive: ClassVar[tuple[str, ...]] = ()  # names of numbers that must be above zero
    not_negative: ClassVar[tuple[str, ...]] = ()
    gains: ClassVar[tuple[str, ...]] = ()  # numbers to which the torque is proportional

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.type is not float:
                continue
            value, expected = getattr(self, item.name), "a finite number"
            holds = isfinite(value) or value == item.default == inf
            if item.name in self.positive:
                holds, expected = holds and value > 0.0, "a number above zero"
            elif item.name in self.not_negative:
                holds, expected = holds and value >= 0.0, "zero or more"
            if not holds:
                raise UsageError(f"{self.where}: {item.name} {value:g}: expected {expected}")

    def scaled(self, factor: float) -> Self:
        """Return them with their gains times a factor."""
        return replace(self, **{name: factor * getattr(self, name) for name in self.gains})


@dataclass(frozen=True, kw_only=True, slots=True)
class Guard(Numbers):
    """Passivity controller and limits around a law of any kind."""

    positive: ClassVar[tuple[str, ...]] = (
        "max_damping_nms_per_rad", "max_torque_nm", "max_torque_rate_nm_s", "minimum_speed_rad_s"
    )  # fmt: skip
    not_negative: ClassVar[tuple[str, ...]] = ("initial_energy_j", "payback_s")

    passivity: bool = False  # if True, the passivity controller acts
    initial_energy_j: float = 0.0  # E(0) of (21) [J]
    minimum_speed_rad_s: float = 0.01  # the passivity controller does nothing below this speed [rad/s]
    # time over which it pays a deficit of the ledger; below a tick, within a tick as (22) has it. [s] ``payback_s`` of
    # this module gives the time for an elastic joint; the default is right from 40 Hz on
    payback_s: float = 0.02
    # largest damping it may inject. [N m s/rad] It measures the link and brakes the motor, which in the elastic mode
    # move against each other: 16 N m s/rad already drive the mode of a motor of 0.1 kg m^2 with a link of 0.05 kg m^2;
    # the default is a third of that
    max_damping_nms_per_rad: float = 5.0
    max_torque_nm: float = inf  # largest torque of compensation and passivity controller together [N m]
    max_torque_rate_nm_s: float = inf  # fastest change of it [N m/s]


@dataclass(frozen=True, kw_only=True, slots=True)
class Law(Numbers):
    """A law with a guard around it; the records hold its plain numbers as a group of its own."""

    guard: Guard = field(default_factory=Guard)  # passivity controller and limits


def payback_s(mode_rad_s: float, damping_ratio: float) -> float:
    """Return the time over which a passivity controller may pay a deficit without driving an elastic mode. [s]

    The ledger integrates, so that the controller is a loop of crossover 1/tau, and the mode amplifies it by
    1/(2 zeta): tau > 1/(2 zeta w) keeps the loop gain below 1 at the mode, which is sufficient.
    """
    return max(Guard().payback_s, 1.0 / (2.0 * damping_ratio * mode_rad_s))


# Values of ``kind`` in the records.
NONE, FIXED, ENERGY, SIGMOID, LUGRE, DISTURBANCE_OBSERVER, TORQUE_REGULATION, JOINT_MODEL = range(8)


@compiled()
def soft_sign(dq: float, dead_band_rad_s: float, ramp_rad_s: float) -> float:
    """Return the sign of the velocity, 0 in the dead-band, with a ramp between."""
    beyond = abs(dq) - dead_band_rad_s
    if beyond <= 0.0:
        return 0.0
    return math.copysign(1.0 if beyond >= ramp_rad_s else beyond / ramp_rad_s, dq)
