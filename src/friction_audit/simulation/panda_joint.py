"""The Panda that is simulated: published ranges, and what had to be assumed."""

from dataclasses import dataclass, field, fields, replace
from math import atan2, hypot, pi

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import load_arm
from friction_audit.simulation.bench import BenchSettings, Operator, Progress, move, moved_by
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanism import make_loop
from friction_audit.simulation.settings import (
    CONTROL_RATE_HZ,
    LONGEST_S,
    PANDA_SENSORS,
    Checked,
    JointParameters,
    Sensors,
    Streams,
    count_ticks,
    within,
)
from friction_audit.simulation.simulation import Moved, TrueMotion

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
class HandGuidedPanda(Checked):
    """One joint of a Panda moved by hand; of the others only the sensors matter."""

    robot = "panda"
    driven = logs_temperature = False

    joint: int = 1  # number of the joint that is moved, 1..7
    joints: tuple[JointParameters, ...] = PANDA_JOINTS  # the seven joints
    hidden: tuple[Hidden, ...] = (Hidden(),) * JOINTS  # what is hidden in them
    sensors: tuple[Sensors, ...] = PANDA_SENSORS  # their sensors; the recorder is that of the first
    operator: Operator = field(default_factory=Operator)  # who moves the joint
    # an active friction compensator of the joint, whose torque is logged, or None
    compensator: Compensator | None = None
    pose_rad: tuple[float, ...] = READY_RAD  # pose at the start [rad]
    duration_s: float = within(120.0, 0.0, LONGEST_S)  # length of the recording [s]
    rate_hz: float = within(1000.0, 0.0, CONTROL_RATE_HZ)  # at which states are kept [Hz]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        counts = [len(part) for part in (self.joints, self.hidden, self.sensors, self.pose_rad)]
        if not 1 <= self.joint <= JOINTS or set(counts) != {JOINTS}:
            found = f"joint {self.joint}, {', '.join(map(str, counts))} joints, hidden, sensors and angles"
            raise UsageError(f"Panda: {found}: expected a joint from 1 to {JOINTS} and {JOINTS} of each")
        count_ticks(self.duration_s, self.rate_hz)
        # Effects that do nothing in a joint at rest would stand in the truth.
        for number, hidden in enumerate(self.hidden, start=1):
            groups, rests = [group for group in hidden.each() if group.hidden], number != self.joint
            if idle := [one.name for one in groups if one.needs_moving_neighbour or (rests and not one.felt_at_rest)]:
                raise UsageError(
                    f"Panda: {', '.join(idle)} in joint {number}: does nothing where only joint "
                    f"{self.joint} moves; name them after @{self.joint}, or let all joints move (scenario panda)"
                )

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the joints that move."""
        return (self.joint,)


def move_hand_guided_panda(settings: HandGuidedPanda, streams: Streams, path: str, progress: Progress | None) -> Moved:
    """Move one joint of a Panda by hand while gravity is compensated.

    The sensor reads tau_J = gravity(q) - F_m; beyond gravity, only a compensator's torque is desired (tau_J_d). The
    other joints stand still without a load; their sensors bear gravity alone. Motion and noise of the joint are those
    of a bench with the same seed.
    """
    arm, moved = load_arm(), settings.joint - 1
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
    alone = moved_by(move(bench, own, progress, start_rad=settings.pose_rad[moved]), path)

    def widened(column: Float, others: Float | None = None) -> Float:
        wide = np.zeros((len(column), JOINTS)) if others is None else np.tile(others, (len(column), 1))
        wide[:, moved] = column[:, 0]
        return wide

    pose = np.array(settings.pose_rad)
    columns = {item.name: getattr(alone.motion, item.name) for item in fields(TrueMotion) if item.name != "t"}
    wide = {name: widened(column, pose if name in ("q", "inner_q") else None) for name, column in columns.items()}
    gravity = arm.gravity(wide["q"])
    rest = np.arange(JOINTS) != moved
    wide["support_nm"][:, rest] = gravity[:, rest]
    wide["port_nm"][:, rest] = -gravity[:, rest]
    # The noise of the moved joint has been drawn.
    loop = make_loop(settings, len(gravity) - 1, streams)
    for name in ("torque_noise", "velocity_noise", "position_noise"):
        getattr(loop, name)[:, moved] = getattr(alone.loop, name)[:, 0]
    traces = {name: widened(trace) for name, trace in alone.compensators.items()}
    return Moved(TrueMotion(t=alone.motion.t, **wide), loop, traces, gravity)
