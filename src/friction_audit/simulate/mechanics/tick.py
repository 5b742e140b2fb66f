"""One tick of the controller's clock: move, read the sensors, compensate, move on."""

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.replay.kernels import FIND, trace
from friction_audit.replay.kernels import step as compensate
from friction_audit.replay.records import Record
from friction_audit.simulate.effects import unlogged_compensation, warm_up
from friction_audit.simulate.mechanics.accelerate import accelerate
from friction_audit.simulate.mechanics.body import FREE
from friction_audit.simulate.mechanics.load import load_drive, load_joint
from friction_audit.simulate.mechanics.rows import (
    ACCELERATION,
    COMPENSATION,
    DISSIPATED,
    FRICTION,
    INNER,
    OUTER,
    OUTER_SPEED,
    PASSIVITY,
    PORT,
    SPEED,
    SUPPORT,
    UNLOGGED,
    WARMTH,
)
from friction_audit.simulate.mechanics.sensing import quantised
from friction_audit.simulate.mechanics.step import slide


@compiled()
def advance(
    joints: Record,
    states: Record,
    events: Float,
    body: Record,
    clock: Record,
    t: float,
    since: float,
) -> None:
    """Move on by half a tick."""
    h = 0.5 * clock.dt / clock.substeps
    for i in range(clock.substeps):
        slide(joints, states, events, body, since + i * h, t + i * h, h, clock.duration)


@compiled()
def evaluate(joints: Record, states: Record, events: Float, body: Record, clock: Record, t: float) -> None:
    """Find accelerations, friction and the torques at the sensors at an instant."""
    load_drive(body, 0.0, 0.0)
    for j in range(len(joints)):
        load_joint(joints[j], states[j], events[j], body, j, 0.0, t, clock.duration)
    accelerate(body, 0.0)
    for j in range(len(joints)):
        c = body.inner[j]
        if body.mode[c] == 0.0:
            body.friction[j] = body.reaction[c]
        else:
            sign = 1.0 if body.mode[c] == FREE else body.mode[c]
            body.friction[j] = sign * body.level[c] + body.viscous[j] * body.v[c]
        torque = body.friction[j] - body.behind[j]
        for k in range(len(joints)):
            torque += body.inner_mass[j, k] * body.a[body.inner[k]]
        body.port[j] = torque


@compiled()
def keep(states: Record, body: Record, out: Float) -> None:
    """Write the truth of an instant into ``out``, shape (ROWS, n)."""
    for j in range(len(states)):
        c = body.inner[j]
        out[OUTER, j], out[OUTER_SPEED, j], out[INNER, j], out[SPEED, j] = body.y[j], body.v[j], body.y[c], body.v[c]
        out[ACCELERATION, j], out[PORT, j], out[SUPPORT, j] = body.a[c], body.port[j], body.support[j]
        out[FRICTION, j], out[COMPENSATION, j] = body.friction[j], states[j].compensation_nm - states[j].passivity_nm
        out[PASSIVITY, j] = states[j].passivity_nm
        out[UNLOGGED, j], out[DISSIPATED, j] = states[j].unlogged_nm, states[j].dissipated_j
        out[WARMTH, j] = states[j].warmth


@compiled()
def control(joints: Record, states: Record, body: Record, loop: Record, clock: Record, k: int, cut: int) -> None:
    """Read the sensors at tick k and set the compensators' torques for the time up to the next tick."""
    for j in range(len(joints)):
        state, hidden = states[j], joints[j].hidden
        power = body.friction[j] * body.v[body.inner[j]]
        state.port_nm = body.port[j]
        state.warmth = warm_up.advance(hidden.warm_up, state.warmth, power, clock.dt)
        velocity = quantised(body.v[j] + loop.velocity_noise[k, j], loop.velocity_step[j])
        state.unlogged_nm = unlogged_compensation.torque_nm(hidden.unlogged_compensation, velocity)
        read = quantised(-body.port[j] - loop.torque_noise[k, j], loop.torque_step[j])
        interaction = body.support[j] - read
        state.compensation_nm = compensate(loop.settings[j], loop.memory[j], velocity, interaction, clock.dt, cut)
        state.passivity_nm = loop.memory[j].passivity_nm


@compiled()
def run_bench(
    parts: Record, push: Float, gravity: Float, driven: bool, first: int, last: int, out: Float, traced: Float
) -> None:
    """Run one joint from tick ``first`` to before ``last``; see ``bench.move``.

    Args:
        parts: What moves, a ``rows.Parts`` of one joint; changed.
        push: Torque of the drive with the joint at zero, at every tick, shape (ticks + 1,). [N m]
        gravity: Amplitude [N m] and phase [rad] of the load's gravity torque, held by the motor.
        driven: If True the load is on the inner side, else on the outer one.
        first: First tick.
        last: Tick to end before.
        out: Receives the truth, shape (ticks + 1, ROWS, 1).
        traced: Receives what the compensator knew, shape (ticks + 1, 1, columns), or no columns at all.
    """
    joints, states, events, body, loop, clock = parts
    half, link = 0.5 * clock.dt, body.inner[0] if driven else 0
    for k in range(first, last):
        t = k * clock.dt
        place = body.y[link] + (half * body.v[link] if k > 0 else 0.0)
        weight = gravity[0] * np.sin(place + gravity[1])
        body.support[0] = -weight if driven else weight
        body.push[0] = push[k] - body.support[0]
        before, after = push[k] - push[max(k - 1, 0)], push[min(k + 1, len(push) - 1)] - push[k]
        body.push_rate[0] = 0.5 * (before + after) / clock.dt
        body.push_bend[0] = (after - before) / clock.dt**2
        if k > 0:
            advance(joints, states, events, body, clock, t - half, -half)
        evaluate(joints, states, events, body, clock, t)
        keep(states, body, out[k])
        control(joints, states, body, loop, clock, k, FIND)
        if traced.shape[2] > 0:
            trace(loop.memory[0], traced[k, 0])
        if k + 1 < len(push):
            advance(joints, states, events, body, clock, t, 0.0)
