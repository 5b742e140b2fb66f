"""One joint on a bench, moved by a hand or by its own motor."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.compensation.records import TRACE
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanics.records import KEPT, Mechanism
from friction_audit.simulation.mechanics.tick import run, settle
from friction_audit.simulation.mechanism import assemble, rotor_mass
from friction_audit.simulation.motion import MotionSettings, StopAndGo
from friction_audit.simulation.settings import (
    CONTROL_RATE_HZ,
    LONGEST_S,
    PANDA_SENSORS,
    Checked,
    JointParameters,
    Sensors,
    Streams,
    count_ticks,
    positive,
    require_no_hand,
    within,
)
from friction_audit.simulation.simulation import Moved, TrueMotion, require_sane

Progress = Callable[[float], None]  # is given the share that is done, 0 to 1
CHUNK_TICKS = 20_000  # between two reports of the progress


@dataclass(frozen=True, kw_only=True, slots=True)
class Operator(Checked):
    """A mass that holds the outer side of the joint rigidly, drawn by a spring and a damper along an intended motion.

    Where a hand moves the joint, the mass is that of hand and link; where the robot moves by itself, it is the motor's
    and the spring and the damper are its position controller.
    """

    inertia_kg_m2: float = positive(0.3)  # inertia on the outer side of the torque sensor [kg m^2]
    stiffness_nm_per_rad: float = positive(60.0)  # spring between intended and actual motion [N m/rad]
    damping_nms_per_rad: float = positive(9.0)  # damper between intended and actual motion [N m s/rad]
    motion: MotionSettings = field(default_factory=StopAndGo)  # the intended motion


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchSettings(Checked):
    """One joint, who moves it, one recording."""

    robot = "unknown"
    moving = (1,)  # numbers of the joints that move

    joints: tuple[JointParameters] = (JointParameters(),)  # the joint
    hidden: tuple[Hidden] = (Hidden(),)  # what is hidden in it
    sensors: tuple[Sensors] = (PANDA_SENSORS[0],)  # its sensors and the recorder
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
    duration_s: float = within(120.0, 0.0, LONGEST_S)  # length of the recording [s]
    rate_hz: float = within(1000.0, 0.0, CONTROL_RATE_HZ)  # at which states are kept [Hz]

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        count_ticks(self.duration_s, self.rate_hz)
        if (self.gravity_nm != 0.0 or self.driven) and not self.logs_sensor:
            raise UsageError(
                "simulation: a joint with a gravity load, or one that moves by itself, cannot log the interaction "
                "torque; expected logs_sensor=true"
            )
        if self.driven:
            require_no_hand(self.hidden, self.compensator)


def move_bench(settings: BenchSettings, streams: Streams, path: str, progress: Progress | None) -> Moved:
    """Move one joint."""
    mechanism = move(settings, streams, progress)
    moved = moved_by(mechanism, path)
    weight = settings.gravity_nm * np.sin(moved.motion.q + settings.gravity_phase_rad)
    return moved._replace(gravity=weight if settings.logs_sensor else None)


def move(settings: BenchSettings, streams: Streams, progress: Progress | None, *, start_rad: float = 0.0) -> Mechanism:
    """Let the operator move the joint from rest at the start; return the mechanism with the truth written down."""
    ticks, hand = count_ticks(settings.duration_s, settings.rate_hz), settings.operator
    intended = hand.motion.intend(ticks, 1.0 / CONTROL_RATE_HZ, streams.person)
    place = start_rad + intended.position
    push = hand.stiffness_nm_per_rad * place + hand.damping_nms_per_rad * intended.velocity
    mechanism = assemble(settings, ticks, np.array([start_rad]), streams)
    body, rotor = mechanism.body, rotor_mass(settings.joints, settings.hidden)
    body.inner_mass[0, 0] = rotor[0, 0]
    body.mass[0, 0] += hand.inertia_kg_m2
    body.mass[body.inner[0], body.inner[0]] += rotor[0, 0]
    body.stiffness[0, 0], body.drive_damping[0, 0] = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
    gravity = np.array([settings.gravity_nm, settings.gravity_phase_rad])
    weight = settings.gravity_nm * np.sin(start_rad + settings.gravity_phase_rad)
    settle(mechanism.joints, body, np.array([-weight if settings.driven else weight]))
    no_hand = np.zeros((6, 1)), np.zeros(0)
    for first in range(0, ticks + 1, CHUNK_TICKS):
        last = min(first + CHUNK_TICKS, ticks + 1)
        run(mechanism, push, gravity, *no_hand, first, last)
        if progress is not None:
            progress(last / (ticks + 1))
    return mechanism


def moved_by(mechanism: Mechanism, path: str, gravity: Float | None = None) -> Moved:
    """Return what was written down, by its names."""
    row = dict(zip(KEPT, np.swapaxes(mechanism.out, 0, 1), strict=True))
    q, dq = row.pop("outer_q"), row.pop("outer_dq")
    if mechanism.states[0]["driven"]:
        q, dq = row["inner_q"], row["inner_dq"]
    t = np.arange(len(mechanism.out), dtype=np.float64) * mechanism.clock.dt
    motion = TrueMotion(t=t, q=q, dq=dq, interaction_nm=row["port_nm"] + row["support_nm"], **row)
    names = (TRACE.names or ()) if mechanism.traced.shape[2] else ()
    traces = {name: mechanism.traced.view(TRACE)[:, :, 0][name] for name in names}
    return Moved(require_sane(motion, path), mechanism.loop, traces, gravity)
