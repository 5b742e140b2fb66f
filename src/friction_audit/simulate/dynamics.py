"""The joint held by the hand: B ddq = F_m + u - tau_f with exact sticking, on the joint's own clock."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulate.operator import intended_motion, plan_strokes
from friction_audit.simulate.settings import SUBSTEPS, JointSettings


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Motion:
    """What truly happened at every tick of the joint's clock, free of noise, shape (n + 1,) each.

    Attributes:
        t: Time. [s]
        q: Position. [rad]
        dq: Velocity; exactly 0 where friction holds the joint. [rad/s]
        ddq: Acceleration. [rad/s^2]
        interaction_nm: Interaction torque F_m at the sensor. [N m]
        friction_nm: Friction torque tau_f; at rest whatever holds the joint. [N m]
        compensation_nm: Torque u of the compensator. [N m]
        dissipated_j: Energy that friction has taken so far. [J]
    """

    t: Float
    q: Float
    dq: Float
    ddq: Float
    interaction_nm: Float
    friction_nm: Float
    compensation_nm: Float
    dissipated_j: Float


def move(settings: JointSettings, rng: np.random.Generator) -> Motion:
    """Let the person move the joint.

    Hand and joint are one mass; the hand's spring and damper, the compensator and friction act on it. It is
    integrated by the trapezoidal rule on a grid SUBSTEPS times finer than the log, reversals located inside a step.
    F_m comes from the acceleration at the tick itself, so that the sampled power is the power at that instant.
    """
    from friction_audit.simulate import kernels

    ticks, h = settings.ticks, 1.0 / (settings.rate_hz * SUBSTEPS)
    strokes = plan_strokes(settings.operator, settings.duration_s, rng)
    place, speed = intended_motion(strokes, np.arange(ticks * SUBSTEPS + 1, dtype=np.float64) * h)
    rows = kernels.integrate(place, speed, h, SUBSTEPS, _body(settings), _compensator(settings))
    q, dq, ddq, compensation, dissipated = rows
    hand, joint = settings.operator, settings.joint
    force = hand.stiffness_nm_per_rad * (place[::SUBSTEPS] - q) + hand.damping_nms_per_rad * (speed[::SUBSTEPS] - dq)
    interaction = force - hand.inertia_kg_m2 * ddq
    return Motion(
        t=np.arange(ticks + 1) / settings.rate_hz,
        q=q,
        dq=dq,
        ddq=ddq,
        interaction_nm=interaction,
        friction_nm=interaction + compensation - joint.inertia_kg_m2 * ddq,
        compensation_nm=compensation,
        dissipated_j=dissipated,
    )


def _body(settings: JointSettings) -> Float:
    """Pack the moving mass and what acts on it, in the order that the kernels expect."""
    hand, joint = settings.operator, settings.joint
    mass = hand.inertia_kg_m2 + joint.inertia_kg_m2
    numbers = (mass, hand.stiffness_nm_per_rad, hand.damping_nms_per_rad, joint.coulomb_nm, joint.viscous_nms_per_rad)
    return np.array(numbers, dtype=np.float64)


def _compensator(settings: JointSettings) -> Float:
    """Pack the compensator; without one, both coefficients are zero."""
    active = settings.compensation
    if active is None:
        return np.zeros(3)
    return np.array((active.coulomb_nm, active.viscous_nms_per_rad, active.dead_band_rad_s))
