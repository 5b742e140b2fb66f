"""One joint on a bench, moved by a hand or by its own motor."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.compensation.records import TRACE
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import sensors as reading
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanics import records as rows
from friction_audit.simulation.mechanics.records import Mechanism
from friction_audit.simulation.mechanism import assemble, rotor_mass
from friction_audit.simulation.motion import MotionSettings, StopAndGo
from friction_audit.simulation.settings import (
    CONTROL_RATE_HZ,
    PANDA_SENSORS,
    JointParameters,
    Sensors,
    Streams,
    count_ticks,
    make_streams,
    require_hand,
    require_positive,
)
from friction_audit.simulation.simulation import Simulation, TrueMotion, Truth, require_sane

Progress = Callable[[float], None]  # is given the share that is done, 0 to 1
CHUNK_TICKS = 20_000  # between two reports of the progress


@dataclass(frozen=True, kw_only=True, slots=True)
class Operator:
    """A mass that holds the outer side of the joint rigidly, drawn by a spring and a damper along an intended motion.

    Where a hand moves the joint, the mass is that of hand and link; where the robot moves by itself, it is the motor's
    and the spring and the damper are its position controller.
    """

    inertia_kg_m2: float = 0.3  # inertia on the outer side of the torque sensor [kg m^2]
    stiffness_nm_per_rad: float = 60.0  # spring between intended and actual motion [N m/rad]
    damping_nms_per_rad: float = 9.0  # damper between intended and actual motion [N m s/rad]
    motion: MotionSettings = field(default_factory=StopAndGo)  # the intended motion

    def __post_init__(self) -> None:
        names = ("inertia_kg_m2", "stiffness_nm_per_rad", "damping_nms_per_rad")
        require_positive("operator", **{name: getattr(self, name) for name in names})


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchSettings:
    """One joint, who moves it, one recording."""

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
    duration_s: float = 120.0  # length of the recording [s]
    rate_hz: float = 1000.0  # rate at which states are kept, up to that of the controller [Hz]

    def __post_init__(self) -> None:
        count_ticks(self.duration_s, self.rate_hz)
        if (self.gravity_nm != 0.0 or self.driven) and not self.logs_sensor:
            raise UsageError(
                "simulation: a joint with a gravity load, or one that moves by itself, cannot log the interaction "
                "torque; expected logs_sensor=true"
            )
        if self.driven:
            require_hand("simulation", "a hand that moves the joint", self.hidden, self.compensator)

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the joints that move."""
        return (1,)


def simulate_bench(
    settings: BenchSettings, seed: int, *, path: str = "simulation", progress: Progress | None = None
) -> Simulation:
    """Simulate one joint; without a compensator in the loop, the motion does not depend on the sensors.

    Arguments as of ``scenarios.simulate``.
    """
    streams = make_streams(seed, 1)
    mechanism = move(settings, streams, progress)
    motion = make_motion(mechanism, path, driven=settings.driven)
    if settings.logs_sensor:
        weight = settings.gravity_nm * np.sin(motion.q + settings.gravity_phase_rad)
        channels = reading.arm_channels(settings, motion, mechanism.loop, weight, driven=settings.driven)
    else:
        channels = reading.bench_channels(settings, motion, mechanism.loop)
    if settings.logs_temperature:
        channels["temperature"] = reading.temperatures(settings, motion)
    log = reading.write_down(settings, channels, ("joint1",), path, streams, robot="unknown")
    truth = Truth(settings=settings, seed=seed, motion=motion, compensators=make_traces(mechanism))
    return Simulation(log=log, truth=truth)


def move(
    settings: BenchSettings, streams: Streams, progress: Progress | None = None, *, start_rad: float = 0.0
) -> Mechanism:
    """Let the operator move the joint from rest at the start; return the mechanism with the truth written down."""
    from friction_audit.simulation.mechanics.tick import run, settle

    ticks, hand = count_ticks(settings.duration_s, settings.rate_hz), settings.operator
    intended = hand.motion.intend(ticks, 1.0 / CONTROL_RATE_HZ, streams.person)
    place = start_rad + intended.position
    push = hand.stiffness_nm_per_rad * place + hand.damping_nms_per_rad * intended.velocity
    mechanism = assemble(settings, ticks, np.array([start_rad]), streams, driven=settings.driven)
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


def make_motion(mechanism: Mechanism, path: str, *, driven: bool) -> TrueMotion:
    """Return the truth by its names."""
    row = dict(zip(rows.KEPT, np.swapaxes(mechanism.out, 0, 1), strict=True))
    outer = row.pop("outer_q"), row.pop("outer_dq")
    q, dq = (row["inner_q"], row["inner_dq"]) if driven else outer
    t = np.arange(len(mechanism.out), dtype=np.float64) * mechanism.clock.dt
    motion = TrueMotion(t=t, q=q, dq=dq, interaction_nm=row["port_nm"] + row["support_nm"], **row)
    return require_sane(motion, path)


def make_traces(mechanism: Mechanism) -> dict[str, Float]:
    """Return the memory of the compensators, by name, shape (n + 1, j) each."""
    if not mechanism.traced.shape[2]:
        return {}
    traced = mechanism.traced.view(TRACE)[:, :, 0]
    return {name: traced[name] for name in TRACE.names or ()}
