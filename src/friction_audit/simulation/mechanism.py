"""A compensator in every joint of an arm: the same in all, or one for each."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from friction_audit.compensation.compensators import Compensator, guard_of
from friction_audit.compensation.records import TRACE, fresh_memory
from friction_audit.compensation.records import pack as pack_compensators
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation.clock import CONTROL_RATE_HZ, HALF_SUBSTEPS, Streams
from friction_audit.simulation.effects import contact_event, torque_bias, torque_drift
from friction_audit.simulation.effects.hidden import Hidden
from friction_audit.simulation.effects.inertial_coupling import coupled_mass
from friction_audit.simulation.mechanics.body import Body, make_body
from friction_audit.simulation.mechanics.records import ROWS, STATE, Clock, Loop, Parts, pack, pad_events
from friction_audit.simulation.sensors import draw_noise
from friction_audit.simulation.settings import JointParameters, Sensors


@dataclass(frozen=True, kw_only=True, slots=True)
class JointByJoint:
    """Compensators that differ from joint to joint.

    Attributes:
        compensators: One per joint.
    """

    compensators: tuple[Compensator, ...]


AnyCompensator = Compensator | JointByJoint
"""What runs in an arm; None where nothing does."""


def of_each_joint(compensator: AnyCompensator | None, joints: int) -> tuple[Compensator | None, ...]:
    """Return what runs in each joint.

    Raises:
        UsageError: If there are not as many as joints.
    """
    if not isinstance(compensator, JointByJoint):
        return (compensator,) * joints
    if len(compensator.compensators) != joints:
        raise UsageError(f"joint by joint: {len(compensator.compensators)} compensators: expected {joints}")
    return compensator.compensators


def any_guards(compensator: AnyCompensator | None) -> bool:
    """Return True if a passivity controller acts in some joint."""
    return any(guard_of(one).passivity for one in of_each_joint(compensator, _number(compensator)))


def _number(compensator: AnyCompensator | None) -> int:
    return len(compensator.compensators) if isinstance(compensator, JointByJoint) else 1


class Settings(Protocol):
    """What the settings of every simulation have in common; the tuples have one entry per joint."""

    @property
    def joints(self) -> tuple[JointParameters, ...]:
        """Motors and friction."""

    @property
    def hidden(self) -> tuple[Hidden, ...]:
        """What is hidden."""

    @property
    def sensors(self) -> tuple[Sensors, ...]:
        """Sensors."""

    @property
    def compensator(self) -> AnyCompensator | None:
        """Runs in every joint."""

    @property
    def duration_s(self) -> float:
        """Length of the recording. [s]"""

    @property
    def rate_hz(self) -> float:
        """Rate at which states are kept. [Hz]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Joint:
    """A joint as the mechanics read it."""

    inertia_kg_m2: float
    coulomb_nm: float
    viscous_nms_per_rad: float
    hidden: Hidden


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Mechanism:
    """Everything that moves, and where it is written down; n joints.

    Attributes:
        joints: Records of the joints, shape (n,).
        states: What they remember, shape (n,).
        events: Contact events, shape (n, m, 3).
        body: Coordinates and matrices.
        loop: Compensators and what they see.
        clock: The controller's clock.
        out: Truth of every tick, shape (ticks + 1, ROWS, n).
        traced: What the compensators knew, shape (ticks + 1, n, columns); no columns without one.
    """

    joints: np.ndarray[Any, Any]
    states: np.ndarray[Any, Any]
    events: Float
    body: Body
    loop: Loop
    clock: Clock
    out: Float
    traced: Float

    @property
    def parts(self) -> Parts:
        """What the compiled loops work on."""
        return Parts(self.joints, self.states, self.events, self.body, self.loop, self.clock)


def rotor_mass(joints: tuple[JointParameters, ...], hidden: tuple[Hidden, ...]) -> Float:
    """Return the mass matrix of the motors behind the sensors, with what is hidden in it, shape (n, n). [kg m^2]

    Raises:
        UsageError: If an inertia error leaves a joint no inertia.
    """
    pairs = zip(joints, hidden, strict=True)
    inertias = np.array([joint.inertia_kg_m2 + inside.inertia_error.extra_kg_m2 for joint, inside in pairs])
    for number, inertia in enumerate(inertias, start=1):
        if not inertia > 0.0:
            raise UsageError(
                f"inertia_error: extra_kg_m2 leaves joint {number} an inertia of {inertia:g} kg m^2: expected more "
                "than zero"
            )
    return coupled_mass(inertias, np.array([inside.inertial_coupling.ratio for inside in hidden]))


def assemble(settings: Settings, ticks: int, start: Float, streams: Streams, *, driven: bool) -> Mechanism:
    """Build the mechanism at rest; its masses and its drive are the caller's to set.

    Args:
        settings: Joints, what is hidden in them, sensors and compensator.
        ticks: Number of the controller's intervals.
        start: Positions of the joints, shape (n,). [rad]
        streams: Random numbers.
        driven: True if the motors are on the outer side, friction and links on the inner one.
    """
    n = len(settings.joints)
    pairs = list(zip(settings.joints, settings.hidden, strict=True))
    rows = [_Joint(**{name: getattr(joint, name) for name in _NUMBERS}, hidden=inside) for joint, inside in pairs]
    drawn = [
        contact_event.draw_events(inside.contact_event, settings.duration_s, rng)
        for inside, rng in zip(settings.hidden, streams.events, strict=True)
    ]
    states = np.zeros(n, STATE)
    states["start_rad"], states["driven"] = start, driven
    return Mechanism(
        joints=pack(rows),
        states=states,
        events=pad_events(drawn),
        body=make_body(*_sides(pairs), start),
        loop=make_loop(settings, ticks, streams),
        clock=Clock(dt=1.0 / CONTROL_RATE_HZ, substeps=HALF_SUBSTEPS, duration=settings.duration_s),
        out=np.zeros((ticks + 1, ROWS, n)),
        traced=np.zeros((ticks + 1, n, len(TRACE) if settings.compensator is not None else 0)),
    )


_NUMBERS = ("inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad")


def _sides(pairs: list[tuple[JointParameters, Hidden]]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return which joints turn separately on their two sides, and which are held by bristles."""
    hidden = [inside for _, inside in pairs]
    two = [h.joint_elasticity.compliance_rad_per_nm != 0.0 or h.backlash.gap_rad != 0.0 for h in hidden]
    free = [h.presliding.displacement_rad != 0.0 and joint.coulomb_nm > 0.0 for joint, h in pairs]
    return np.array(two), np.array(free)


def make_loop(settings: Settings, ticks: int, streams: Streams) -> Loop:
    """Draw the noise of the sensors and prepare the compensators."""
    t = np.arange(ticks + 1) / CONTROL_RATE_HZ
    torque, velocity, position = (np.empty((ticks + 1, len(settings.joints))) for _ in range(3))
    for j, (sensors, inside) in enumerate(zip(settings.sensors, settings.hidden, strict=True)):
        noise = draw_noise(ticks, CONTROL_RATE_HZ, sensors, streams.sensors)
        drift = torque_drift.reading_nm(inside.torque_drift, t, streams.drifts[j])
        torque[:, j] = noise.torque + torque_bias.reading_nm(inside.torque_bias, t) + drift
        velocity[:, j], position[:, j] = noise.velocity, noise.position
    return Loop(
        settings=pack_compensators(of_each_joint(settings.compensator, len(settings.joints)), CONTROL_RATE_HZ),
        memory=fresh_memory(len(settings.joints)),
        torque_noise=torque,
        velocity_noise=velocity,
        position_noise=position,
        torque_step=np.array([sensors.torque_step_nm for sensors in settings.sensors]),
        velocity_step=np.array([sensors.velocity_step_rad_s for sensors in settings.sensors]),
    )
