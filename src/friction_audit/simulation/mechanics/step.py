"""Acceleration of coordinates that slide, stick or are free, with friction holding what it can."""

import math

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import velocity
from friction_audit.simulation.mechanics.friction import (
    bristle_level,
    load_drive,
    load_friction,
    load_joint,
    regulate_torque,
)
from friction_audit.simulation.mechanics.records import FREE


@compiled(inline=True)
def solve(body: Record) -> None:
    """Solve the equations of the coordinates that are not stuck, in place; they are positive definite (Cholesky)."""
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
def _move_the_active(body: Record, h: float) -> None:
    """Give the coordinates that are not stuck their accelerations, damping taken at the middle of the step."""
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
    solve(body)
    for i in range(count):
        body.a[body.active[i]] = body.right[i]


@compiled()
def _release(body: Record, h: float) -> bool:
    """Free the stuck coordinate that is pulled most beyond what friction can bear; return whether there is one."""
    worst, excess, way = -1, 0.0, 0.0
    for c in range(body.count):
        if body.mode[c] == 0.0:
            pull = body.force[c]
            for k in range(body.count):
                pull -= body.mass[c, k] * body.a[k] + body.damping[c, k] * (body.v[k] + 0.5 * h * body.a[k])
            body.reaction[c] = pull
            over = max(pull - body.hold[c, 1], -pull - body.hold[c, 0])
            if over > excess:
                worst, excess, way = c, over, math.copysign(1.0, pull)
    if worst < 0:
        return False
    body.mode[worst] = way
    body.level[worst] = body.slip[worst, 1 if way > 0.0 else 0]
    return True


@compiled(inline=True)
def _hold_again(body: Record) -> bool:
    """Hold a coordinate that broke away and that others, free since then, pull back; return whether there is one."""
    for c in range(body.count):
        if body.v[c] == 0.0 and abs(body.mode[c]) == 1.0 and body.a[c] * body.mode[c] < 0.0:
            body.mode[c] = 0.0
            return True
    return False


@compiled()
def accelerate(body: Record, h: float) -> None:
    """Set ``a`` for a step h, or at 0 of the instant, ``mode`` of what breaks away, ``reaction`` of what sticks."""
    _move_the_active(body, h)
    for _ in range(2 * body.count):
        if not (_hold_again(body) or _release(body, h)):
            break
        _move_the_active(body, h)


ROOT_ITERATIONS = 3
EVENTS = 32  # stops within a step; what comes after is taken without stopping again


@compiled(inline=True)
def _first_stop(body: Record, h: float) -> tuple[int, float]:
    """Return the sliding coordinate that stops first within a step, or -1, and the share of the step."""
    first, share = -1, 1.0
    for c in range(body.count):
        mode = body.mode[c]
        after = body.v[c] + h * body.a[c]
        if abs(mode) == 1.0 and after * mode < 0.0:
            # Two that stop at one instant: the second may have gone past zero already, at the end of the step even.
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
        way = 0.5 * h * (body.v[c] + after)
        if body.joint[c] >= 0:
            # The time at rest, or the work of friction over this piece of the way.
            state, mode = states[body.joint[c]], body.mode[c]
            if mode == 0.0:
                state.rest_s += h
            else:
                state.rest_s = 0.0
                sign = 1.0 if mode == FREE else mode
                state.dissipated_j += sign * body.level[c] * way + body.viscous[body.joint[c]] * way * way / h
        body.y[c] += way
        body.v[c] = after


@compiled()
def _remember(joint: Record, state: Record, body: Record, j: int, t: float, h: float, duration: float) -> None:
    """Let the bristles of a joint follow its motion for a time h."""
    q, dq = body.y[body.inner[j]], body.v[body.inner[j]]
    if joint.hidden.presliding.displacement_rad != 0.0:
        level = bristle_level(joint, state, q, dq, t, duration)
        velocity.presliding_advance(joint.hidden.presliding, state.bristles, joint.coulomb_nm, level, dq, h)


@compiled()
def slide(
    joints: Record, states: Record, events: Float, body: Record, since: float, t: float, h: float, duration: float
) -> None:
    """Move on by h, stopping and turning every coordinate exactly where its velocity is zero.

    Position forces are taken at the middle of the step (drift, kick, drift), damping is implicit.
    States and body change. ``since`` counts from the tick that the drive's torque refers to. [s]
    """
    for j in range(len(joints)):
        _remember(joints[j], states[j], body, j, t, 0.5 * h, duration)
        if joints[j].torque_loop.gain != 0.0 or joints[j].torque_loop.damping_s != 0.0:
            regulate_torque(joints[j], states[j], body, j, h)
    load_drive(body, since + 0.5 * h, 0.5 * h)
    for j in range(len(joints)):
        load_joint(joints[j], states[j], events[j], body, j, 0.5 * h, t + 0.5 * h, duration)
    left = h
    for _ in range(EVENTS):
        accelerate(body, left)
        c, share = _first_stop(body, left)
        if c < 0:
            break
        time = _stop_time(body, c, left, share)
        _drift(states, body, time)
        body.v[c], body.mode[c] = 0.0, 0.0
        load_friction(joints[body.joint[c]], states[body.joint[c]], body, body.joint[c], 0.0, t + h, duration)
        left -= time
    else:
        accelerate(body, left)
    _drift(states, body, left)
    for j in range(len(joints)):
        _remember(joints[j], states[j], body, j, t + h, 0.5 * h, duration)
        speed = abs(body.v[body.inner[j]])
        states[j].speed_seen = velocity.frictional_lag_speed(joints[j].hidden.frictional_lag, states[j].lag, speed, h)
