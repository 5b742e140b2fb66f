"""One tick of the controller: integrate half a tick, evaluate the torques, read the sensors, run the compensators."""

import math

import numpy as np

from friction_audit.compensation import controller
from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import slow_and_events, structure
from friction_audit.simulation.mechanics import records
from friction_audit.simulation.mechanics.integrator import accelerate, add_torques, advance, set_drive
from friction_audit.simulation.sensors import quantised

HALVINGS = 60  # bisection steps, to the last digit


@compiled()
def set_equilibrium(joints: Record, body: Record, load_nm: Float) -> None:
    """Set the inner sides at rest where the transmissions carry a load; without a load, in the middle of the gap."""
    for j in range(len(joints)):
        elastic, backlash = joints[j].hidden.joint_elasticity, joints[j].hidden.backlash
        if body.inner[j] == j or load_nm[j] == 0.0:
            continue
        # The twist, by bisection; a hardening spring has at most twice the compliance.
        load, soft, contact = abs(load_nm[j]), elastic.compliance_rad_per_nm, backlash.contact_compliance_rad_per_nm
        low, high = 0.0, 2.0 * load * (soft + contact)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            torque = structure.elastic_torque_nm(elastic, middle) if soft != 0.0 else middle / contact
            if torque < load:
                low = middle
            else:
                high = middle
        body.y[body.inner[j]] = body.y[j] + math.copysign(0.5 * (low + high + backlash.gap_rad), load_nm[j])


@compiled()
def integrate(
    joints: Record, states: Record, events: Float, body: Record, dt: float, substeps: int, t: float, since: float
) -> None:
    """Integrate over half a tick."""
    h = 0.5 * dt / substeps
    for i in range(substeps):
        advance(joints, states, events, body, since + i * h, t + i * h, h)


@compiled(inline=True)
def evaluate(joints: Record, states: Record, events: Float, body: Record, t: float) -> None:
    """Evaluate accelerations, friction and the torques at the sensors at an instant."""
    set_drive(body, 0.0, 0.0)
    for j in range(len(joints)):
        add_torques(joints[j], states[j], events[j], body, j, 0.0, t)
    accelerate(body, 0.0)
    for j in range(len(joints)):
        c = body.inner[j]
        if body.mode[c] == 0.0:
            body.friction[j] = body.reaction[c]
        else:
            sign = 1.0 if body.mode[c] == records.FREE else body.mode[c]
            body.friction[j] = sign * body.level[c] + body.viscous[j] * body.v[c]
        torque = body.friction[j] - body.inner_torque[j]
        for k in range(len(joints)):
            torque += body.inner_mass[j, k] * body.a[body.inner[k]]
        body.port[j] = torque


@compiled(inline=True)
def write_truth(states: Record, body: Record, out: Float) -> None:
    """Write the true motion at an instant into ``out``, shape (ROWS, n)."""
    for j in range(len(states)):
        c, interaction = body.inner[j], body.port[j] + body.support[j]
        link = c if states[j].driven else j
        kept = (  # in the order of ``TrueMotion``
            *(body.y[link], body.v[link], body.y[c], body.v[c], body.a[c]),
            *(interaction, body.support[j], body.port[j], body.friction[j]),
            *(states[j].compensation_nm - states[j].passivity_nm, states[j].passivity_nm, states[j].unlogged_nm),
            *(states[j].dissipated_j, states[j].warmth),
        )
        for i in range(records.ROWS):
            out[i, j] = kept[i]


@compiled(inline=True)
def run_controllers(joints: Record, states: Record, body: Record, loop: Record, dt: float, k: int, ends: int) -> None:
    """Read the sensors at tick k and set the compensators' torques for the time up to the next tick."""
    for j in range(len(joints)):
        state, hidden = states[j], joints[j].hidden
        power = body.friction[j] * body.v[body.inner[j]]
        state.port_nm = body.port[j]
        state.warmth = slow_and_events.warm_up_advance(hidden.warm_up, state.warmth, power, dt)
        velocity = quantised(loop.velocity_step[j], body.v[j] + loop.velocity_noise[k, j])
        state.unlogged_nm = slow_and_events.unlogged_nm(hidden.unlogged_compensation, velocity)
        read = quantised(loop.torque_step[j], -body.port[j] - loop.torque_noise[k, j])
        interaction = body.support[j] - read
        state.compensation_nm = controller.step(loop.settings[j], loop.memory[j], velocity, interaction, dt, ends)
        state.passivity_nm = loop.memory[j].passivity_nm


@compiled()
def set_masses(body: Record, outer: Float, inner: Float) -> None:
    """Set the mass matrices of the two sides of the joints, shape (n, n) each."""
    n = body.joints
    body.mass[:] = 0.0
    for i in range(n):
        for j in range(n):
            body.mass[i, j] += outer[i, j]
            body.mass[body.inner[i], body.inner[j]] += inner[i, j]
            body.inner_mass[i, j] = inner[i, j]


@compiled()
def set_hand_impedance(  # noqa: PLR0913
    body: Record,  # coordinates and matrices; changed
    mass: Float,  # of the links, shape (n, n) [kg m^2]
    bias: Float,  # Coriolis and gravity torque, shape (n,) [N m]
    jacobian: Float,  # of the flange in the world's axes, shape (6, n)
    springs: Float,  # stiffness along the six directions, shape (6,)
    dampers: Float,  # damping along them, shape (6,)
    pull: Float,  # force and moment of a hand at rest in the pose, shape (6,) [N, N m]
    pull_rate: Float,  # their rate of change as the intention moves on, shape (6,)
    q: Float,  # the pose, shape (n,) [rad]
    rotor: Float,  # mass matrix of the motors, shape (n, n) [kg m^2]
    support: Float,  # gravity compensation, shape (n,) [N m]
) -> None:
    """Set the impedance of the hand in joint coordinates, linearised about the pose q."""
    n = len(q)
    set_masses(body, mass, rotor)
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


@compiled(inline=True)
def hand_ends_cycle(body: Record, loop: Record, jacobian: Float, cycle: Float, k: int, dt: float) -> int:
    """Return 1 if the hand rests and every joint has moved, which ends a cycle (paper, section V.B), else 0."""
    square = 0.0
    for a in range(3):
        along = 0.0
        for j in range(body.joints):
            velocity = quantised(loop.velocity_step[j], body.v[j] + loop.velocity_noise[k, j])
            along += jacobian[a, j] * velocity
        square += along * along
    moved = True
    for j in range(body.joints):
        moved = moved and loop.memory[j].path_rad >= loop.settings[j].minimum_path_rad
    return 1 if controller.hand_cycle_ends(cycle, math.sqrt(square), dt, controller.HAND_THRESHOLDS_M_S, moved) else 0


@compiled(inline=True)
def set_bench_drive(mechanism: Record, push: Float, gravity: Float, k: int) -> None:
    """Set the drive torque of the joint of a bench at tick k, and the gravity torque of its load."""
    body, dt, driven = mechanism.body, mechanism.dt, mechanism.states[0].driven
    link = body.inner[0] if driven else 0
    position = body.y[link] + (0.5 * dt * body.v[link] if k > 0 else 0.0)
    weight = gravity[0] * np.sin(position + gravity[1])
    body.support[0] = -weight if driven else weight
    body.push[0] = push[k] - body.support[0]
    before, after = push[k] - push[max(k - 1, 0)], push[min(k + 1, len(push) - 1)] - push[k]
    body.push_rate[0] = 0.5 * (before + after) / dt
    body.push_bend[0] = (after - before) / dt**2


@compiled()
def run(mechanism: Record, push: Float, gravity: Float, jacobian: Float, cycle: Float, first: int, last: int) -> None:
    """Simulate from tick ``first`` to before ``last``; one function for bench and arm, because it compiles slowly.

    Each tick integrates from half a tick before it to half a tick after it, within the recording.
    ``push`` is the drive torque of a bench with the joint at zero, ``gravity`` amplitude and phase of the gravity
    torque of its load; if ``push`` is empty, the drive is in the body. ``cycle`` is the state that ends the cycles of
    all joints by the speed of the hand, empty without it, and ``jacobian`` that of the hand.
    """
    joints, states, events, body, loop, dt, substeps, out, traced = mechanism
    for k in range(first, last):
        t = k * dt
        if len(push) > 0:
            set_bench_drive(mechanism, push, gravity, k)
        if k > 0:
            integrate(joints, states, events, body, dt, substeps, t - 0.5 * dt, -0.5 * dt)
        evaluate(joints, states, events, body, t)
        write_truth(states, body, out[k])
        ends = hand_ends_cycle(body, loop, jacobian, cycle, k, dt) if len(cycle) > 0 else controller.DETECT
        run_controllers(joints, states, body, loop, dt, k, ends)
        for j in range(len(joints)):
            for field in range(traced.shape[2]):
                traced[k, j, field] = loop.memory_fields[j, field]
        if k + 1 < len(out):
            integrate(joints, states, events, body, dt, substeps, t, 0.0)
