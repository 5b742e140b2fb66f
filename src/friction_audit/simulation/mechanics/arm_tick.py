"""One tick of a whole arm."""

import math

from friction_audit.compensation.controller import FIND, trace
from friction_audit.compensation.hand_cycles import INITIATION_M_S, TERMINATION_M_S, UNDER_WAY, hand_rests
from friction_audit.compensation.records import Record
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.mechanics.tick import advance, control, evaluate, keep, quantised


@compiled()
def load_masses(body: Record, outer: Float, inner: Float) -> None:
    """Set the mass matrices of the two sides of the joints, shape (n, n) each."""
    n = body.joints
    body.mass[:] = 0.0
    for i in range(n):
        for j in range(n):
            body.mass[i, j] += outer[i, j]
            body.mass[body.inner[i], body.inner[j]] += inner[i, j]
            body.inner_mass[i, j] = inner[i, j]


@compiled()
def guide(  # noqa: PLR0913
    body: Record,
    mass: Float,
    bias: Float,
    jacobian: Float,
    springs: Float,
    dampers: Float,
    pull: Float,
    pull_rate: Float,
    q: Float,
    rotor: Float,
    support: Float,
) -> None:
    """Let the hand pull at the arm: its springs and dampers seen from the joints, linear about the pose q.

    Args:
        body: Coordinates and matrices; changed.
        mass: Mass matrix of the links, shape (n, n). [kg m^2]
        bias: Coriolis and gravity torque, shape (n,). [N m]
        jacobian: Of the flange in the world's axes, shape (6, n).
        springs: Stiffness along the six directions, shape (6,).
        dampers: Damping along them, shape (6,).
        pull: Force and moment of a hand at rest in the pose, shape (6,). [N, N m]
        pull_rate: Their rate of change as the intention moves on, shape (6,).
        q: The pose, shape (n,). [rad]
        rotor: Mass matrix of the motors, shape (n, n). [kg m^2]
        support: Gravity compensation, shape (n,). [N m]
    """
    n = len(q)
    load_masses(body, mass, rotor)
    for i in range(n):
        push, rate = -bias[i], 0.0
        for a in range(6):
            push += jacobian[a, i] * pull[a]
            rate += jacobian[a, i] * pull_rate[a]
        for j in range(n):
            stiffness = damping = 0.0
            for a in range(6):
                stiffness += jacobian[a, i] * springs[a] * jacobian[a, j]
                damping += jacobian[a, i] * dampers[a] * jacobian[a, j]
            body.stiffness[i, j], body.drive_damping[i, j] = stiffness, damping
            push += stiffness * q[j]
        body.push[i], body.push_rate[i], body.support[i] = push, rate, support[i]


@compiled()
def hand_cut(body: Record, loop: Record, jacobian: Float, cycle: Float, k: int, dt: float) -> int:
    """Return 1 if an energy cycle of the hand ends at this tick (paper, section V.B), else 0.

    It ends when the hand has come to rest and every joint has moved; until then the cycle goes on.
    """
    square = 0.0
    for a in range(3):
        along = 0.0
        for j in range(body.joints):
            velocity = quantised(body.v[j] + loop.velocity_noise[k, j], loop.velocity_step[j])
            along += jacobian[a, j] * velocity
        square += along * along
    if not hand_rests(cycle, math.sqrt(square), dt, INITIATION_M_S, TERMINATION_M_S):
        return 0
    for j in range(body.joints):
        if loop.memory[j].path_rad < loop.settings[j].minimum_path_rad:
            return 0
    cycle[UNDER_WAY] = 0.0
    return 1


@compiled()
def tick(
    parts: Record, jacobian: Float, cycle: Float, told: bool, k: int, last: int, out: Float, traced: Float
) -> None:
    """Move on from half a tick before tick k, which is within the recording, to half a tick after it, likewise.

    Args:
        parts: What moves, a ``rows.Parts``; changed.
        jacobian: Of the flange in the world's axes, shape (6, n).
        cycle: What is remembered of the hand, shape (CYCLE_STATE,); changed.
        told: If True the hand ends the cycles of all joints, else each joint its own.
        k: The tick.
        last: The last tick of the recording.
        out: Receives the truth, shape (ticks + 1, ROWS, n).
        traced: Receives what the compensators knew, shape (ticks + 1, n, columns), or no columns at all.
    """
    joints, states, events, body, loop, clock = parts
    t, half = k * clock.dt, 0.5 * clock.dt
    if k > 0:
        advance(joints, states, events, body, clock, t - half, -half)
    evaluate(joints, states, events, body, clock, t)
    keep(states, body, out[k])
    cut = hand_cut(body, loop, jacobian, cycle, k, clock.dt) if told else FIND
    control(joints, states, body, loop, clock, k, cut)
    if traced.shape[2] > 0:
        for j in range(len(joints)):
            trace(loop.memory[j], traced[k, j])
    if k < last:
        advance(joints, states, events, body, clock, t, 0.0)
