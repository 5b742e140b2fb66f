"""Torques in a joint at one instant, friction and all others, put on the coordinates."""

import math

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import load_and_place, slow_and_events, structure, velocity
from friction_audit.simulation.mechanics.records import FREE, LOOP_MEMORY

LEAST_LEVEL_NM = 1e-9  # bristles divide by the level


@compiled()
def viscous_now(joint: Record, state: Record, t: float, duration: float) -> float:
    """Return the viscous coefficient at a time. [N m s/rad]"""
    hidden, coefficient = joint.hidden, joint.viscous_nms_per_rad
    if hidden.warm_up.reduction != 0.0:
        coefficient *= slow_and_events.warm_up_viscous_factor(hidden.warm_up, state.warmth)
    step = hidden.friction_step
    if step.change != 0.0:
        coefficient *= slow_and_events.friction_step_factor(step, step.viscous_ratio, t, duration)
    return float(coefficient)


@compiled()
def coulomb_factor(joint: Record, state: Record, q: float, t: float, duration: float) -> float:
    """Return what place, warmth and time make of the Coulomb level."""
    hidden, factor = joint.hidden, 1.0
    if hidden.position_dependent_friction.share != 0.0:
        factor *= load_and_place.place_factor(hidden.position_dependent_friction, q)
    if hidden.warm_up.reduction != 0.0:
        factor *= slow_and_events.warm_up_coulomb_factor(hidden.warm_up, state.warmth)
    if hidden.friction_step.change != 0.0:
        factor *= slow_and_events.friction_step_factor(hidden.friction_step, 1.0, t, duration)
    return factor


@compiled()
def sliding_level(
    joint: Record, state: Record, q: float, speed: float, sign: float, t: float, duration: float
) -> float:
    """Return the friction of sliding in a direction; only with a frictional lag its viscous part is in it. [N m]"""
    hidden, level = joint.hidden, joint.coulomb_nm
    lagging = hidden.frictional_lag.lag_s != 0.0
    seen = state.speed_seen if lagging else speed
    if hidden.stribeck.excess_nm != 0.0:
        level += velocity.stribeck_nm(hidden.stribeck, seen)
    level *= coulomb_factor(joint, state, q, t, duration)
    if hidden.load_dependent_friction.share != 0.0:
        power = state.port_nm * sign * speed * (-1.0 if state.driven else 1.0)
        level += load_and_place.load_friction_nm(hidden.load_dependent_friction, state.port_nm, power)
    if hidden.nonlinear_viscous.torque_nm != 0.0:
        level += velocity.nonlinear_viscous_nm(hidden.nonlinear_viscous, seen)
    level += hidden.asymmetric_coulomb.half_difference_nm * sign
    level += hidden.asymmetric_viscous.half_difference_nms_per_rad * sign * seen
    if lagging:
        return max(0.0, float(level + viscous_now(joint, state, t, duration) * seen))
    if level < 0.0:
        # What asymmetric viscous friction takes off in one direction is taken off the linear viscous part.
        level = max(level, -viscous_now(joint, state, t, duration) * speed)
    return float(level)


@compiled(inline=True)
def bristle_level(joint: Record, state: Record, q: float, dq: float, t: float, duration: float) -> float:
    """Return the friction of a joint on bristles that slides steadily. [N m]"""
    return max(LEAST_LEVEL_NM, sliding_level(joint, state, q, abs(dq), 1.0 if dq >= 0.0 else -1.0, t, duration))


@compiled(inline=True)
def regulate_torque(joint: Record, state: Record, body: Record, j: int, h: float) -> None:
    """Let the joint torque control of a joint feed back, over a step of length h, the torque of its dead time ago."""
    loop, c, gap, gear = joint.torque_loop, body.inner[j], joint.hidden.backlash, joint.hidden.joint_elasticity
    twist, closing = body.y[c] - body.y[j], body.v[c] - body.v[j]
    torque = structure.elastic_torque_nm(gear, structure.engaged(gap, twist))
    rate = (structure.elastic_torque_nm(gear, structure.engaged(gap, twist + h * closing)) - torque) / h
    wanted = body.support[j] + state.compensation_nm + state.unlogged_nm
    state.loop_past[state.loop_steps % LOOP_MEMORY] = loop.gain * (wanted - torque) - loop.damping_s * rate
    state.loop_nm = state.loop_past[(state.loop_steps - round(loop.dead_time_s / h)) % LOOP_MEMORY]
    state.loop_steps += 1


@compiled()
def load_drive(body: Record, since: float, ahead: float) -> None:
    """Set torques and damping of the drive for an instant ``since`` its tick, ``ahead`` of the present positions."""
    n = body.joints
    for i in range(body.count):
        body.force[i] = 0.0
        for k in range(body.count):
            body.damping[i, k] = 0.0
    for i in range(n):
        torque = body.push[i] + since * (body.push_rate[i] + 0.5 * since * body.push_bend[i])
        for k in range(n):
            torque -= body.stiffness[i, k] * (body.y[k] + ahead * body.v[k])
            body.damping[i, k] = body.drive_damping[i, k]
        body.force[i] = torque


@compiled()
def load_joint(
    joint: Record, state: Record, events: Float, body: Record, j: int, ahead: float, t: float, duration: float
) -> None:
    """Add what acts inside one joint: transmission, friction, the other torques on the inner side."""
    c, hidden = body.inner[j], joint.hidden
    if c != j:
        _load_transmission(joint, body, j, ahead)
    q, dq = body.y[c] + ahead * body.v[c], body.v[c] + ahead * body.a[c]
    torque = state.compensation_nm + state.unlogged_nm + state.loop_nm
    if hidden.cable_spring.stiffness_nm_per_rad != 0.0:
        torque += load_and_place.cable_spring_nm(hidden.cable_spring, q - state.start_rad)
    if hidden.joint_limit_stop.stiffness_nm_per_rad != 0.0:
        torque += load_and_place.limit_stop_nm(hidden.joint_limit_stop, q - state.start_rad, dq)
    if hidden.contact_event.torque_nm != 0.0:
        torque += slow_and_events.contact_event_nm(hidden.contact_event, events, t, dq)
    body.inner_torque[j] = body.support[j] + torque
    if state.driven:
        body.force[j] += load_and_place.cogging_nm(hidden.torque_ripple, body.y[j] + ahead * body.v[j])
    else:
        body.inner_torque[j] += load_and_place.cogging_nm(hidden.torque_ripple, q)
    body.force[c] += body.inner_torque[j]
    body.viscous[j] = 0.0 if hidden.frictional_lag.lag_s != 0.0 else viscous_now(joint, state, t, duration)
    body.damping[c, c] += body.viscous[j]
    load_friction(joint, state, body, j, ahead, t, duration)


@compiled()
def load_friction(joint: Record, state: Record, body: Record, j: int, ahead: float, t: float, duration: float) -> None:
    """Set what friction does to one joint, sliding, stuck or free."""
    c = body.inner[j]
    q, dq, mode, bent = body.y[c] + ahead * body.v[c], body.v[c] + ahead * body.a[c], body.mode[c], state.bristles
    if mode == FREE:
        level = bristle_level(joint, state, q, dq, t, duration)
        body.level[c] = velocity.presliding_force_nm(joint.hidden.presliding, bent, joint.coulomb_nm, level, dq)
    elif mode == 0.0:
        extra = velocity.stiction_nm(joint.hidden.stiction, state.rest_s) * coulomb_factor(joint, state, q, t, duration)
        for way in range(2):
            body.slip[c, way] = sliding_level(joint, state, q, 0.0, 2.0 * way - 1.0, t, duration)
            body.hold[c, way] = body.slip[c, way] + extra
    else:
        body.level[c] = sliding_level(joint, state, q, max(0.0, dq * mode), mode, t, duration)


@compiled(inline=True)
def _load_transmission(joint: Record, body: Record, j: int, ahead: float) -> None:
    """Add the spring and the damper, or the flanks, between the two sides of a joint."""
    c = body.inner[j]
    stretch = body.y[c] + ahead * body.v[c] - body.y[j] - ahead * body.v[j]
    elastic, flanks = joint.hidden.joint_elasticity, joint.hidden.backlash
    engaged = structure.engaged(flanks, stretch)
    if engaged == 0.0 and flanks.gap_rad != 0.0:
        return
    ringing = body.mass[c, c] * body.mass[j, j] / (body.mass[c, c] + body.mass[j, j])
    torque, compliance = structure.elastic_torque_nm(elastic, engaged), elastic.compliance_rad_per_nm
    ratio = elastic.damping_ratio
    if compliance == 0.0:
        compliance, ratio = flanks.contact_compliance_rad_per_nm, flanks.contact_damping_ratio
        torque = engaged / compliance
    damping = 2.0 * ratio * math.sqrt(ringing / compliance)
    closing = body.v[c] + ahead * body.a[c] - body.v[j] - ahead * body.a[j]
    if flanks.gap_rad != 0.0 and (torque + damping * closing) * engaged < 0.0:
        return  # Flanks that part push no more, and they never pull.
    body.force[c] -= torque
    body.force[j] += torque
    body.damping[c, c] += damping
    body.damping[j, j] += damping
    body.damping[c, j] -= damping
    body.damping[j, c] -= damping
