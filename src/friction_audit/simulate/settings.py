"""What the simulator may be told: the joint, the hand that moves it, the sensors, what is hidden in the log."""

from dataclasses import dataclass, field, fields, replace

from friction_audit.errors import UsageError

SUBSTEPS = 10
"""Integration steps per sample of the joint's clock."""

MINIMUM_TICKS = 2
HIGHEST_SHARE = 0.5


def _require_positive(where: str, **numbers: float) -> None:
    for name, number in numbers.items():
        if not number > 0:
            raise UsageError(f"{where}: {name} {number:g}: expected a number above zero")


def _require_not_negative(where: str, **numbers: float) -> None:
    for name, number in numbers.items():
        if not number >= 0:
            raise UsageError(f"{where}: {name} {number:g}: expected zero or more")


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
        _require_positive("joint", inertia_kg_m2=self.inertia_kg_m2)
        _require_not_negative("joint", coulomb_nm=self.coulomb_nm, viscous_nms_per_rad=self.viscous_nms_per_rad)


@dataclass(frozen=True, kw_only=True, slots=True)
class Operator:
    """The person: a mass that holds the link rigidly, drawn by a spring and a damper along the intended motion.

    The intended motion is stop and go: minimum-jerk strokes with pauses between them, back and forth in a range.

    Attributes:
        inertia_kg_m2: Inertia on the hand's side of the sensor, link included. [kg m^2]
        stiffness_nm_per_rad: Spring between intended and actual motion. [N m/rad]
        damping_nms_per_rad: Damper between intended and actual motion. [N m s/rad]
        stroke_s: Shortest and longest duration of a stroke; its length follows from the peak speed. [s]
        speed_rad_s: Mean of the strokes' peak speeds. [rad/s]
        speed_spread: Coefficient of variation of the strokes' peak speeds.
        speed_limits_rad_s: No stroke has a slower or a faster peak. [rad/s]
        pause_s: Shortest and longest pause between two strokes. [s]
        range_rad: Lowest and highest position, relative to the start. [rad]
        reversing: Share of the strokes that turn back, where the range leaves the choice.
    """

    inertia_kg_m2: float = 0.3
    stiffness_nm_per_rad: float = 60.0
    damping_nms_per_rad: float = 9.0
    stroke_s: tuple[float, float] = (0.9, 1.8)
    speed_rad_s: float = 0.9
    speed_spread: float = 0.4
    speed_limits_rad_s: tuple[float, float] = (0.3, 1.8)
    pause_s: tuple[float, float] = (0.2, 0.7)
    range_rad: tuple[float, float] = (-1.2, 1.2)
    reversing: float = 0.8

    def __post_init__(self) -> None:
        """Check signs and the order of the pairs."""
        positive = ("inertia_kg_m2", "stiffness_nm_per_rad", "damping_nms_per_rad", "speed_rad_s")
        _require_positive("operator", **{name: getattr(self, name) for name in positive})
        _require_not_negative("operator", speed_spread=self.speed_spread, shortest_pause_s=self.pause_s[0])
        _require_positive("operator", shortest_stroke_s=self.stroke_s[0], slowest_rad_s=self.speed_limits_rad_s[0])
        for name in ("stroke_s", "speed_limits_rad_s", "pause_s", "range_rad"):
            low, high = getattr(self, name)
            if low > high:
                raise UsageError(f"operator: {name} {low:g}, {high:g}: expected the smaller number first")
        if not self.range_rad[0] <= 0 <= self.range_rad[1] or self.range_rad[0] == self.range_rad[1]:
            low, high = self.range_rad
            raise UsageError(f"operator: range_rad {low:g}, {high:g}: expected a range around the start at 0")


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
    position_step_rad: float = 0.0
    clock_jitter_s: float = 0.0
    stale: float = 0.0
    lost: float = 0.0
    longest_loss: int = 8

    def __post_init__(self) -> None:
        """Check signs and shares."""
        _require_not_negative("sensors", **{item.name: getattr(self, item.name) for item in fields(self)})
        if self.slow_noise_share > 1:
            raise UsageError(f"sensors: slow_noise_share {self.slow_noise_share:g}: expected a share from 0 to 1")
        if max(self.stale, self.lost) > HIGHEST_SHARE or self.longest_loss < 1:
            raise UsageError(
                f"sensors: stale {self.stale:g}, lost {self.lost:g}, longest_loss {self.longest_loss}: expected "
                f"shares up to {HIGHEST_SHARE:g} and a longest loss of at least 1"
            )


IDEAL_SENSORS = Sensors()

# Measured on a public 21 s log of a real Panda: noise, resolution, spacing (mean 1.02 ms, sd 0.19 ms with the losses,
# longest 8.8 ms) and 5.6 % repeated states. The correlation time cannot be told from vibration there: it is assumed.
_PANDA_PROXIMAL = Sensors(
    torque_noise_nm=0.055,
    torque_correlation_s=0.01,
    torque_step_nm=0.0357,
    velocity_noise_rad_s=0.0027,
    velocity_step_rad_s=1e-6,
    position_step_rad=1e-6,
    clock_jitter_s=0.125e-3,
    stale=0.056,
    lost=0.02,
)
_PANDA_DISTAL = replace(_PANDA_PROXIMAL, torque_noise_nm=0.03, torque_step_nm=0.006)
PANDA_SENSORS = (_PANDA_PROXIMAL,) * 4 + (_PANDA_DISTAL,) * 3
"""The sensors of a Panda's joints 1 to 7."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Compensation:
    """A friction compensator that was active: u = coulomb sgn(dq) + viscous dq outside the dead-band, else 0.

    It runs at the sampling rate and holds its torque from one sample to the next.

    Attributes:
        coulomb_nm: Coulomb friction compensated. [N m]
        viscous_nms_per_rad: Viscous friction compensated. [N m s/rad]
        dead_band_rad_s: Speed up to which it stays silent. [rad/s]
    """

    coulomb_nm: float
    viscous_nms_per_rad: float
    dead_band_rad_s: float = 0.02


@dataclass(frozen=True, kw_only=True, slots=True)
class JointSettings:
    """One joint, one person, one recording.

    Attributes:
        joint: The joint.
        operator: The person.
        sensors: The sensors.
        compensation: An active friction compensator whose torque is logged, or None.
        torque_offset_nm: Hidden error: added to the measured torque. [N m]
        gravity_error_nm: Hidden error: this times sin(q) is added to the measured torque. [N m]
        duration_s: Length of the recording. [s]
        rate_hz: Sampling rate. [Hz]
    """

    joint: JointParameters = field(default_factory=JointParameters)
    operator: Operator = field(default_factory=Operator)
    sensors: Sensors = PANDA_SENSORS[0]
    compensation: Compensation | None = None
    torque_offset_nm: float = 0.0
    gravity_error_nm: float = 0.0
    duration_s: float = 120.0
    rate_hz: float = 1000.0

    def __post_init__(self) -> None:
        """Check the length of the recording."""
        _require_positive("simulation", duration_s=self.duration_s, rate_hz=self.rate_hz)
        if self.ticks < MINIMUM_TICKS:
            raise UsageError(
                f"simulation: {self.duration_s:g} s at {self.rate_hz:g} Hz: expected at least {MINIMUM_TICKS} samples"
            )

    @property
    def ticks(self) -> int:
        """Number of sampling intervals."""
        return round(self.duration_s * self.rate_hz)
