"""Checks that the settings of the motions share."""

from dataclasses import dataclass, fields, replace
from math import inf

from friction_audit.errors import UsageError


def require_positive(where: str, **numbers: float) -> None:
    """Refuse numbers that are not finite and above zero.

    Raises:
        UsageError: At the first such number.
    """
    for name, number in numbers.items():
        if not 0 < number < inf:
            raise UsageError(f"{where}: {name} {number:g}: expected a number above zero")


def require_within(where: str, low: float, high: float, **numbers: float) -> None:
    """Refuse numbers outside of [low, high].

    Raises:
        UsageError: At the first such number.
    """
    for name, number in numbers.items():
        if not low <= number <= high or number == inf:
            least = "zero or more" if low == 0 else f"{low:g} or more"
            expected = least if high == inf else f"a number from {low:g} to {high:g}"
            raise UsageError(f"{where}: {name} {number:g}: expected {expected}")


def require_order(where: str, **pairs: tuple[float, float]) -> None:
    """Refuse pairs that do not put the smaller of two finite numbers first.

    Raises:
        UsageError: At the first such pair.
    """
    for name, (low, high) in pairs.items():
        if not -inf < low <= high < inf:
            raise UsageError(f"{where}: {name} {low:g}, {high:g}: expected the smaller number first")


def require_room(where: str, range_rad: tuple[float, float], low: float, high: float) -> None:
    """Refuse a range about the start at 0 that leaves less room than low below it and high above it.

    Raises:
        UsageError: If it does.
    """
    if -range_rad[0] < low or range_rad[1] < high:
        raise UsageError(
            f"{where}: range_rad {range_rad[0]:g}, {range_rad[1]:g}: expected a range around the start at 0, "
            f"from {-low:g} or less to {high:g} or more"
        )


HIGHEST_SHARE = 0.5

LARGEST = 1e3
"""What no error of a sensor comes near, in whatever unit."""

FINEST_STEP = 1e-9
"""Readings are kept to so many places (``sensors.BINARY_NOISE_DIGITS``): a finer resolution cannot be told."""


@dataclass(frozen=True, kw_only=True, slots=True)
class JointParameters:
    """The joint behind the torque sensor: B ddq = F_m + u - tau_f.

    Attributes:
        inertia_kg_m2: Reflected inertia B behind the sensor. [kg m^2]
        coulomb_nm: Coulomb friction, static and sliding. [N m]
        viscous_nms_per_rad: Viscous friction. [N m s/rad]
    """

    inertia_kg_m2: float = 0.3
    coulomb_nm: float = 0.30
    viscous_nms_per_rad: float = 0.07

    def __post_init__(self) -> None:
        """Check that the joint is passive."""
        require_positive("joint", inertia_kg_m2=self.inertia_kg_m2)
        require_within("joint", 0, inf, coulomb_nm=self.coulomb_nm, viscous_nms_per_rad=self.viscous_nms_per_rad)


@dataclass(frozen=True, kw_only=True, slots=True)
class Sensors:
    """What the sensors and the recorder do to the truth; every default is an ideal one.

    Attributes:
        torque_noise_nm: Standard deviation of the torque noise. [N m]
        torque_correlation_s: Time after which its autocorrelation has fallen to 1/e. [s]
        slow_noise_share: Share of its variance that wanders more slowly.
        slow_correlation_s: Time after which the autocorrelation of the slower part has fallen to 1/e. [s]
        torque_step_nm: Resolution of the torque, 0 for none. [N m]
        velocity_noise_rad_s: Standard deviation of the velocity noise, white. [rad/s]
        velocity_step_rad_s: Resolution of the velocity. [rad/s]
        position_noise_rad: Standard deviation of the position noise, white. [rad]
        position_step_rad: Resolution of the position. [rad]
        clock_jitter_s: Standard deviation of the spacing of the stamps, losses aside. [s]
        stale: Share of the samples that repeat the one before.
        lost: Share of the samples that were never recorded.
        longest_loss: Once in a recording so many samples in a row are lost, else one at a time.
    """

    torque_noise_nm: float = 0.0
    torque_correlation_s: float = 0.0
    slow_noise_share: float = 0.0
    slow_correlation_s: float = 0.05
    torque_step_nm: float = 0.0
    velocity_noise_rad_s: float = 0.0
    velocity_step_rad_s: float = 0.0
    position_noise_rad: float = 0.0
    position_step_rad: float = 0.0
    clock_jitter_s: float = 0.0
    stale: float = 0.0
    lost: float = 0.0
    longest_loss: int = 8

    def __post_init__(self) -> None:
        """Check signs and shares."""
        numbers = {item.name: getattr(self, item.name) for item in fields(self)}
        require_within("sensors", 0, LARGEST, **numbers)
        for name, number in numbers.items():
            if "_step_" in name and 0 < number < FINEST_STEP:
                raise UsageError(f"sensors: {name} {number:g}: expected 0, for none, or at least {FINEST_STEP:g}")
        if self.slow_noise_share > 1:
            raise UsageError(f"sensors: slow_noise_share {self.slow_noise_share:g}: expected a share from 0 to 1")
        if max(self.stale, self.lost) > HIGHEST_SHARE or self.longest_loss < 1:
            raise UsageError(
                f"sensors: stale {self.stale:g}, lost {self.lost:g}, longest_loss {self.longest_loss}: expected "
                f"shares up to {HIGHEST_SHARE:g} and a longest loss of at least 1"
            )


IDEAL_SENSORS = Sensors()

# Measured on a public 21 s log of a real Panda: noise, resolution, spacing (mean 1.02 ms, sd 0.19 ms with the losses,
# longest 8.8 ms) and 5.6 % repeated states. The torque noise is white there but for vibration; that a tenth of its
# variance wanders slowly is assumed.
_PANDA_PROXIMAL = Sensors(
    torque_noise_nm=0.055,
    slow_noise_share=0.1,
    torque_step_nm=0.0357,
    velocity_noise_rad_s=0.0027,
    velocity_step_rad_s=1e-6,
    position_noise_rad=4e-6,
    position_step_rad=1e-6,
    clock_jitter_s=0.125e-3,
    stale=0.056,
    lost=0.02,
)
_PANDA_DISTAL = replace(_PANDA_PROXIMAL, torque_noise_nm=0.03, torque_step_nm=0.006)
PANDA_SENSORS = (_PANDA_PROXIMAL,) * 4 + (_PANDA_DISTAL,) * 3
"""The sensors of a Panda's joints 1 to 7."""
