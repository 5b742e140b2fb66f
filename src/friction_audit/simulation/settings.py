"""Checks that settings share, the joint, its sensors, and the clock of a recording."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.compensation.compensators import Compensator, guard_of
from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from friction_audit.simulation.effects import Hidden

CONTROL_RATE_HZ = 1000.0  # at which the controller reads its sensors and sets its torques
FEWEST_TICKS = 2
LONGEST_S = 7200.0  # every tick is kept in memory: two hours of one joint take about a gigabyte

HIGHEST_SHARE = 0.5
LONGEST_DEAD_TIME_S = 0.005  # five ticks; a state of a joint remembers so much of its torque control
LARGEST = 1e3  # no error of a sensor comes near it, in any unit
FINEST_STEP = 1e-9  # readings are kept to so many places (``sensors.SCALE``)


def require_positive(where: str, **numbers: float) -> None:
    """Refuse numbers that are not finite and above zero."""
    for name, number in numbers.items():
        if not 0 < number < inf:
            raise UsageError(f"{where}: {name} {number:g}: expected a number above zero")


def require_within(where: str, low: float, high: float, **numbers: float) -> None:
    """Refuse numbers outside of [low, high]."""
    for name, number in numbers.items():
        if not low <= number <= high or number == inf:
            least = "zero or more" if low == 0 else f"{low:g} or more"
            expected = least if high == inf else f"a number from {low:g} to {high:g}"
            raise UsageError(f"{where}: {name} {number:g}: expected {expected}")


def require_order(where: str, **pairs: tuple[float, float]) -> None:
    """Refuse pairs that do not put the smaller of two finite numbers first."""
    for name, (low, high) in pairs.items():
        if not -inf < low <= high < inf:
            raise UsageError(f"{where}: {name} {low:g}, {high:g}: expected the smaller number first")


def require_hand(where: str, hand: str, hidden: "Iterable[Hidden]", compensator: object) -> None:
    """Refuse what takes a person's hand where motors move the joints."""
    if any(inside.unlogged_compensation.share != 0.0 for inside in hidden):
        raise UsageError(
            f"{where}: unlogged_compensation takes {hand}: where motors move the joints, the sensors read all that "
            "they give; expected driven=false"
        )
    if compensator is not None:
        raise UsageError(f"{where}: a friction compensator takes {hand}; expected driven=false")


def count_ticks(duration_s: float, rate_hz: float) -> int:
    """Return the number of the controller's ticks in a recording, after checking its length and its rate."""
    require_positive("simulation", duration_s=duration_s, rate_hz=rate_hz)
    if rate_hz > CONTROL_RATE_HZ:
        raise UsageError(
            f"simulation: rate_hz {rate_hz:g}: expected at most {CONTROL_RATE_HZ:g}, the rate of the controller"
        )
    if duration_s > LONGEST_S:
        raise UsageError(f"simulation: duration_s {duration_s:g}: expected at most {LONGEST_S:g}; make several logs")
    if duration_s * rate_hz < FEWEST_TICKS:
        raise UsageError(
            f"simulation: {duration_s:g} s at {rate_hz:g} Hz: expected at least {FEWEST_TICKS} sampling intervals"
        )
    return round(duration_s * CONTROL_RATE_HZ)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Streams:
    """The random streams of one simulation."""

    person: np.random.Generator  # draws the motion
    sensors: np.random.Generator  # draws the noise of the sensors
    recorder: np.random.Generator  # draws losses and jitter
    events: tuple[np.random.Generator, ...]  # draw the contact events, one per joint
    drifts: tuple[np.random.Generator, ...]  # draw the torque drifts, one per joint


def make_streams(seed: int, joints: int) -> Streams:
    """Return the streams of a seed."""
    *first, hidden = np.random.SeedSequence(seed).spawn(4)
    person, sensors, recorder = (np.random.default_rng(part) for part in first)
    parts = [np.random.default_rng(part) for part in hidden.spawn(2 * joints)]
    return Streams(
        person=person, sensors=sensors, recorder=recorder, events=tuple(parts[::2]), drifts=tuple(parts[1::2])
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueLoop:
    """Joint torque control: tau_m = tau_d + gain (tau_d - tau_J) - damping_s d(tau_J)/dt, what is fed back delayed.

    The link then sees a motor of B / (1 + gain) with friction tau_f / (1 + gain) (A. Albu-Schaeffer, C. Ott, G.
    Hirzinger, International Journal of Robotics Research 26(1), 2007). tau_J is the torque of the gear's spring, free
    of noise; tau_d gravity compensation and u.
    """

    gain: float = 0.0  # of the torque error; 0 for no torque control
    # of the derivative of the torque. Against a link held fast the loop rings without end, to first order in the dead
    # time, where it is below gain times dead time [s]
    damping_s: float = 0.0
    dead_time_s: float = 0.0  # from the torque to the motor, in steps of 0.1 ms [s]

    def __post_init__(self) -> None:
        require_within("torque loop", 0, LARGEST, gain=self.gain, damping_s=self.damping_s)
        require_within("torque loop", 0, LONGEST_DEAD_TIME_S, dead_time_s=self.dead_time_s)


@dataclass(frozen=True, kw_only=True, slots=True)
class JointParameters:
    """The joint on the motor's side of the torque sensor: B ddq = F_m + u - tau_f."""

    inertia_kg_m2: float = 0.3  # reflected inertia B [kg m^2]
    coulomb_nm: float = 0.30  # coulomb friction, static and sliding [N m]
    viscous_nms_per_rad: float = 0.07  # viscous friction [N m s/rad]
    # joint torque control; takes an elastic joint that a hand moves
    torque_loop: TorqueLoop = field(default_factory=TorqueLoop)

    def __post_init__(self) -> None:
        require_positive("joint", inertia_kg_m2=self.inertia_kg_m2)
        require_within("joint", 0, inf, coulomb_nm=self.coulomb_nm, viscous_nms_per_rad=self.viscous_nms_per_rad)

    @property
    def at_link(self) -> "JointParameters":
        """What the link sees of it through its torque control."""
        left = 1.0 / (1.0 + self.torque_loop.gain)
        return JointParameters(
            inertia_kg_m2=left * self.inertia_kg_m2,
            coulomb_nm=left * self.coulomb_nm,
            viscous_nms_per_rad=left * self.viscous_nms_per_rad,
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Sensors:
    """What the sensors and the recorder do to the truth; every default is an ideal one."""

    torque_noise_nm: float = 0.0  # standard deviation of the torque noise [N m]
    torque_correlation_s: float = 0.0  # time after which its autocorrelation has fallen to 1/e [s]
    slow_noise_share: float = 0.0  # share of its variance that wanders more slowly
    slow_correlation_s: float = 0.05  # time after which the autocorrelation of the slower part has fallen to 1/e [s]
    torque_step_nm: float = 0.0  # resolution of the torque, 0 for none [N m]
    velocity_noise_rad_s: float = 0.0  # standard deviation of the velocity noise, white [rad/s]
    velocity_step_rad_s: float = 0.0  # resolution of the velocity [rad/s]
    position_noise_rad: float = 0.0  # standard deviation of the position noise, white [rad]
    position_step_rad: float = 0.0  # resolution of the position [rad]
    clock_jitter_s: float = 0.0  # standard deviation of the spacing of the stamps, losses aside [s]
    stale: float = 0.0  # share of the samples that repeat the one before
    lost: float = 0.0  # share of the samples that were never recorded
    longest_loss: int = 8  # once in a recording so many samples in a row are lost, else one at a time

    def __post_init__(self) -> None:
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
PANDA_SENSORS = (_PANDA_PROXIMAL,) * 4 + (_PANDA_DISTAL,) * 3  # of joints 1 to 7


@dataclass(frozen=True, kw_only=True, slots=True)
class JointByJoint:
    """Compensators that differ from joint to joint."""

    compensators: tuple[Compensator, ...]  # one per joint

    def scaled(self, factor: float) -> "JointByJoint":
        """Return them with their gains times a factor."""
        each: tuple[Any, ...] = self.compensators
        return JointByJoint(compensators=tuple(one.scaled(factor) for one in each))


AnyCompensator = Compensator | JointByJoint  # what runs in an arm; None where nothing does


def of_each_joint(compensator: AnyCompensator | None, joints: int) -> tuple[Compensator | None, ...]:
    """Return what runs in each joint."""
    if not isinstance(compensator, JointByJoint):
        return (compensator,) * joints
    if len(compensator.compensators) != joints:
        raise UsageError(f"joint by joint: {len(compensator.compensators)} compensators: expected {joints}")
    return compensator.compensators


def any_guards(compensator: AnyCompensator | None) -> bool:
    """Return True if a passivity controller acts in some joint."""
    several = compensator.compensators if isinstance(compensator, JointByJoint) else (compensator,)
    return any(guard_of(one).passivity for one in several)
