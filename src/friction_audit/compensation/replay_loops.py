"""Loops of a replay, sample by sample: along the recorded motion, and in closed loop with a simulated plant."""

import math
from typing import NamedTuple

import numpy as np

from friction_audit.compensation.competitors import Feedforward, update_feedforward
from friction_audit.compensation.controller import HOLE_S, step
from friction_audit.compensation.law import JOINT_MODEL
from friction_audit.compiled import Record, compiled
from friction_audit.dynamics.bristles import bristle_damping, bristle_nm
from friction_audit.dynamics.stick_slip import Step, advance
from friction_audit.dynamics.torque_tables import Tables, lookup_nm
from friction_audit.joint_log import Bool, Float, Int

# A cycle of the compensator.
CYCLE = np.dtype(
    [
        ("stop", "i8"),  # sample at which it ended
        ("status", "i8"),  # its result, as in ``records``
        ("acted", "?"),  # whether the passivity controller acted in it
        *((name, "f8") for name in ("start_s", "stop_s")),
        ("friction_j", "f8"),  # energy that friction dissipated, which the operator gives without compensation
        ("net_energy_j", "f8"),  # that less the work of compensator and passivity controller: the operator's part
        *((name, "f8") for name in ("path_rad", "square_speed_rad2_s")),  # path, and integral of dq^2 dt
        *((name, "f8") for name in ("coulomb_applied_nm", "viscous_applied_nms_per_rad")),  # during the cycle
        # after its end, NaN before the first estimate
        *((name, "f8") for name in ("coulomb_estimated_nm", "viscous_estimated_nms_per_rad")),
    ]
)

# Statistics of a run, some by the names of ``Numbers`` and ``Passivity``.
STATISTICS = np.dtype(
    [
        ("cycles", "i8"),  # cycles that ended in this part of the recording
        # of the present cycle, as in CYCLE
        *((name, "f8") for name in ("friction_j", "net_j", "path_rad", "square_rad2_s")),
        ("tolerance_j", "f8"),  # largest energy exchanged while a deficit is measured and dissipated
        *((name, "f8") for name in ("lowest_j", "lowest_since_activation_j", "reserve_j", "injected_j")),
        *((name, "f8") for name in ("activation_s", "diverged_s")),  # NaN before
        *((name, "i8") for name in ("violations", "violations_since_activation")),
        ("active_friction_j", "f8"),  # energy that friction dissipated since the activation
        ("acting_s", "f8"),  # time for which the passivity controller acted
        *((name, "f8") for name in ("peak_compensation_nm", "peak_rate_nm_s")),
        ("limited", "i8"),  # samples at a limit of torque or rate
        ("t_s", "f8"),  # time of the latest tick
        ("total_nm", "f8"),  # torque S at the latest sample of a recorded motion
        ("hidden", "?"),
    ]
)

GENERATED = 0.05  # share of the dissipation that a joint may generate before it counts as over-compensated
BEYOND_NOISE = 0.01  # share of the reserve that it must have generated as well: just after activation all is noise
# Samples with a deficit, added to the payback, that are no violation: one until the deficit is measured, and one until
# the damping has an effect.
TOLERATED_SAMPLES = 2.0
NEARLY = 1.0 - 1e-9


@compiled(inline=True)
def add_energy(statistics: Record, settings: Record, friction_j: float, net_j: float, moved: float, dt: float) -> None:
    """Add an interval between two ticks; below the speed of rest, noise would add up to a path."""
    statistics.friction_j += friction_j
    statistics.net_j += net_j
    if abs(moved) > settings.rest_rad_s * dt:
        statistics.path_rad += abs(moved)
        statistics.square_rad2_s += moved * moved / dt
    if not math.isnan(statistics.activation_s):
        statistics.active_friction_j += friction_j


@compiled(inline=True)
def add_tick(statistics: Record, settings: Record, state: Record, u_before: float) -> None:
    """Add what passivity observer, passivity controller and limits did at a tick of the compensator."""
    observed = state.observed_energy_j
    statistics.lowest_j = min(statistics.lowest_j, observed)
    if observed < -statistics.tolerance_j:
        statistics.violations += 1
    if state.active == 1:
        if math.isnan(statistics.activation_s):
            statistics.activation_s, statistics.reserve_j = statistics.t_s, observed
        statistics.lowest_since_activation_j = min(statistics.lowest_since_activation_j, state.active_energy_j)
        if state.active_energy_j < -statistics.tolerance_j:
            statistics.violations_since_activation += 1
        bound = max(GENERATED * statistics.active_friction_j, BEYOND_NOISE * statistics.reserve_j)
        if observed >= 0.0 and bound > 0.0 and state.active_energy_j < -bound:
            statistics.hidden = True
    if state.damping_nms_per_rad > 0.0:
        statistics.acting_s += settings.period_s
    statistics.injected_j = state.dissipated_j
    statistics.peak_compensation_nm = max(statistics.peak_compensation_nm, abs(u_before))
    change = abs(state.u_nm - u_before)
    statistics.peak_rate_nm_s = max(statistics.peak_rate_nm_s, change / settings.period_s)
    at_rate = change >= settings.max_torque_rate_nm_s * settings.period_s * NEARLY
    if at_rate or abs(state.u_nm) >= settings.max_torque_nm * NEARLY:
        statistics.limited += 1


TORQUE_SUMS = np.dtype(
    [
        *((name, "f8") for name in ("samples", "t_s", "dq_rad_s", "torque_nm")),  # count, and the latest sample
        ("work_j", "f8"),
        ("square_nm2s", "f8"),  # integral of the squared torque over time
        ("peak_nm", "f8"),
    ]
)


@compiled(any_order=True)
def add_torque(sums: Record, t: Float, dq: Float, torque: Float) -> None:
    """Add the samples that follow, shape (n,), to a record of TORQUE_SUMS."""
    for i in range(len(t)):
        dt = t[i] - sums.t_s if sums.samples > 0.0 and t[i] - sums.t_s <= HOLE_S else 0.0
        sums.work_j += 0.25 * (sums.torque_nm + torque[i]) * (sums.dq_rad_s + dq[i]) * dt
        sums.square_nm2s += 0.5 * (sums.torque_nm * sums.torque_nm + torque[i] * torque[i]) * dt
        sums.peak_nm = max(sums.peak_nm, abs(torque[i]))
        sums.samples += 1.0
        sums.t_s, sums.dq_rad_s, sums.torque_nm = t[i], dq[i], torque[i]


class RecordedJoint(NamedTuple):
    """One joint's recording, n samples."""

    t: Float  # time [s]
    q: Float  # position [rad]
    dq: Float  # velocity [rad/s]
    torque: Float  # interaction torque F_m [N m]
    total: Float  # torque S = F_m + u that drove the motor side; ``torque`` itself if no u was logged [N m]


class Controller(NamedTuple):
    """The compensator of a joint, and the arrays that receive its results."""

    settings: Record  # record of SETTINGS
    state: Record  # record of STATE; updated
    statistics: Record  # record of STATISTICS; updated
    feedforward: Feedforward  # of a compensator with a joint's model
    # per sample DETECT, or 1 where a cycle ends and 0 elsewhere, shape (n,); or one entry for all samples
    cycle_ends: Int
    torques: Float  # zeros; receives torques in force: operator, law, passivity controller, limits, shape (4, n) [N m]
    cycles: Record  # receives a record of CYCLE for every cycle that ends in this part, shape (m,)


class Plant(NamedTuple):
    """A simulated joint with its operator's impedance, and the torque that drives both; n samples."""

    tables: Tables  # torque and inertia of joint and operator, without the operator's spring
    joint_inertia_kg_m2: float  # inertia of the joint alone [kg m^2]
    inertia_kg_m2: float  # inertia of the operator [kg m^2]
    damping_nms_per_rad: float  # damping of the operator, which is in the tables too [N m s/rad]
    stiffness_nm_per_rad: float  # stiffness of the operator, about position zero [N m/rad]
    longest_step_s: float  # of the integration [s]
    drive: Float  # torque on the joint with the operator at position zero and at rest, linear between samples [N m]
    unmodelled: Float  # torque that the joint's model lacks: F_m contains it, ``drive`` does not [N m]
    restart: Bool  # True where the joint starts again from the recorded state, shape (n,)
    deflections: Float  # state of the bristles at the first sample and at every restart, shape (r, 1 + m)


@compiled(inline=True)
def record_torques(torques: Float, state: Record, i: int, interaction: float) -> None:
    """Record the torques in force at sample i. Zeros are not written: memory for them is allocated at a first write."""
    torques[0, i], torques[1, i] = interaction, state.compensation_nm
    if state.passivity_nm != 0.0:
        torques[2, i] = state.passivity_nm
    if state.limited_nm != 0.0:
        torques[3, i] = state.limited_nm


@compiled()
def run_tick(
    settings: Record, state: Record, statistics: Record, cycles: Record, t: float, v: float, torque: float, end: int
) -> bool:
    """Run the compensator on a sample and record its statistics; return False once the loop has diverged."""
    u, cycle, acted = state.u_nm, state.cycle, state.acted
    coulomb, viscous = state.coulomb_nm, state.viscous_nms_per_rad
    step(settings, state, v, torque, t - statistics.t_s if state.ticks > 0 else 0.0, end)
    if state.unstable == 1:
        return False
    statistics.t_s = t
    add_tick(statistics, settings, state, u)
    if state.cycle > cycle:  # a cycle ended; the coefficients from before this tick were applied in it
        row = cycles[statistics.cycles]
        row.stop, row.stop_s, row.acted, row.status = state.ticks - 1, t, acted == 1, state.status
        row.friction_j, row.net_energy_j = statistics.friction_j, statistics.net_j
        row.path_rad, row.square_speed_rad2_s = statistics.path_rad, statistics.square_rad2_s
        row.coulomb_applied_nm, row.viscous_applied_nms_per_rad = coulomb, viscous
        row.coulomb_estimated_nm = state.estimated_coulomb_nm
        row.viscous_estimated_nms_per_rad = state.estimated_viscous_nms_per_rad
        statistics.friction_j = statistics.net_j = statistics.path_rad = statistics.square_rad2_s = 0.0
        statistics.cycles += 1
    return True


@compiled()
def run_same_motion(controller: Controller, recorded: RecordedJoint) -> int:
    """Run a compensator along a part of a recording; return the number of samples, fewer than n if it diverges.

    The total torque S = F_m + u that drives the motor side stays as recorded. A compensator that gives u' leaves
    F' = S - u' to the operator, and measures F'.
    """
    settings, state, statistics, feedforward, cycle_ends, torques, cycles = controller
    t, q, dq, _, total = recorded
    for i in range(len(t)):
        interaction = total[i] - state.u_nm
        record_torques(torques, state, i, interaction)
        dt = t[i] - statistics.t_s
        if state.ticks > 0 and dt <= HOLE_S:
            moved = 0.5 * (state.dq + dq[i]) * dt
            friction = 0.5 * (statistics.total_nm + total[i]) * moved
            net = 0.5 * (state.interaction_nm + interaction) * moved
            add_energy(statistics, settings, friction, net, moved, dt)
        if settings.kind == JOINT_MODEL:
            update_feedforward(state, feedforward, q[i], dq[i], i)
        end = cycle_ends[i] if len(cycle_ends) > 1 else cycle_ends[0]
        if not run_tick(settings, state, statistics, cycles, t[i], dq[i], interaction, end):
            return i
        statistics.total_nm = total[i]
    return len(t)


@compiled()
def run_closed_loop(controller: Controller, recorded: RecordedJoint, plant: Plant, velocity: Float) -> int:
    """Simulate the plant with its compensator at the stamps of a log; return the samples, fewer than n if it diverges.

    Where the joint restarts, its kinetic energy becomes that of the recording; compensator and passivity observer must
    not take the difference for friction. ``velocity`` receives the velocity, shape (n,).
    """
    settings, state, statistics, feedforward, cycle_ends, torques, cycles = controller
    t, dq, drive = recorded.t, recorded.dq, plant.drive
    q, v, restarts, deflections = recorded.q[0], dq[0], 0, plant.deflections[0].copy()
    sign = np.sign(v)
    for i in range(len(t)):
        interaction = sensor_torque(q, v, sign, i, drive[i], state.u_nm, deflections, plant) + plant.unmodelled[i]
        record_torques(torques, state, i, interaction)
        velocity[i] = v
        restart = plant.restart[i] and i > 0
        if restart:  # the kinetic energy that is left was not dissipated
            surplus = 0.5 * plant.joint_inertia_kg_m2 * (v * v - dq[i] * dq[i])
            state.net_j -= surplus
            state.energy_j -= surplus
            state.active_energy_j -= surplus * state.active
        if settings.kind == JOINT_MODEL:
            update_feedforward(state, feedforward, q, v, i)
        end = cycle_ends[i] if len(cycle_ends) > 1 else cycle_ends[0]
        if not run_tick(settings, state, statistics, cycles, t[i], v, interaction, end):
            return i
        if restart:
            q, v, restarts = recorded.q[i], dq[i], restarts + 1
            sign = np.sign(v)
            for k in range(len(deflections)):  # for a slice, numba compiles a message for seconds
                deflections[k] = plant.deflections[restarts, k]
            state.q_rad, state.dq = q, v
        if i + 1 < len(t) and t[i + 1] - t[i] <= HOLE_S:
            before, u = q, state.u_nm
            span = Step(t[i + 1] - t[i], drive[i], drive[i + 1], float(i), i + 1.0)
            steps = max(1, int(np.ceil(span.h / plant.longest_step_s - 1e-6)))
            q, v, sign, friction = integrate(q, v, sign, span, u, steps, deflections, plant)
            add_energy(statistics, settings, friction, friction - u * (q - before), q - before, span.h)
    return len(t)


@compiled(inline=True)
def sensor_torque(
    q: float, v: float, sign: float, i: int, drive: float, u: float, deflections: Float, plant: Plant
) -> float:
    """Return the torque that the sensor measures: the drive less inertia, damper and spring of the operator. [N m]"""
    spring, acceleration, bristles = plant.stiffness_nm_per_rad * q, 0.0, plant.tables.bristles
    if sign != 0.0:
        torque = lookup_nm(sign, q, abs(v), float(i), plant.tables)
        torque += bristle_nm(deflections, 0.0, bristles) + bristle_damping(deflections, sign, bristles) * v
        acceleration = (drive + u - spring - torque) / plant.tables.inertia_kg_m2
    return float(drive - plant.inertia_kg_m2 * acceleration - plant.damping_nms_per_rad * v - spring)


@compiled(inline=True)
def integrate(
    q: float, v: float, sign: float, span: Step, u: float, steps: int, deflections: Float, plant: Plant
) -> tuple[float, float, float, float]:
    """Integrate the plant to the next sample; return position, velocity, direction and the dissipated energy [J]."""
    h, dissipated, tables = span.h / steps, 0.0, plant.tables
    rise = ((span.drive1 + u) - (span.drive0 + u)) / steps
    for k in range(steps):
        before, held, drive = q, deflections.copy(), span.drive0 + u + k * rise
        begin, end = span.begin + k / steps, span.begin + (k + 1.0) / steps
        # The operator's spring is evaluated at the position after a step with constant velocity.
        near, far = plant.stiffness_nm_per_rad * q, plant.stiffness_nm_per_rad * (q + h * v)
        q, v, sign = advance(q, v, sign, Step(h, drive - near, drive + rise - far, begin, end), deflections, tables)
        moved = q - before
        if moved != 0.0:
            position, speed, sample = 0.5 * (before + q), abs(moved) / h, 0.5 * (begin + end)
            mean = 0.5 * (held + deflections)
            # Half the difference of both directions is friction; the common part, as gravity, does no net work.
            both = lookup_nm(1.0, position, speed, sample, tables) - lookup_nm(-1.0, position, speed, sample, tables)
            friction = 0.5 * both - plant.damping_nms_per_rad * speed
            damping = bristle_damping(mean, math.copysign(1.0, moved), tables.bristles)
            bristles = bristle_nm(mean, 0.0, tables.bristles) + damping * moved / h
            dissipated += friction * abs(moved) + bristles * moved
    return q, v, sign, dissipated
