"""The Panda that is simulated: published ranges, and what had to be assumed."""

from dataclasses import dataclass, field, fields, replace
from math import atan2, hypot, pi

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import Arm, load_arm
from friction_audit.simulation import reading
from friction_audit.simulation.bench import BenchSettings, Progress, make_motion, make_traces, move
from friction_audit.simulation.clock import Streams, count_ticks, make_streams
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.hidden import Hidden
from friction_audit.simulation.mechanics.records import Loop
from friction_audit.simulation.mechanism import Mechanism, make_loop
from friction_audit.simulation.operator import Operator
from friction_audit.simulation.settings import PANDA_SENSORS, JointParameters, Sensors
from friction_audit.simulation.simulation import Motion, Simulation, Truth

READY_RAD = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)
"""The vendor's ready pose."""

# Symmetric Coulomb and viscous friction as identified by Knezevic et al. (2026, CC BY 4.0). Reflected inertias of the
# motors are not published: these are assumptions.
_COULOMB_NM = (0.311, 0.201, 0.427, 0.321, 0.356, 0.498, 0.332)
_VISCOUS_NMS_PER_RAD = (0.075, 0.087, 0.041, 0.045, 0.041, 0.057, 0.031)
_INERTIA_KG_M2 = (0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1)

PANDA_JOINTS = tuple(
    JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    for inertia, coulomb, viscous in zip(_INERTIA_KG_M2, _COULOMB_NM, _VISCOUS_NMS_PER_RAD, strict=True)
)
"""Motors and friction of joints 1 to 7."""


JOINTS = 7

FELT_AT_REST = ("torque_bias", "torque_drift", "gravity_error", "torque_crosstalk")
"""Effects that show themselves in a joint that stands still."""

INERTIAL_COUPLING = "inertial_coupling"


@dataclass(frozen=True, kw_only=True, slots=True)
class HandGuidedPanda:
    """One joint of a Panda moved by hand; of the others only the sensors matter.

    Attributes:
        joint: Number of the joint that is moved, 1..7.
        joints: The seven joints.
        hidden: What is hidden in them.
        sensors: Their sensors; the recorder is that of the first.
        operator: Who moves the joint.
        compensator: An active friction compensator of the joint, whose torque is logged, or None.
        pose_rad: Pose at the start. [rad]
        duration_s: Length of the recording. [s]
        rate_hz: Rate at which states are kept, up to that of the controller. [Hz]

    Raises:
        UsageError: If there is no such joint, there are not seven of something, or the recording has no length.
    """

    joint: int = 1
    joints: tuple[JointParameters, ...] = PANDA_JOINTS
    hidden: tuple[Hidden, ...] = (Hidden(),) * JOINTS
    sensors: tuple[Sensors, ...] = PANDA_SENSORS
    operator: Operator = field(default_factory=Operator)
    compensator: Compensator | None = None
    pose_rad: tuple[float, ...] = READY_RAD
    duration_s: float = 120.0
    rate_hz: float = 1000.0

    def __post_init__(self) -> None:
        """Check the joint and the number of its neighbours."""
        counts = {name: len(getattr(self, name)) for name in ("joints", "hidden", "sensors", "pose_rad")}
        if not 1 <= self.joint <= JOINTS or set(counts.values()) != {JOINTS}:
            found = ", ".join(f"{count} {name}" for name, count in counts.items())
            raise UsageError(
                f"Panda: joint {self.joint}, {found}: expected a joint from 1 to {JOINTS} and {JOINTS} of each"
            )
        count_ticks(self.duration_s, self.rate_hz)
        self._refuse_what_cannot_be_felt()

    def _refuse_what_cannot_be_felt(self) -> None:
        """Refuse effects that do nothing in a joint at rest, lest the truth tells of them."""
        for number, hidden in enumerate(self.hidden, start=1):
            found = [effect.name for effect in EFFECTS if effect.is_hidden(getattr(hidden, effect.name))]
            idle = [name for name in found if number != self.joint and name not in FELT_AT_REST]
            if idle or INERTIAL_COUPLING in found:
                raise UsageError(
                    f"Panda: {', '.join(idle or [INERTIAL_COUPLING])} in joint {number}: does nothing where only joint "
                    f"{self.joint} moves; put effects behind @{self.joint}, or let all joints move (scenario panda)"
                )

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the joints that move."""
        return (self.joint,)


def simulate_hand_guided_panda(
    settings: HandGuidedPanda, seed: int, *, path: str = "simulation", progress: Progress | None = None
) -> Simulation:
    """Simulate a Panda whose one joint is moved by hand while gravity is compensated.

    The sensor reads tau_J = gravity(q) - F_m; beyond gravity, only a compensator's torque is desired (tau_J_d). The
    other joints stand still and nobody loads them.

    Args:
        settings: The joint and its motion.
        seed: Seed; motion and noise of the joint are those of ``simulate_bench`` with the same seed.
        path: Path that the log names as its source.
        progress: Told how far the simulation is.
    """
    streams, arm = make_streams(seed, JOINTS), load_arm()
    mechanism = _move(settings, arm, streams, progress)
    motion = _among_the_others(settings, make_motion(mechanism, path, driven=False), arm)
    loop = _all_noise(settings, mechanism, streams)
    gravity = arm.gravity(motion.q)
    channels = reading.arm_channels(settings, motion, loop, gravity, driven=False)
    channels["tau_J_d"] = motion.compensation_nm + motion.passivity_nm
    names = tuple(f"panda_joint{number}" for number in range(1, JOINTS + 1))
    log = reading.write_down(settings, channels, names, path, streams, robot="panda")
    traces = {name: _widened(trace, settings.joint) for name, trace in make_traces(mechanism).items()}
    return Simulation(log=log, truth=Truth(settings=settings, seed=seed, motion=motion, compensators=traces))


def _move(settings: HandGuidedPanda, arm: Arm, streams: Streams, progress: Progress | None) -> Mechanism:
    """Move the joint as on a bench, under the gravity that it has while the others stand still."""
    moved = settings.joint - 1
    gravity_nm, phase_rad = _gravity_of_one(settings, arm)
    bench = BenchSettings(
        joints=(settings.joints[moved],),
        hidden=(settings.hidden[moved],),
        sensors=(settings.sensors[moved],),
        operator=settings.operator,
        compensator=settings.compensator,
        gravity_nm=gravity_nm,
        gravity_phase_rad=phase_rad,
        logs_sensor=True,
        duration_s=settings.duration_s,
        rate_hz=settings.rate_hz,
    )
    own = replace(streams, events=(streams.events[moved],), drifts=(streams.drifts[moved],))
    return move(bench, own, progress, start_rad=settings.pose_rad[moved])


def _gravity_of_one(settings: HandGuidedPanda, arm: Arm) -> tuple[float, float]:
    """Return amplitude [N m] and phase [rad] of the joint's gravity torque: all beyond it turns as one rigid body."""
    poses = np.tile(settings.pose_rad, (2, 1))
    poses[:, settings.joint - 1] = (0.0, pi / 2)
    sine, cosine = arm.gravity(poses)[:, settings.joint - 1]
    return hypot(sine, cosine), atan2(sine, cosine)


def _among_the_others(settings: HandGuidedPanda, moved: Motion, arm: Arm) -> Motion:
    """Return the motion of all joints; the sensors of those at rest bear gravity alone."""
    columns = {item.name: getattr(moved, item.name) for item in fields(moved) if item.name != "t"}
    wide = {name: _widened(column, settings.joint) for name, column in columns.items()}
    rest = np.arange(JOINTS) != settings.joint - 1
    for name in ("q", "inner_q"):
        wide[name][:, rest] = np.asarray(settings.pose_rad)[rest]
    wide["support_nm"][:, rest] = arm.gravity(wide["q"])[:, rest]
    wide["port_nm"][:, rest] = -wide["support_nm"][:, rest]
    return Motion(t=moved.t, **wide)


def _widened(column: Float, joint: int) -> Float:
    """Return the column of one joint among zeros, shape (n + 1, 7)."""
    wide = np.zeros((len(column), JOINTS))
    wide[:, joint - 1] = column[:, 0]
    return wide


def _all_noise(settings: HandGuidedPanda, mechanism: Mechanism, streams: Streams) -> Loop:
    """Draw the noise of the other joints; that of the moved one has been drawn."""
    loop = make_loop(settings, len(mechanism.out) - 1, streams)
    for name in ("torque_noise", "velocity_noise", "position_noise"):
        getattr(loop, name)[:, settings.joint - 1] = getattr(mechanism.loop, name)[:, 0]
    return loop
