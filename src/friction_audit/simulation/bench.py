"""One joint that moves, on a bench or in a Panda, by a hand or its own motor; the mechanism of every simulation."""

from collections.abc import Callable
from dataclasses import field
from math import atan2, hypot, inf, pi
from typing import Any

import numpy as np

from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.law import Checked, positive, within
from friction_audit.compensation.records import FIELDS, TRACE, initial_states, settings_records
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import load_arm
from friction_audit.simulation import settings as shared
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.sensors import torque_drift_nm
from friction_audit.simulation.effects.slow_and_events import draw_events
from friction_audit.simulation.effects.structure import coupled_mass
from friction_audit.simulation.mechanics.control_loop import run, set_equilibrium, set_masses
from friction_audit.simulation.mechanics.records import KEPT, ROWS, STATE, Loop, Mechanism, make_body, pack
from friction_audit.simulation.periodic import MotionSettings
from friction_audit.simulation.sensors import draw_noise
from friction_audit.simulation.strokes import StopAndGo

Progress = Callable[[float], None]  # is given the share that is done, 0 to 1
CHUNK_TICKS = 20_000  # between two reports of the progress


class Operator(Checked):
    """A mass that holds the outer side of a joint, drawn along an intended motion: hand and link, or a servo motor."""

    inertia_kg_m2: float = positive(0.3)  # inertia on the outer side of the torque sensor [kg m^2]
    stiffness_nm_per_rad: float = positive(60.0)  # spring between intended and actual motion [N m/rad]
    damping_nms_per_rad: float = positive(9.0)  # damper between intended and actual motion [N m s/rad]
    motion: MotionSettings = field(default_factory=StopAndGo)  # the intended motion


class BenchSettings(shared.RecordingSettings):
    """One joint, who moves it, one recording."""

    robot = "unknown"
    moving = (1,)  # numbers of the joints that move

    joints: tuple[shared.JointParameters] = (shared.JointParameters(),)  # the joint
    hidden: tuple[Hidden] = (Hidden(),)  # what is hidden in it
    sensors: tuple[shared.Sensors] = (shared.PANDA_SENSORS[0],)  # its sensors and the recorder
    operator: Operator = field(default_factory=Operator)  # who moves it
    # False: a hand moves the link and friction is on the motor's side of the sensor. True: the motor moves the link,
    # nothing touches it, and friction is on the link's side.
    driven: bool = False
    compensator: Compensator | None = None  # an active friction compensator whose torque is logged, or None
    gravity_nm: float = 0.0  # gravity torque of the load with the link level; the motor holds it [N m]
    gravity_phase_rad: float = 0.0  # the gravity torque is that times sin(q + phase) [rad]
    # True: the log holds the torque at the sensor and gravity; False: the interaction torque itself
    logs_sensor: bool = False
    logs_temperature: bool = False  # True: the log holds the temperature too

    def __post_init__(self) -> None:
        shared.RecordingSettings.__post_init__(self)
        if (self.gravity_nm != 0.0 or self.driven) and not self.logs_sensor:
            found = "a joint with a gravity load, or one that moves by itself, cannot log the interaction torque"
            raise UsageError(f"simulation: {found}; expected logs_sensor=true")

    def move(self, streams: shared.Streams, path: str, progress: Progress | None) -> shared.Moved:
        """Move one joint."""
        moved = moved_by(move(self, streams, progress), path)
        weight = self.gravity_nm * np.sin(moved.motion.q + self.gravity_phase_rad)
        return moved._replace(gravity=weight if self.logs_sensor else None)


def move(
    settings: BenchSettings, streams: shared.Streams, progress: Progress | None, *, start_rad: float = 0.0
) -> Mechanism:
    """Simulate the joint under the operator, from rest; return the mechanism with its output."""
    ticks, hand = shared.count_ticks(settings.duration_s, settings.rate_hz), settings.operator
    intended = hand.motion.reference(ticks, 1.0 / shared.CONTROL_RATE_HZ, streams.person)
    position = start_rad + intended.position
    push = hand.stiffness_nm_per_rad * position + hand.damping_nms_per_rad * intended.velocity
    mechanism = build_mechanism(settings, ticks, np.array([start_rad]), streams)
    body = mechanism.body
    set_masses(body, np.array([[hand.inertia_kg_m2]]), rotor_inertia(settings.joints, settings.hidden))
    body.stiffness[0, 0], body.drive_damping[0, 0] = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
    gravity = np.array([settings.gravity_nm, settings.gravity_phase_rad])
    weight = settings.gravity_nm * np.sin(start_rad + settings.gravity_phase_rad)
    set_equilibrium(mechanism.joints, body, np.array([-weight if settings.driven else weight]))
    no_hand = np.zeros((6, 1)), np.zeros(0)
    for first in range(0, ticks + 1, CHUNK_TICKS):
        last = min(first + CHUNK_TICKS, ticks + 1)
        run(mechanism, push, gravity, *no_hand, first, last)
        if progress is not None:
            progress(last / (ticks + 1))
    return mechanism


def moved_by(mechanism: Mechanism, path: str, gravity: Float | None = None) -> shared.Moved:
    """Return the output of a mechanism by names, after a check that it did not diverge."""
    t = np.arange(len(mechanism.out), dtype=np.float64) * mechanism.dt
    motion = shared.TrueMotion(t=t, **dict(zip(KEPT, np.swapaxes(mechanism.out, 0, 1), strict=True)))
    names = (TRACE.names or ()) if mechanism.traced.shape[2] else ()
    traces = {name: mechanism.traced.view(TRACE)[:, :, 0][name] for name in names}
    return shared.Moved(shared.require_bounded(motion, path), mechanism.loop, traces, gravity)


HALF_SUBSTEPS = 5  # integration steps in half a tick of the controller


class _Joint(shared.JointParameters):
    hidden: Hidden


def rotor_inertia(joints: tuple[shared.JointParameters, ...], hidden: tuple[Hidden, ...]) -> Float:
    """Return the mass matrix of the motors, with what is hidden in it, shape (n, n). [kg m^2]"""
    pairs = zip(joints, hidden, strict=True)
    inertias = np.array([joint.inertia_kg_m2 + inside.inertia_error.extra_kg_m2 for joint, inside in pairs])
    for number, inertia in enumerate(inertias, start=1):
        if not inertia > 0.0:
            found = f"extra_kg_m2 leaves joint {number} an inertia of {inertia:g} kg m^2"
            raise UsageError(f"inertia_error: {found}: expected more than zero")
    return coupled_mass(inertias, np.array([inside.inertial_coupling.ratio for inside in hidden]))


def build_mechanism(settings: shared.SomeSettings, ticks: int, start: Float, streams: shared.Streams) -> Mechanism:
    """Build the mechanism at rest; its masses and its drive are the caller's to set."""
    n, hidden, driven = len(settings.joints), settings.hidden, settings.driven
    for number, (joint, inside) in enumerate(zip(settings.joints, hidden, strict=True), start=1):
        rigid = inside.joint_elasticity.compliance_rad_per_nm == 0.0
        if joint.torque_loop != shared.TorqueLoop() and (rigid or driven):
            raise UsageError(
                f"torque loop: joint {number} {'moves by itself' if driven else 'is rigid'}: expected a hand that "
                "moves an elastic joint; add --effect joint_elasticity"
            )
    drawn = [draw_events(hidden[j].contact_event, settings.duration_s, streams.events[j]) for j in range(n)]
    events = np.tile([inf, 0.0, 0.0], (n, max(map(len, drawn)), 1))  # what is missing never begins
    for j, table in enumerate(drawn):
        events[j, : len(table)] = table
    pairs = zip(settings.joints, hidden, strict=True)
    rows = [_Joint(**vars(one), hidden=own) for one, own in pairs]
    two_sided = [h.joint_elasticity.compliance_rad_per_nm != 0.0 or h.backlash.gap_rad != 0.0 for h in hidden]
    free = [row.hidden.presliding.displacement_rad != 0.0 and row.coulomb_nm > 0.0 for row in rows]
    states = np.zeros(n, STATE)
    states["start_rad"], states["driven"], states["duration_s"] = start, driven, settings.duration_s
    return Mechanism(
        joints=pack(rows),
        states=states,
        events=events,
        body=make_body(np.array(two_sided), np.array(free), start),
        loop=make_loop(settings, ticks, streams),
        dt=1.0 / shared.CONTROL_RATE_HZ,
        substeps=HALF_SUBSTEPS,
        out=np.zeros((ticks + 1, ROWS, n)),
        traced=np.zeros((ticks + 1, n, FIELDS if settings.compensator is not None else 0), np.int64),
    )


def make_loop(settings: shared.SomeSettings, ticks: int, streams: shared.Streams) -> Loop:
    """Draw the noise of the sensors and prepare the compensators."""
    t = np.arange(ticks + 1) / shared.CONTROL_RATE_HZ
    torque, velocity, position = (np.empty((ticks + 1, len(settings.joints))) for _ in range(3))
    for j, (sensors, inside) in enumerate(zip(settings.sensors, settings.hidden, strict=True)):
        noise, velocity[:, j], position[:, j] = draw_noise(ticks, shared.CONTROL_RATE_HZ, sensors, streams.sensors)
        drift = torque_drift_nm(inside.torque_drift, t, streams.drifts[j])
        torque[:, j] = noise + inside.torque_bias.torque_nm + drift
    memory = initial_states(len(settings.joints))
    return Loop(
        settings=settings_records(shared.of_each_joint(settings.compensator, len(memory)), shared.CONTROL_RATE_HZ),
        memory=memory,
        memory_fields=memory.view(np.int64).reshape(len(memory), -1),
        torque_noise=torque,
        velocity_noise=velocity,
        position_noise=position,
        torque_step=np.array([sensors.torque_step_nm for sensors in settings.sensors]),
        velocity_step=np.array([sensors.velocity_step_rad_s for sensors in settings.sensors]),
    )


# The Panda that is simulated: published ranges, and what had to be assumed.

READY_RAD = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)  # the vendor's ready pose

# Symmetric Coulomb and viscous friction as identified by Knezevic et al. (2026, CC BY 4.0). Reflected inertias of the
# motors are not published: these are assumptions.
_COULOMB_NM = (0.311, 0.201, 0.427, 0.321, 0.356, 0.498, 0.332)
_VISCOUS_NMS_PER_RAD = (0.075, 0.087, 0.041, 0.045, 0.041, 0.057, 0.031)
_INERTIA_KG_M2 = (0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1)

# Motors and friction of joints 1 to 7.
PANDA_JOINTS = tuple(
    shared.JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    for inertia, coulomb, viscous in zip(_INERTIA_KG_M2, _COULOMB_NM, _VISCOUS_NMS_PER_RAD, strict=True)
)

JOINTS = 7


class PandaSettings(shared.RecordingSettings):
    """A Panda and a recording of it; the tuples have one entry per joint."""

    robot = "panda"

    joints: tuple[shared.JointParameters, ...] = PANDA_JOINTS  # motors and friction
    hidden: tuple[Hidden, ...] = (Hidden(),) * JOINTS  # what is hidden in each joint
    sensors: tuple[shared.Sensors, ...] = shared.PANDA_SENSORS  # of each joint; the recorder is that of the first
    pose_rad: tuple[float, ...] = READY_RAD  # pose at the start [rad]

    def __post_init__(self) -> None:
        shared.RecordingSettings.__post_init__(self)
        counts = [len(part) for part in (self.joints, self.hidden, self.sensors, self.pose_rad)]
        if set(counts) != {JOINTS}:
            found = f"{', '.join(map(str, counts))} joints, hidden, sensors and angles"
            raise UsageError(f"Panda: {found}: expected {JOINTS} of each")


class HandGuidedPanda(PandaSettings):
    """One joint of a Panda moved by hand; of the others only the sensors matter."""

    driven = logs_temperature = False

    joint: int = within(1, 1, JOINTS)  # number of the joint that is moved
    operator: Operator = field(default_factory=Operator)  # who moves the joint
    # an active friction compensator of the joint, whose torque is logged, or None
    compensator: Compensator | None = None

    def __post_init__(self) -> None:
        PandaSettings.__post_init__(self)
        # Effects that do nothing in a joint at rest would stand in the truth.
        for number, hidden in enumerate(self.hidden, start=1):
            groups, rests = hidden.present(), number != self.joint
            if idle := [one.name for one in groups if not one.felt_at_rest and (rests or one.needs_neighbours)]:
                found = f"{', '.join(idle)} in joint {number}: does nothing where only joint {self.joint} moves"
                todo = f"name them after @{self.joint}, or let all joints move (scenario panda)"
                raise UsageError(f"Panda: {found}; {todo}")

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the joints that move."""
        return (self.joint,)

    def move(self, streams: shared.Streams, path: str, progress: Progress | None) -> shared.Moved:
        """Move one joint by hand, as that of a bench with the seed; the sensors of the others bear gravity alone."""
        arm, moved = load_arm(), self.joint - 1
        # All that the joint carries turns as one rigid body: its gravity torque is a sine of its angle.
        poses = np.tile(self.pose_rad, (2, 1))
        poses[:, moved] = (0.0, pi / 2)
        sine, cosine = arm.gravity(poses)[:, moved]
        given: dict[str, Any] = {name: (getattr(self, name)[moved],) for name in ("joints", "hidden", "sensors")}
        given |= {name: getattr(self, name) for name in ("operator", "compensator", "duration_s", "rate_hz")}
        given |= {"gravity_nm": hypot(sine, cosine), "gravity_phase_rad": atan2(sine, cosine)}
        bench = BenchSettings(**given, logs_sensor=True)
        own = streams._replace(events=(streams.events[moved],), drifts=(streams.drifts[moved],))
        alone = move(bench, own, progress, start_rad=self.pose_rad[moved])
        ticks, rest = len(alone.out), np.arange(JOINTS) != moved
        out, traced = np.zeros((ticks, ROWS, JOINTS)), np.zeros((ticks, JOINTS, alone.traced.shape[2]), np.int64)
        out[:, :, moved], traced[:, moved] = alone.out[:, :, 0], alone.traced[:, 0]
        row = dict(zip(KEPT, np.swapaxes(out, 0, 1), strict=True))
        row["q"][:, rest] = row["inner_q"][:, rest] = np.array(self.pose_rad)[rest]
        gravity = arm.gravity(row["q"])
        row["support_nm"][:, rest], row["port_nm"][:, rest] = gravity[:, rest], -gravity[:, rest]
        # The noise of the moved joint has been drawn.
        loop = make_loop(self, ticks - 1, streams)
        for name in ("torque_noise", "velocity_noise", "position_noise"):
            getattr(loop, name)[:, moved] = getattr(alone.loop, name)[:, 0]
        return moved_by(alone._replace(out=out, traced=traced, loop=loop), path, gravity)
