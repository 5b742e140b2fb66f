"""The Panda that is simulated: published ranges, and what had to be assumed."""

from dataclasses import dataclass, field, fields, replace
from math import atan2, hypot, pi

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import Arm, load_arm
from friction_audit.simulation import sensors as reading
from friction_audit.simulation.bench import BenchSettings, Operator, Progress, make_motion, make_traces, move
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanism import make_loop
from friction_audit.simulation.settings import PANDA_SENSORS, JointParameters, Sensors, count_ticks, make_streams
from friction_audit.simulation.simulation import Simulation, TrueMotion, Truth

READY_RAD = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)  # the vendor's ready pose

# Symmetric Coulomb and viscous friction as identified by Knezevic et al. (2026, CC BY 4.0). Reflected inertias of the
# motors are not published: these are assumptions.
_COULOMB_NM = (0.311, 0.201, 0.427, 0.321, 0.356, 0.498, 0.332)
_VISCOUS_NMS_PER_RAD = (0.075, 0.087, 0.041, 0.045, 0.041, 0.057, 0.031)
_INERTIA_KG_M2 = (0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1)

# Motors and friction of joints 1 to 7.
PANDA_JOINTS = tuple(
    JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    for inertia, coulomb, viscous in zip(_INERTIA_KG_M2, _COULOMB_NM, _VISCOUS_NMS_PER_RAD, strict=True)
)

JOINTS = 7


@dataclass(frozen=True, kw_only=True, slots=True)
class HandGuidedPanda:
    """One joint of a Panda moved by hand; of the others only the sensors matter."""

    joint: int = 1  # number of the joint that is moved, 1..7
    joints: tuple[JointParameters, ...] = PANDA_JOINTS  # the seven joints
    hidden: tuple[Hidden, ...] = (Hidden(),) * JOINTS  # what is hidden in them
    sensors: tuple[Sensors, ...] = PANDA_SENSORS  # their sensors; the recorder is that of the first
    operator: Operator = field(default_factory=Operator)  # who moves the joint
    # an active friction compensator of the joint, whose torque is logged, or None
    compensator: Compensator | None = None
    pose_rad: tuple[float, ...] = READY_RAD  # pose at the start [rad]
    duration_s: float = 120.0  # length of the recording [s]
    rate_hz: float = 1000.0  # rate at which states are kept, up to that of the controller [Hz]

    def __post_init__(self) -> None:
        counts = {name: len(getattr(self, name)) for name in ("joints", "hidden", "sensors", "pose_rad")}
        if not 1 <= self.joint <= JOINTS or set(counts.values()) != {JOINTS}:
            found = ", ".join(f"{count} {name}" for name, count in counts.items())
            raise UsageError(
                f"Panda: joint {self.joint}, {found}: expected a joint from 1 to {JOINTS} and {JOINTS} of each"
            )
        count_ticks(self.duration_s, self.rate_hz)
        # Effects that do nothing in a joint at rest would stand in the truth.
        for number, hidden in enumerate(self.hidden, start=1):
            others_only = [group.name for group in hidden.each() if group.hidden and group.needs_moving_neighbour]
            at_rest = [group.name for group in hidden.each() if group.hidden and not group.felt_at_rest]
            idle = (at_rest if number != self.joint else []) or others_only
            if idle:
                raise UsageError(
                    f"Panda: {', '.join(idle)} in joint {number}: does nothing where only joint "
                    f"{self.joint} moves; name them after @{self.joint}, or let all joints move (scenario panda)"
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
    other joints stand still without a load. Motion and noise of the joint are those of ``simulate_bench`` with the same
    seed. Arguments as of ``scenarios.simulate``.
    """
    streams, arm, moved = make_streams(seed, JOINTS), load_arm(), settings.joint - 1
    # All that the joint carries turns as one rigid body: its gravity torque is a sine of its angle.
    poses = np.tile(settings.pose_rad, (2, 1))
    poses[:, moved] = (0.0, pi / 2)
    sine, cosine = arm.gravity(poses)[:, moved]
    bench = BenchSettings(
        joints=(settings.joints[moved],),
        hidden=(settings.hidden[moved],),
        sensors=(settings.sensors[moved],),
        operator=settings.operator,
        compensator=settings.compensator,
        gravity_nm=hypot(sine, cosine),
        gravity_phase_rad=atan2(sine, cosine),
        logs_sensor=True,
        duration_s=settings.duration_s,
        rate_hz=settings.rate_hz,
    )
    own = replace(streams, events=(streams.events[moved],), drifts=(streams.drifts[moved],))
    mechanism = move(bench, own, progress, start_rad=settings.pose_rad[moved])
    motion = _among_the_others(settings, make_motion(mechanism, path, driven=False), arm)
    # The noise of the moved joint has been drawn.
    loop = make_loop(settings, len(mechanism.out) - 1, streams)
    for name in ("torque_noise", "velocity_noise", "position_noise"):
        getattr(loop, name)[:, moved] = getattr(mechanism.loop, name)[:, 0]
    channels = reading.arm_channels(settings, motion, loop, arm.gravity(motion.q), driven=False)
    channels["tau_J_d"] = motion.compensation_nm + motion.passivity_nm
    names = tuple(f"panda_joint{number}" for number in range(1, JOINTS + 1))
    log = reading.write_down(settings, channels, names, path, streams, robot="panda")
    traces = {name: _widened(trace, moved) for name, trace in make_traces(mechanism).items()}
    return Simulation(log=log, truth=Truth(settings=settings, seed=seed, motion=motion, compensators=traces))


def _among_the_others(settings: HandGuidedPanda, moved: TrueMotion, arm: Arm) -> TrueMotion:
    """Return the motion of all joints; the sensors of those at rest bear gravity alone."""
    columns = {item.name: getattr(moved, item.name) for item in fields(moved) if item.name != "t"}
    wide = {name: _widened(column, settings.joint - 1) for name, column in columns.items()}
    rest = np.arange(JOINTS) != settings.joint - 1
    for name in ("q", "inner_q"):
        wide[name][:, rest] = np.asarray(settings.pose_rad)[rest]
    wide["support_nm"][:, rest] = arm.gravity(wide["q"])[:, rest]
    wide["port_nm"][:, rest] = -wide["support_nm"][:, rest]
    return TrueMotion(t=moved.t, **wide)


def _widened(column: Float, place: int) -> Float:
    wide = np.zeros((len(column), JOINTS))
    wide[:, place] = column[:, 0]
    return wide
