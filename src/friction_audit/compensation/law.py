"""Settings that all compensators share: bounds, passivity controller, limits; and the compensator of the paper."""

import math
import sys
from dataclasses import dataclass, field, fields, replace
from functools import partial
from math import inf, ulp
from typing import Any, ClassVar, Self, dataclass_transform

from friction_audit.compiled import compiled
from friction_audit.errors import UsageError, kind_name

MODELS = {"viscous": 1, "coulomb": 1, "combined": 2}  # coefficients of each
LONGEST_WINDOW = 64  # cycles that the state of a compensator can hold
# Values of ``ridge``. Below 0.001, noise still separates two cycles of one speed; above 0.003, the estimate needs more
# than two cycles to follow a step of friction (benchmarks/bench_compensation.py).
RIDGE, NO_RIDGE = 0.003, 0.0
ABOVE_ZERO, FINITE = ulp(0.0), sys.float_info.max  # the smallest positive number, and the largest


def within(usual: Any = 0.0, low: float = 0.0, high: float = FINITE) -> Any:  # noqa: ANN401 - the field of a dataclass
    """Return a field for a number in [low, high], or several in rising order; ``usual`` is MISSING where required."""
    return field(default=usual, metadata={"within": (low, high)})


positive = partial(within, low=ABOVE_ZERO)  # a field that holds a number above zero


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
@dataclass(frozen=True, kw_only=True)
class Checked:
    """Settings whose constructor checks the bounds of their fields; a subclass becomes a frozen dataclass."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if "within" not in item.metadata or value is None:
                continue
            low, high = item.metadata["within"]
            numbers = value if isinstance(value, tuple) else (value,)
            expected = "the smaller number first" if list(numbers) != sorted(numbers) else ""
            if not all(low <= number <= high for number in numbers):
                least = {ABOVE_ZERO: "a number above zero", 0.0: "zero or more", -FINITE: "finite numbers"}
                from_low = least.get(low, f"{low:g} or more")
                expected = from_low if high >= FINITE else f"a number from {low:g} to {high:g}"
            if expected:
                where = kind_name(type(self)).removesuffix("_settings").removesuffix("_parameters")
                found = ", ".join(f"{number:g}" for number in numbers)
                raise UsageError(f"{where}: {item.name} {found}: expected {expected}")


class CompensatorSettings(Checked):
    """Settings of a compensator: those of its law, of its passivity controller and the limits of its torque."""

    name: ClassVar[str]  # as in options, tables and documentation; also its field in SETTINGS
    summary: ClassVar[str]  # one line
    gains: ClassVar[tuple[str, ...]] = ()  # names of the numbers that its torque is proportional to

    passivity: bool = False  # if True, the passivity controller acts
    initial_energy_j: float = within(0.0)  # E(0) of (21) [J]
    minimum_speed_rad_s: float = positive(0.01)  # the passivity controller does nothing below this speed [rad/s]
    # time over which the controller dissipates an energy deficit; below a tick, within a tick as in (22). [s]
    # ``payback_s`` of this module gives the time for an elastic joint; the default is right from 40 Hz on
    payback_s: float = within(0.02)
    # largest damping it may inject. [N m s/rad] It reads the velocity of the link and brakes the motor; in the elastic
    # mode these move against each other: 16 N m s/rad already destabilise a motor of 0.1 kg m^2 with a link of
    # 0.05 kg m^2; the default is a third of that
    max_damping_nms_per_rad: float = positive(5.0)
    max_torque_nm: float = positive(inf, high=inf)  # of compensation and passivity controller together [N m]
    max_torque_rate_nm_s: float = positive(inf, high=inf)  # fastest change of it [N m/s]

    def scaled(self, factor: float) -> Self:
        """Return the compensator with its gains times a factor."""
        return replace(self, **{name: factor * getattr(self, name) for name in self.gains})


@dataclass(frozen=True, kw_only=True, slots=True)
class Coefficients:
    """Friction coefficients of one joint."""

    coulomb_nm: float = 0.0  # Coulomb friction [N m]
    viscous_nms_per_rad: float = 0.0  # viscous friction [N m s/rad]


class EnergyCompensator(CompensatorSettings):
    """The compensator of the paper: it estimates at the end of each energy cycle and applies the estimate in the next.

    The Coulomb term is zero up to ``dead_band_rad_s`` and rises linearly over the next ``ramp_rad_s``. The velocity is
    sampled and carries noise: at standstill its sign function would flip between plus and minus the whole coefficient.
    With the ramp the Coulomb term does not exceed the friction, so that the residual is still friction, and its slope,
    a negative damping, stays small against inertia over tick.
    """

    name, gains = "energy", ("factor",)
    summary = "the paper's: Coulomb and viscous friction from the energy of past cycles"

    model: str = "combined"  # ``"viscous"`` (8), ``"coulomb"`` (14) or ``"combined"`` (20)
    window: int | None = None  # number k of cycles per estimate; None for the fewest: 1, or 2 with ``"combined"``
    # weight of the ridge regression (Hoerl and Kennard 1970) of the combined model towards the coefficients in use;
    # ``NO_RIDGE`` for (20) as printed, which divides by the difference of two cycles
    ridge: float = within(RIDGE)
    minimum_path_rad: float = positive(0.02)  # a cycle in which the joint moved less gives no equation [rad]
    maximum_gap_s: float = positive(0.05)  # a cycle with a longer gap between two ticks gives no equation [s]
    # the estimate is multiplied by this before it is applied; above 1, over-compensation on purpose
    factor: float = within(1.0)
    # speed up to which the Coulomb term is zero and the joint counts as at rest [rad/s]
    dead_band_rad_s: float = within(0.01)
    ramp_rad_s: float = within(0.03)  # range of speed over which the Coulomb term then rises to its full value [rad/s]
    forced: Coefficients | None = None  # coefficients applied, instead of the estimate, or None
    forced_from_cycle: int = 2  # first cycle in which they are applied; cycles count from 1
    # if True, the estimate takes over after the first cycle in which the passivity controller acted
    forced_until_acted: bool = True
    # if True, cycles end where the measured velocity changes its sign, without filter and thresholds: for signals
    # free of noise
    zero_crossings: bool = False
    initiation_rad_s: float = 0.2  # filtered speed above which a cycle begins [rad/s]
    termination_rad_s: float = 0.05  # filtered speed below which it may end; it ends when the joint then rests [rad/s]
    # corner of the causal first-order low-pass on the velocity, for detection only [Hz]
    cutoff_hz: float = positive(20.0)
    passivity: bool = True

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise UsageError(f"compensator: model {self.model}: expected one of {', '.join(MODELS)}")
        if not MODELS[self.model] <= self.cycles_per_estimate <= LONGEST_WINDOW:
            expected = f"{MODELS[self.model]} to {LONGEST_WINDOW} cycles with the {self.model} model"
            raise UsageError(f"compensator: window {self.window}: expected {expected}")
        if not inf > self.initiation_rad_s > self.termination_rad_s > 0:
            found = f"thresholds {self.initiation_rad_s:g}, {self.termination_rad_s:g}"
            raise UsageError(f"compensator: {found}: expected initiation above termination, both above zero, in rad/s")
        if self.forced_from_cycle < 1:
            raise UsageError(f"compensator: forced_from_cycle {self.forced_from_cycle}: cycles count from 1")
        CompensatorSettings.__post_init__(self)

    @property
    def cycles_per_estimate(self) -> int:
        """Number k of cycles per estimate."""
        return MODELS[self.model] if self.window is None else self.window


def payback_s(mode_rad_s: float, damping_ratio: float) -> float:
    """Return the time over which a passivity controller may dissipate a deficit without exciting an elastic mode. [s]

    The observed energy is an integral, so that the controller is a loop with crossover 1/tau, and the mode amplifies it
    by 1/(2 zeta): tau > 1/(2 zeta w) keeps the loop gain below 1 at the mode, which is sufficient.
    """
    return max(CompensatorSettings.payback_s, 1.0 / (2.0 * damping_ratio * mode_rad_s))


# Values of ``kind`` in the records.
NONE, FIXED, ENERGY, SIGMOID, LUGRE, DISTURBANCE_OBSERVER, TORQUE_REGULATION, JOINT_MODEL = range(8)


@compiled()
def soft_sign(dq: float, dead_band_rad_s: float, ramp_rad_s: float) -> float:
    """Return the sign of the velocity: 0 in the dead-band, and a ramp from there to -1 or 1."""
    beyond = abs(dq) - dead_band_rad_s
    if beyond <= 0.0:
        return 0.0
    return math.copysign(1.0 if beyond >= ramp_rad_s else beyond / ramp_rad_s, dq)
