"""Settings of a joint, its sensors and its recording, with their checks; the result of a simulation."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.law import Checked, positive, within
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.joint_log import Float, JointLog

CONTROL_RATE_HZ = 1000.0  # at which the controller reads its sensors and sets its torques
LONGEST_S = 7200.0  # every tick is kept in memory: two hours of one joint take about a gigabyte

LONGEST_DEAD_TIME_S = 0.005  # five ticks; a state of a joint remembers so much of its torque control
LARGEST = 1e3  # no error of a sensor comes near it, in any unit
FINEST_STEP = 1e-9  # readings are kept to so many places (``sensors.SCALE``)

SomeSettings: TypeAlias = Any  # of a bench, of one joint of a Panda or of an arm, whose modules import this one


def count_ticks(duration_s: float, rate_hz: float) -> int:
    """Return the number of the controller's ticks in a recording, after checking that it is long enough."""
    if duration_s * rate_hz < 2.0:  # noqa: PLR2004 - as the message says
        raise UsageError(f"simulation: {duration_s:g} s at {rate_hz:g} Hz: expected at least 2 sampling intervals")
    return round(duration_s * CONTROL_RATE_HZ)


class RecordingSettings(Checked):
    """Settings of a recording; those of what is recorded say too who moves the joints."""

    duration_s: float = within(120.0, 0.0, LONGEST_S)  # length of the recording [s]
    rate_hz: float = within(1000.0, 0.0, CONTROL_RATE_HZ)  # at which states are kept [Hz]

    def __post_init__(self: SomeSettings) -> None:
        """Refuse one that is too short, and what takes a person's hand where motors move the joints."""
        Checked.__post_init__(self)
        count_ticks(self.duration_s, self.rate_hz)
        unlogged = any(inside.unlogged_compensation.share != 0.0 for inside in self.hidden)
        if self.driven and (unlogged or self.compensator is not None):  # sensors read all that motors give
            what = "unlogged_compensation" if unlogged else "a friction compensator"
            raise UsageError(f"simulation: {what} takes a hand that moves the joints; expected driven=false")


class Streams(NamedTuple):
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
    return Streams(person, sensors, recorder, events=tuple(parts[::2]), drifts=tuple(parts[1::2]))


class TorqueLoop(Checked):
    """Joint torque control: tau_m = tau_d + gain (tau_d - tau_J) - damping_s d(tau_J)/dt, what is fed back delayed.

    The link then sees a motor of B / (1 + gain) with friction tau_f / (1 + gain) (A. Albu-Schaeffer, C. Ott, G.
    Hirzinger, International Journal of Robotics Research 26(1), 2007). tau_J is the torque of the gear's spring, free
    of noise; tau_d gravity compensation and u.
    """

    gain: float = within(high=LARGEST)  # of the torque error; 0 for no torque control
    # of the derivative of the torque. Against a link held fast the loop rings without end, to first order in the dead
    # time, where it is below gain times dead time [s]
    damping_s: float = within(high=LARGEST)
    dead_time_s: float = within(high=LONGEST_DEAD_TIME_S)  # from the torque to the motor, in steps of 0.1 ms [s]


class JointParameters(Checked):
    """The joint on the motor's side of the torque sensor: B ddq = F_m + u - tau_f."""

    inertia_kg_m2: float = positive(0.3)  # reflected inertia B [kg m^2]
    coulomb_nm: float = within(0.3)  # coulomb friction, static and sliding [N m]
    viscous_nms_per_rad: float = within(0.07)  # viscous friction [N m s/rad]
    # joint torque control; takes an elastic joint that a hand moves
    torque_loop: TorqueLoop = field(default_factory=TorqueLoop)

    @property
    def at_link(self) -> "JointParameters":
        """What the link sees of it through its torque control."""
        left = 1.0 / (1.0 + self.torque_loop.gain)
        inertia, coulomb, viscous = (left * getattr(self, item.name) for item in fields(self)[:3])
        return JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)


class Sensors(Checked):
    """What the sensors and the recorder do to the truth; every default is an ideal one."""

    torque_noise_nm: float = within(high=LARGEST)  # standard deviation of the torque noise [N m]
    torque_correlation_s: float = within(high=LARGEST)  # time after which its autocorrelation has fallen to 1/e [s]
    slow_noise_share: float = within(high=1.0)  # share of its variance that wanders more slowly
    # time after which the autocorrelation of the slower part has fallen to 1/e [s]
    slow_correlation_s: float = within(0.05, 0.0, LARGEST)
    torque_step_nm: float = within(high=LARGEST)  # resolution of the torque, 0 for none [N m]
    velocity_noise_rad_s: float = within(high=LARGEST)  # standard deviation of the velocity noise, white [rad/s]
    velocity_step_rad_s: float = within(high=LARGEST)  # resolution of the velocity [rad/s]
    position_noise_rad: float = within(high=LARGEST)  # standard deviation of the position noise, white [rad]
    position_step_rad: float = within(high=LARGEST)  # resolution of the position [rad]
    clock_jitter_s: float = within(high=LARGEST)  # standard deviation of the spacing of the stamps, losses aside [s]
    stale: float = within(high=0.5)  # share of the samples that repeat the one before
    lost: float = within(high=0.5)  # share of the samples that were never recorded
    longest_loss: int = within(8, 1, LARGEST)  # samples in a row that are lost once; all others are lost one by one

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        for name in ("torque_step_nm", "velocity_step_rad_s", "position_step_rad"):
            if 0 < (step := getattr(self, name)) < FINEST_STEP:
                raise UsageError(f"sensors: {name} {step:g}: expected 0, for none, or at least {FINEST_STEP:g}")


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

# What runs in an arm, the same in every joint or one for each; None where nothing does.
AnyCompensator = Compensator | tuple[Compensator, ...]


def of_each_joint(compensator: AnyCompensator | None, joints: int) -> tuple[Compensator | None, ...]:
    """Return what runs in each joint."""
    if not isinstance(compensator, tuple):
        return (compensator,) * joints
    if len(compensator) != joints:
        raise UsageError(f"arm: {len(compensator)} compensators: expected one, or {joints}")
    return compensator


# What a simulation gives: the log as it was recorded, and everything that the log does not say.


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TrueMotion:
    """True motion and torques at every tick of the controller, free of noise; n + 1 ticks, j joints."""

    t: Float  # time, shape (n + 1,) [s]
    q: Float  # position of the link, shape (n + 1, j), as all that follow [rad]
    dq: Float  # its velocity; exactly 0 where friction holds a rigid joint [rad/s]
    inner_q: Float  # position of the side on which friction acts; q itself in a rigid joint [rad]
    inner_dq: Float  # velocity of that side [rad/s]
    inner_ddq: Float  # acceleration of that side [rad/s^2]
    interaction_nm: Float  # interaction torque F_m at the sensor [N m]
    support_nm: Float  # torque that holds the arm against gravity [N m]
    port_nm: Float  # torque that passes through the sensor towards the side on which friction acts [N m]
    friction_nm: Float  # friction torque tau_f; at rest the torque that holds the joint [N m]
    compensation_nm: Float  # torque of the compensator in force at the tick [N m]
    passivity_nm: Float  # torque of its passivity controller [N m]
    unlogged_nm: Float  # torque of a compensator that the log does not name [N m]
    dissipated_j: Float  # energy that friction has taken so far; bristles give a little of it back [J]
    warmth: Float  # 0 cold, 1 warm


class Moved(NamedTuple):
    """Result of the mechanics, the input of the sensor model."""

    motion: TrueMotion
    loop: Any  # ``records.Loop``: compensators and the noise that they saw
    compensators: Mapping[str, Float]  # as in ``Truth``
    gravity: Float | None  # what gravity compensation gave, shape (n + 1, j) [N m]; None where F_m itself is logged


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Truth:
    """What the log does not say."""

    settings: Any  # everything that was simulated
    seed: int  # the seed
    motion: TrueMotion  # the motion, free of noise
    # memory of each joint's compensator at every tick, by the names in ``records.TRACE``; empty without one
    compensators: Mapping[str, Float]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Simulation:
    """A synthetic log and its truth."""

    log: JointLog
    truth: Truth = field(repr=False)


FASTEST_RAD_S, STRONGEST_NM = 1e3, 1e6  # far above those of any arm


def require_bounded(motion: TrueMotion, path: str) -> TrueMotion:
    """Return the motion; AnalysisError if a speed or torque is not finite or above its limit: it diverged."""
    speeds = (motion.dq, motion.inner_dq)
    torques = (motion.port_nm, motion.support_nm, motion.friction_nm, motion.compensation_nm, motion.passivity_nm)
    groups = (speeds, FASTEST_RAD_S, "speed", "rad/s"), (torques, STRONGEST_NM, "torque", "N m")
    for signals, limit, what, unit in groups:
        # Written so that NaN, which compares as false, is caught.
        if all(-limit <= signal.min() and signal.max() <= limit for signal in signals):
            continue
        _, ticks, joints = np.nonzero(np.array([~(np.abs(signal) <= limit) for signal in signals]))
        first = ticks.argmin()
        raise AnalysisError(
            f"{path}: the simulation diverged: joint {joints[first] + 1} has a {what} above {limit:g} {unit} at "
            f"{motion.t[ticks[first]]:.3f} s, or none that is a number; nothing was written; set masses, stiffnesses "
            "and torques closer to those of a joint, or leave the effect out"
        )
    return motion
