"""Torques in a joint at one instant, and an integration step of coordinates that slide, stick or are free."""

import math

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import load_and_place, slow_and_events, structure, velocity
from friction_audit.simulation.mechanics.records import FREE, LOOP_MEMORY


@compiled()
def viscous_coefficient(joint: Record, state: Record, t: float) -> float:
    """Return the viscous coefficient at a time. [N m s/rad]"""
    hidden, coefficient = joint.hidden, joint.viscous_nms_per_rad
    if hidden.warm_up.reduction != 0.0:
        coefficient *= slow_and_events.warm_up_viscous_factor(hidden.warm_up, state.warmth)
    step = hidden.friction_step
    if step.change != 0.0:
        coefficient *= slow_and_events.friction_step_factor(step, step.viscous_ratio, t, state.duration_s)
    return float(coefficient)


@compiled()
def coulomb_factor(joint: Record, state: Record, q: float, t: float) -> float:
    """Return the factor of the Coulomb level by position, warmth and time."""
    hidden, factor = joint.hidden, 1.0
    if hidden.position_dependent_friction.share != 0.0:
        factor *= load_and_place.position_factor(hidden.position_dependent_friction, q)
    if hidden.warm_up.reduction != 0.0:
        factor *= slow_and_events.warm_up_coulomb_factor(hidden.warm_up, state.warmth)
    if hidden.friction_step.change != 0.0:
        factor *= slow_and_events.friction_step_factor(hidden.friction_step, 1.0, t, state.duration_s)
    return factor


@compiled()
def sliding_level(joint: Record, state: Record, q: float, speed: float, sign: float, t: float) -> float:
    """Return the kinetic friction in a direction, without the viscous part unless friction lags. [N m]"""
    hidden, level = joint.hidden, joint.coulomb_nm
    lagging = hidden.frictional_lag.lag_s != 0.0
    seen = state.speed_seen if lagging else speed
    if hidden.stribeck.excess_nm != 0.0:
        level += velocity.stribeck_nm(hidden.stribeck, seen)
    level *= coulomb_factor(joint, state, q, t)
    if hidden.load_dependent_friction.share != 0.0:
        power = state.port_nm * sign * speed * (-1.0 if state.driven else 1.0)
        level += load_and_place.load_friction_nm(hidden.load_dependent_friction, state.port_nm, power)
    if hidden.nonlinear_viscous.torque_nm != 0.0:
        level += velocity.nonlinear_viscous_nm(hidden.nonlinear_viscous, seen)
    level += hidden.asymmetric_coulomb.half_difference_nm * sign
    level += hidden.asymmetric_viscous.half_difference_nms_per_rad * sign * seen
    if lagging:
        return max(0.0, float(level + viscous_coefficient(joint, state, t) * seen))
    if level < 0.0:
        # Asymmetric viscous friction may reduce the viscous part in one direction, to zero at most.
        level = max(level, -viscous_coefficient(joint, state, t) * speed)
    return float(level)


@compiled(inline=True)
def control_torque(joint: Record, state: Record, body: Record, j: int, h: float) -> None:
    """Update the torque of the joint torque control over a step h, from the torque one dead time ago."""
    loop, c, gap, gear = joint.torque_loop, body.inner[j], joint.hidden.backlash, joint.hidden.joint_elasticity
    twist, closing = body.y[c] - body.y[j], body.v[c] - body.v[j]
    torque = structure.elastic_torque_nm(gear, structure.engaged(gap, twist))
    rate = (structure.elastic_torque_nm(gear, structure.engaged(gap, twist + h * closing)) - torque) / h
    wanted = body.support[j] + state.compensation_nm + state.unlogged_nm
    state.loop_past[state.loop_steps % LOOP_MEMORY] = loop.gain * (wanted - torque) - loop.damping_s * rate
    state.loop_nm = state.loop_past[(state.loop_steps - round(loop.dead_time_s / h)) % LOOP_MEMORY]
    state.loop_steps += 1


@compiled()
def set_drive(body: Record, since: float, ahead: float) -> None:
    """Set torques and damping of the drive at a time ``since`` the tick, positions extrapolated by ``ahead``. [s]"""
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
def add_torques(joint: Record, state: Record, events: Float, body: Record, j: int, ahead: float, t: float) -> None:
    """Add the torques inside one joint: transmission, friction, other torques on the inner side."""
    c, hidden = body.inner[j], joint.hidden
    if c != j:
        _add_transmission(joint, body, j, ahead)
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
    body.viscous[j] = 0.0 if hidden.frictional_lag.lag_s != 0.0 else viscous_coefficient(joint, state, t)
    body.damping[c, c] += body.viscous[j]
    set_friction(joint, state, body, j, ahead, t)


@compiled()
def set_friction(joint: Record, state: Record, body: Record, j: int, ahead: float, t: float) -> None:
    """Set the friction of one joint: kinetic if it slides, static limits if it sticks, bristles if it is free."""
    c = body.inner[j]
    q, dq, mode, bent = body.y[c] + ahead * body.v[c], body.v[c] + ahead * body.a[c], body.mode[c], state.bristles
    if mode == FREE:
        level = sliding_level(joint, state, q, abs(dq), 1.0 if dq >= 0.0 else -1.0, t)
        body.level[c] = velocity.presliding_force_nm(joint.hidden.presliding, bent, joint.coulomb_nm, level, dq)
    elif mode == 0.0:
        extra = velocity.stiction_nm(joint.hidden.stiction, state.rest_s) * coulomb_factor(joint, state, q, t)
        for row in range(2):
            body.slip[c, row] = sliding_level(joint, state, q, 0.0, 2.0 * row - 1.0, t)
            body.hold[c, row] = body.slip[c, row] + extra
    else:
        body.level[c] = sliding_level(joint, state, q, max(0.0, dq * mode), mode, t)


@compiled(inline=True)
def _add_transmission(joint: Record, body: Record, j: int, ahead: float) -> None:
    """Add spring and damper, or the contact of the backlash, between the two sides of a joint."""
    c = body.inner[j]
    twist = body.y[c] + ahead * body.v[c] - body.y[j] - ahead * body.v[j]
    elastic, backlash = joint.hidden.joint_elasticity, joint.hidden.backlash
    engaged = structure.engaged(backlash, twist)
    if engaged == 0.0 and backlash.gap_rad != 0.0:
        return
    reduced = body.mass[c, c] * body.mass[j, j] / (body.mass[c, c] + body.mass[j, j])
    torque, compliance = structure.elastic_torque_nm(elastic, engaged), elastic.compliance_rad_per_nm
    ratio = elastic.damping_ratio
    if compliance == 0.0:
        compliance, ratio = backlash.contact_compliance_rad_per_nm, backlash.contact_damping_ratio
        torque = engaged / compliance
    damping = 2.0 * ratio * math.sqrt(reduced / compliance)
    closing = body.v[c] + ahead * body.a[c] - body.v[j] - ahead * body.a[j]
    if backlash.gap_rad != 0.0 and (torque + damping * closing) * engaged < 0.0:
        return  # the contact never pulls
    body.force[c] -= torque
    body.force[j] += torque
    body.damping[c, c] += damping
    body.damping[j, j] += damping
    body.damping[c, j] -= damping
    body.damping[j, c] -= damping


# Accelerations with static friction, and the step.


@compiled(inline=True)
def solve_cholesky(body: Record) -> None:
    """Solve the positive definite equations of the coordinates that do not stick, in place, by Cholesky."""
    system, right, count = body.system, body.right, body.free
    for i in range(count):
        for j in range(i + 1):
            rest = system[i, j]
            for k in range(j):
                rest -= system[i, k] * system[j, k]
            system[i, j] = math.sqrt(rest) if i == j else rest / system[j, j]
        for k in range(i):
            right[i] -= system[i, k] * right[k]
        right[i] /= system[i, i]
    for i in range(count - 1, -1, -1):
        for k in range(i + 1, count):
            right[i] -= system[k, i] * right[k]
        right[i] /= system[i, i]


@compiled()
def _solve_accelerations(body: Record, h: float) -> None:
    """Solve for the accelerations of the coordinates that do not stick, damping taken at the middle of the step."""
    count = 0
    for c in range(body.count):
        body.a[c] = 0.0
        if body.mode[c] != 0.0:
            body.active[count] = c
            count += 1
    for i in range(count):
        row = body.active[i]
        sign = 1.0 if body.mode[row] == FREE else body.mode[row]
        torque = body.force[row] - sign * body.level[row]
        for c in range(body.count):
            torque -= body.damping[row, c] * body.v[c]
        body.right[i] = torque
        for j in range(i + 1):
            column = body.active[j]
            body.system[i, j] = body.mass[row, column] + 0.5 * h * body.damping[row, column]
    body.free = count
    solve_cholesky(body)
    for i in range(count):
        body.a[body.active[i]] = body.right[i]


@compiled()
def _break_away(body: Record, h: float) -> bool:
    """Break away the stuck coordinate that exceeds its static friction most; return whether there is one."""
    worst, excess, direction = -1, 0.0, 0.0
    for c in range(body.count):
        if body.mode[c] == 0.0:
            pull = body.force[c]
            for k in range(body.count):
                pull -= body.mass[c, k] * body.a[k] + body.damping[c, k] * (body.v[k] + 0.5 * h * body.a[k])
            body.reaction[c] = pull
            over = max(pull - body.hold[c, 1], -pull - body.hold[c, 0])
            if over > excess:
                worst, excess, direction = c, over, math.copysign(1.0, pull)
    if worst < 0:
        return False
    body.mode[worst] = direction
    body.level[worst] = body.slip[worst, 1 if direction > 0.0 else 0]
    return True


@compiled(inline=True)
def _stick_again(body: Record) -> bool:
    """Stick a coordinate again that broke away and is now accelerated back; return whether there is one."""
    for c in range(body.count):
        if body.v[c] == 0.0 and abs(body.mode[c]) == 1.0 and body.a[c] * body.mode[c] < 0.0:
            body.mode[c] = 0.0
            return True
    return False


@compiled()
def accelerate(body: Record, h: float) -> None:
    """Set ``a`` for a step h, or at 0 of the instant, ``mode`` of what breaks away, ``reaction`` of what sticks."""
    _solve_accelerations(body, h)
    for _ in range(2 * body.count):
        if not (_stick_again(body) or _break_away(body, h)):
            break
        _solve_accelerations(body, h)


ROOT_ITERATIONS = 3
EVENTS = 32  # stops within a step; the rest of the step is integrated without stops


@compiled(inline=True)
def _first_stop(body: Record, h: float) -> tuple[int, float]:
    """Return the sliding coordinate that stops first within a step, or -1, and the share of the step."""
    first, share = -1, 1.0
    for c in range(body.count):
        mode = body.mode[c]
        after = body.v[c] + h * body.a[c]
        if abs(mode) == 1.0 and after * mode < 0.0:
            # Of two that stop at one instant, the second may have passed zero already.
            crossing = body.v[c] / (body.v[c] - after) if body.v[c] * mode > 0.0 else 0.0
            if first < 0 or crossing < share:
                first, share = c, crossing
    return first, share


@compiled(inline=True)
def _stop_time(body: Record, c: int, h: float, share: float) -> float:
    """Return the time within the step at which a coordinate stops; damping makes its acceleration depend on it."""
    time = share * h
    for _ in range(ROOT_ITERATIONS):
        accelerate(body, time)
        if body.a[c] * body.v[c] >= 0.0:
            break
        time = min(h, -body.v[c] / body.a[c])
    return time


@compiled()
def _drift(states: Record, body: Record, h: float) -> None:
    if h <= 0.0:
        return
    for c in range(body.count):
        after = body.v[c] + h * body.a[c]
        moved = 0.5 * h * (body.v[c] + after)
        if body.joint[c] >= 0:
            # The time at rest, or the work of friction over this displacement.
            state, mode = states[body.joint[c]], body.mode[c]
            if mode == 0.0:
                state.rest_s += h
            else:
                state.rest_s = 0.0
                sign = 1.0 if mode == FREE else mode
                state.dissipated_j += sign * body.level[c] * moved + body.viscous[body.joint[c]] * moved * moved / h
        body.y[c] += moved
        body.v[c] = after


@compiled()
def _advance_bristles(joint: Record, state: Record, body: Record, j: int, t: float, h: float) -> None:
    q, dq = body.y[body.inner[j]], body.v[body.inner[j]]
    if body.mode[body.inner[j]] == FREE:
        level = sliding_level(joint, state, q, abs(dq), 1.0 if dq >= 0.0 else -1.0, t)
        velocity.presliding_advance(joint.hidden.presliding, state.bristles, joint.coulomb_nm, level, dq, h)


@compiled()
def advance(joints: Record, states: Record, events: Float, body: Record, since: float, t: float, h: float) -> None:
    """Integrate over h; the step is split at the instants at which a velocity passes zero.

    Position forces are taken at the middle of the step (leapfrog: drift, kick, drift), damping is implicit.
    States and body change. ``since`` is the time since the tick of the drive's torque. [s]
    """
    for j in range(len(joints)):
        _advance_bristles(joints[j], states[j], body, j, t, 0.5 * h)
        if joints[j].torque_loop.gain != 0.0 or joints[j].torque_loop.damping_s != 0.0:
            control_torque(joints[j], states[j], body, j, h)
    set_drive(body, since + 0.5 * h, 0.5 * h)
    for j in range(len(joints)):
        add_torques(joints[j], states[j], events[j], body, j, 0.5 * h, t + 0.5 * h)
    left = h
    for _ in range(EVENTS):
        accelerate(body, left)
        c, share = _first_stop(body, left)
        if c < 0:
            break
        time = _stop_time(body, c, left, share)
        _drift(states, body, time)
        body.v[c], body.mode[c] = 0.0, 0.0
        set_friction(joints[body.joint[c]], states[body.joint[c]], body, body.joint[c], 0.0, t + h)
        left -= time
    else:
        accelerate(body, left)
    _drift(states, body, left)
    for j in range(len(joints)):
        _advance_bristles(joints[j], states[j], body, j, t + h, 0.5 * h)
        speed = abs(body.v[body.inner[j]])
        states[j].speed_seen = velocity.frictional_lag_speed(joints[j].hidden.frictional_lag, states[j].lag, speed, h)
