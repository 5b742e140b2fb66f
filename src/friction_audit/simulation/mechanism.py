"""The mechanism of a simulation: joints, coordinates, compensators and what they see, at rest at the start."""

from dataclasses import dataclass, fields
from math import inf
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from friction_audit.compensation.records import FIELDS, fresh_memory
from friction_audit.compensation.records import pack as pack_compensators
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.sensors import torque_drift_nm
from friction_audit.simulation.effects.slow_and_events import draw_events
from friction_audit.simulation.effects.structure import coupled_mass
from friction_audit.simulation.mechanics.records import ROWS, STATE, Clock, Loop, Mechanism, make_body, pack
from friction_audit.simulation.sensors import draw_noise
from friction_audit.simulation.settings import CONTROL_RATE_HZ, JointParameters, Streams, TorqueLoop, of_each_joint

if TYPE_CHECKING:
    from friction_audit.simulation.arm import ArmSettings
    from friction_audit.simulation.bench import BenchSettings
    from friction_audit.simulation.panda_joint import HandGuidedPanda

    Settings: TypeAlias = BenchSettings | HandGuidedPanda | ArmSettings

HALF_SUBSTEPS = 5  # integration steps in half a tick of the controller


@dataclass(frozen=True, kw_only=True, slots=True)
class _Joint(JointParameters):
    hidden: Hidden


def rotor_mass(joints: tuple[JointParameters, ...], hidden: tuple[Hidden, ...]) -> Float:
    """Return the mass matrix of the motors, with what is hidden in it, shape (n, n). [kg m^2]"""
    pairs = zip(joints, hidden, strict=True)
    inertias = np.array([joint.inertia_kg_m2 + inside.inertia_error.extra_kg_m2 for joint, inside in pairs])
    for number, inertia in enumerate(inertias, start=1):
        if not inertia > 0.0:
            found = f"extra_kg_m2 leaves joint {number} an inertia of {inertia:g} kg m^2"
            raise UsageError(f"inertia_error: {found}: expected more than zero")
    return coupled_mass(inertias, np.array([inside.inertial_coupling.ratio for inside in hidden]))


def assemble(settings: "Settings", ticks: int, start: Float, streams: Streams) -> Mechanism:
    """Build the mechanism at rest; its masses and its drive are the caller's to set.

    Where ``driven``, the motors are on the outer side, friction and links on the inner one.
    """
    n, hidden, driven = len(settings.joints), settings.hidden, settings.driven
    for number, (joint, inside) in enumerate(zip(settings.joints, hidden, strict=True), start=1):
        rigid = inside.joint_elasticity.compliance_rad_per_nm == 0.0
        if joint.torque_loop != TorqueLoop() and (rigid or driven):
            raise UsageError(
                f"torque loop: joint {number} {'moves by itself' if driven else 'is rigid'}: expected a hand that "
                "moves an elastic joint; add --effect joint_elasticity"
            )
    drawn = [draw_events(hidden[j].contact_event, settings.duration_s, streams.events[j]) for j in range(n)]
    events = np.tile([inf, 0.0, 0.0], (n, max(map(len, drawn)), 1))  # what is missing never begins
    for j, table in enumerate(drawn):
        events[j, : len(table)] = table
    pairs = zip(settings.joints, hidden, strict=True)
    rows = [_Joint(**{item.name: getattr(one, item.name) for item in fields(one)}, hidden=own) for one, own in pairs]
    two_sided = [h.joint_elasticity.compliance_rad_per_nm != 0.0 or h.backlash.gap_rad != 0.0 for h in hidden]
    free = [row.hidden.presliding.displacement_rad != 0.0 and row.coulomb_nm > 0.0 for row in rows]
    states = np.zeros(n, STATE)
    states["start_rad"], states["driven"] = start, driven
    return Mechanism(
        joints=pack(rows),
        states=states,
        events=events,
        body=make_body(np.array(two_sided), np.array(free), start),
        loop=make_loop(settings, ticks, streams),
        clock=Clock(dt=1.0 / CONTROL_RATE_HZ, substeps=HALF_SUBSTEPS, duration=settings.duration_s),
        out=np.zeros((ticks + 1, ROWS, n)),
        traced=np.zeros((ticks + 1, n, FIELDS if settings.compensator is not None else 0), np.int64),
    )


def make_loop(settings: "Settings", ticks: int, streams: Streams) -> Loop:
    """Draw the noise of the sensors and prepare the compensators."""
    t = np.arange(ticks + 1) / CONTROL_RATE_HZ
    torque, velocity, position = (np.empty((ticks + 1, len(settings.joints))) for _ in range(3))
    for j, (sensors, inside) in enumerate(zip(settings.sensors, settings.hidden, strict=True)):
        noise, velocity[:, j], position[:, j] = draw_noise(ticks, CONTROL_RATE_HZ, sensors, streams.sensors)
        drift = torque_drift_nm(inside.torque_drift, t, streams.drifts[j])
        torque[:, j] = noise + inside.torque_bias.torque_nm + drift
    memory = fresh_memory(len(settings.joints))
    return Loop(
        settings=pack_compensators(of_each_joint(settings.compensator, len(memory)), CONTROL_RATE_HZ),
        memory=memory,
        words=memory.view(np.int64).reshape(len(memory), -1),
        torque_noise=torque,
        velocity_noise=velocity,
        position_noise=position,
        torque_step=np.array([sensors.torque_step_nm for sensors in settings.sensors]),
        velocity_step=np.array([sensors.velocity_step_rad_s for sensors in settings.sensors]),
    )
