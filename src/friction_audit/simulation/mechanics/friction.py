"""Everything behind the torque sensor of one joint: what slides, what holds, what else pulls."""

from friction_audit.compensation.records import Record
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import (
    asymmetric_coulomb,
    asymmetric_viscous,
    cable_spring,
    contact_event,
    friction_step,
    joint_limit_stop,
    load_dependent_friction,
    nonlinear_viscous,
    position_dependent_friction,
    stiction,
    stribeck,
    torque_ripple,
    warm_up,
)


@compiled()
def viscous_now(joint: Record, state: Record, t: float, duration: float) -> float:
    """Return the viscous coefficient at a time. [N m s/rad]"""
    hidden, coefficient = joint.hidden, joint.viscous_nms_per_rad
    if hidden.warm_up.reduction != 0.0:
        coefficient *= warm_up.viscous_factor(hidden.warm_up, state.warmth)
    if hidden.friction_step.change != 0.0:
        coefficient *= friction_step.viscous_factor(hidden.friction_step, t, duration)
    return float(coefficient)


@compiled()
def coulomb_factor(joint: Record, state: Record, q: float, t: float, duration: float) -> float:
    """Return what place, warmth and time make of the Coulomb level."""
    hidden, factor = joint.hidden, 1.0
    if hidden.position_dependent_friction.share != 0.0:
        factor *= position_dependent_friction.factor(hidden.position_dependent_friction, q)
    if hidden.warm_up.reduction != 0.0:
        factor *= warm_up.coulomb_factor(hidden.warm_up, state.warmth)
    if hidden.friction_step.change != 0.0:
        factor *= friction_step.coulomb_factor(hidden.friction_step, t, duration)
    return factor


@compiled()
def sliding_level(
    joint: Record,
    state: Record,
    q: float,
    speed: float,
    sign: float,
    t: float,
    duration: float,
) -> float:
    """Return the friction while the joint slides in a direction, without its linear viscous part. [N m]

    With a frictional lag the viscous part is in it: it then depends on the speed that friction sees.
    """
    hidden, level = joint.hidden, joint.coulomb_nm
    lagging = hidden.frictional_lag.lag_s != 0.0
    seen = state.speed_seen if lagging else speed
    if hidden.stribeck.excess_nm != 0.0:
        level += stribeck.excess_nm(hidden.stribeck, seen)
    level *= coulomb_factor(joint, state, q, t, duration)
    if hidden.load_dependent_friction.share != 0.0:
        power = state.port_nm * sign * speed * (-1.0 if state.driven else 1.0)
        level += load_dependent_friction.extra_nm(hidden.load_dependent_friction, state.port_nm, power)
    if hidden.nonlinear_viscous.torque_nm != 0.0:
        level += nonlinear_viscous.extra_nm(hidden.nonlinear_viscous, seen)
    level += asymmetric_coulomb.extra_nm(hidden.asymmetric_coulomb, sign)
    level += asymmetric_viscous.extra_nm(hidden.asymmetric_viscous, sign, seen)
    if lagging:
        return max(0.0, float(level + viscous_now(joint, state, t, duration) * seen))
    if level < 0.0:
        # What asymmetric viscous friction takes off in one direction is taken off the linear viscous part.
        level = max(level, -viscous_now(joint, state, t, duration) * speed)
    return float(level)


@compiled()
def holding_level(
    joint: Record,
    state: Record,
    q: float,
    sign: float,
    t: float,
    duration: float,
) -> float:
    """Return the torque that friction can hold against at rest before the joint breaks away. [N m]"""
    level = sliding_level(joint, state, q, 0.0, sign, t, duration)
    extra = stiction.excess_nm(joint.hidden.stiction, state.rest_s)
    return level + extra * coulomb_factor(joint, state, q, t, duration)


@compiled()
def cogging_torque(joint: Record, q: float) -> float:
    """Return the torque of a motor that cogs, positive towards positive velocity. [N m]"""
    if joint.hidden.torque_ripple.torque_nm == 0.0:
        return 0.0
    return float(torque_ripple.torque_nm(joint.hidden.torque_ripple, q))


@compiled()
def other_torque(joint: Record, state: Record, events: Float, q: float, dq: float, t: float) -> float:
    """Return what pulls at the joint behind the sensor besides friction, positive towards positive velocity. [N m]"""
    hidden = joint.hidden
    torque = state.compensation_nm + state.unlogged_nm
    if hidden.cable_spring.stiffness_nm_per_rad != 0.0:
        torque += cable_spring.torque_nm(hidden.cable_spring, q - state.start_rad)
    if hidden.joint_limit_stop.stiffness_nm_per_rad != 0.0:
        torque += joint_limit_stop.torque_nm(hidden.joint_limit_stop, q - state.start_rad, dq)
    if hidden.contact_event.torque_nm != 0.0:
        torque += contact_event.torque_nm(hidden.contact_event, events, t, dq)
    return float(torque)
