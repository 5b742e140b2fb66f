"""A compensator tick by tick: along the recorded motion, or in closed loop with a joint that ``stick_slip`` moves."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.competitors import Feed, feed_friction
from friction_audit.compensation.controller import HOLE_S, step
from friction_audit.compensation.law import JOINT_MODEL
from friction_audit.compiled import Record, compiled
from friction_audit.dynamics.bristles import bristle_damping, bristle_nm
from friction_audit.dynamics.stick_slip import Step, advance
from friction_audit.dynamics.torque_tables import Tables, taken
from friction_audit.joint_log import Float, read_only

# A cycle of the compensator.
CYCLE = np.dtype(
    [
        ("stop", "i8"),  # sample at which it ended
        ("status", "i8"),  # what came of it, as in ``records``
        ("acted", "?"),  # whether the passivity controller acted in it
        *((name, "f8") for name in ("start_s", "stop_s")),
        ("friction_j", "f8"),  # what friction took, which the person would have had to give without compensation
        ("net_energy_j", "f8"),  # that less what compensator and passivity controller gave: what was left to the person
        *((name, "f8") for name in ("path_rad", "square_speed_rad2_s")),  # path, and integral of dq^2 dt
        *((name, "f8") for name in ("coulomb_applied_nm", "viscous_applied_nms_per_rad")),  # compensated during it
        # in force after its end, NaN before there is an estimate
        *((name, "f8") for name in ("coulomb_estimated_nm", "viscous_estimated_nms_per_rad")),
    ]
)

# Sums over the recording, some by the names of ``Numbers`` and ``Passivity``.
TALLY = np.dtype(
    [
        ("cycles", "i8"),  # that ended in this part of the recording
        ("friction_j", "f8"),  # what friction took in the present cycle
        ("net_j", "f8"),  # that less what the compensator gave, the rest being the person's
        *((name, "f8") for name in ("path_rad", "square_rad2_s")),
        ("tolerance_j", "f8"),  # largest energy exchanged while a deficit is measured and paid
        *((name, "f8") for name in ("lowest_j", "lowest_since_activation_j", "reserve_j", "injected_j")),
        *((name, "f8") for name in ("activation_s", "diverged_s")),  # NaN before
        *((name, "i8") for name in ("violations", "violations_since_activation")),
        ("active_friction_j", "f8"),  # what friction took since the activation
        ("acting_s", "f8"),
        *((name, "f8") for name in ("peak_compensation_nm", "peak_rate_nm_s")),
        ("limited", "i8"),  # samples at a limit of torque or rate
        ("t_s", "f8"),  # time of the last tick
        ("total_nm", "f8"),  # torque S at the last sample along a recording
        ("hidden", "?"),
    ]
)

GIVEN_OUT = 0.05  # share of the dissipation that a joint gives out before it counts as over-compensated
# Samples, besides the time in which a deficit is paid, whose energy the ledger may be below zero: one goes by until the
# deficit is measured, and one until the damping is felt.
SAMPLES = 2.0
BEYOND_NOISE = 0.01  # share of the reserve that it must have given out as well: just after activation all is noise
NEARLY = 1.0 - 1e-9


@compiled(inline=True)
def count_energy(tally: Record, settings: Record, friction_j: float, net_j: float, moved: float, dt: float) -> None:
    """Add an interval between two ticks; below the speed of rest of the settings, noise would add up to a path."""
    tally.friction_j += friction_j
    tally.net_j += net_j
    if abs(moved) > settings.rest_rad_s * dt:
        tally.path_rad += abs(moved)
        tally.square_rad2_s += moved * moved / dt
    if not math.isnan(tally.activation_s):
        tally.active_friction_j += friction_j


@compiled(inline=True)
def count_tick(tally: Record, settings: Record, memory: Record, u_before: float) -> None:
    """Look at ledger, controller and limits after a tick of the compensator."""
    ledger = memory.observed_energy_j
    tally.lowest_j = min(tally.lowest_j, ledger)
    if ledger < -tally.tolerance_j:
        tally.violations += 1
    if memory.active == 1:
        if math.isnan(tally.activation_s):
            tally.activation_s, tally.reserve_j = tally.t_s, ledger
        tally.lowest_since_activation_j = min(tally.lowest_since_activation_j, memory.active_energy_j)
        if memory.active_energy_j < -tally.tolerance_j:
            tally.violations_since_activation += 1
        out = max(GIVEN_OUT * tally.active_friction_j, BEYOND_NOISE * tally.reserve_j)
        if ledger >= 0.0 and out > 0.0 and memory.active_energy_j < -out:
            tally.hidden = True
    if memory.damping_nms_per_rad > 0.0:
        tally.acting_s += settings.period_s
    tally.injected_j = memory.dissipated_j
    tally.peak_compensation_nm = max(tally.peak_compensation_nm, abs(u_before))
    change = abs(memory.u_nm - u_before)
    tally.peak_rate_nm_s = max(tally.peak_rate_nm_s, change / settings.period_s)
    at_rate = change >= settings.max_torque_rate_nm_s * settings.period_s * NEARLY
    if at_rate or abs(memory.u_nm) >= settings.max_torque_nm * NEARLY:
        tally.limited += 1


SUMS = np.dtype(
    [
        *((name, "f8") for name in ("samples", "t_s", "dq_rad_s", "torque_nm")),  # so far, and the last of them
        ("work_j", "f8"),
        ("square_nm2s", "f8"),  # integral of the squared torque over the time
        ("largest_nm", "f8"),
    ]
)


@compiled(any_order=True)
def add_torque(sums: Record, t: Float, dq: Float, torque: Float) -> None:
    """Add the samples that follow, shape (n,), to a record of SUMS."""
    for i in range(len(t)):
        dt = t[i] - sums.t_s if sums.samples > 0.0 and t[i] - sums.t_s <= HOLE_S else 0.0
        sums.work_j += 0.25 * (sums.torque_nm + torque[i]) * (sums.dq_rad_s + dq[i]) * dt
        sums.square_nm2s += 0.5 * (sums.torque_nm * sums.torque_nm + torque[i] * torque[i]) * dt
        sums.largest_nm = max(sums.largest_nm, abs(torque[i]))
        sums.samples += 1.0
        sums.t_s, sums.dq_rad_s, sums.torque_nm = t[i], dq[i], torque[i]


class Recorded(NamedTuple):
    """One joint's recording, n samples."""

    t: Float  # time [s]
    dq: Float  # velocity [rad/s]
    torque: Float  # interaction torque F_m [N m]
    logged: Float  # torque of a compensator that was active, shape (n,), or empty [N m]

    @property
    def total(self) -> Float:
        """Torque S = F_m + u that drove the inner side, shape (n,). [N m]"""
        return read_only(self.torque + self.logged) if len(self.logged) else self.torque


class Control(NamedTuple):
    """The compensator of a joint, and where its run is written."""

    settings: Record  # record of the compensator
    memory: Record  # its memory; changed
    tally: Record  # record of TALLY; changed
    feed: Feed  # friction that a compensator with a joint's model feeds forward
    # per sample FIND, or 1 where a cycle ends and 0 elsewhere, shape (n,); one entry stands for all
    cuts: NDArray[np.int64]
    torques: Float  # zeros that receive torques in force: person, law, passivity controller, limits, shape (4, n) [N m]
    rows: Record  # receives a record of CYCLE for every cycle that ends in this part, shape (most,)


class Loop(NamedTuple):
    """A joint in the hand of its operator, and what drives it; n samples."""

    tables: Tables  # what both take but for the operator's spring, and the inertia of both
    own_kg_m2: float  # inertia of the joint alone [kg m^2]
    inertia_kg_m2: float  # inertia of the operator [kg m^2]
    damping_nms_per_rad: float  # damping of the operator, in the tables too [N m s/rad]
    stiffness_nm_per_rad: float  # stiffness of the operator, against position zero [N m/rad]
    longest_s: float  # longest step [s]
    push: Float  # torque on the joint, linear between the samples; of an operator at position zero and at rest [N m]
    lacking: Float  # torque that the joint's model lacks: the sensor feels it, ``push`` is without it [N m]
    q: Float  # position as recorded [rad]
    restart: NDArray[np.bool_]  # True where the joint starts again from the recording, shape (n,)
    bent: Float  # state of the bristles at the first sample and at every new start, shape (r, 1 + m)


@compiled()
def tick(
    settings: Record, memory: Record, tally: Record, rows: Record, t: float, v: float, interaction: float, cut: int
) -> bool:
    """Run the compensator on a sample and count what it does; return False once the loop has diverged."""
    u, cycle, acted = memory.u_nm, memory.cycle, memory.acted
    coulomb, viscous = memory.coulomb_nm, memory.viscous_nms_per_rad
    step(settings, memory, v, interaction, t - tally.t_s if memory.ticks > 0 else 0.0, cut)
    if memory.unstable == 1:
        return False
    tally.t_s = t
    count_tick(tally, settings, memory, u)
    if memory.cycle > cycle:  # a cycle ended, during which the coefficients from before the tick were applied
        row = rows[tally.cycles]
        row.stop, row.stop_s, row.acted, row.status = memory.ticks - 1, t, acted == 1, memory.status
        row.friction_j, row.net_energy_j = tally.friction_j, tally.net_j
        row.path_rad, row.square_speed_rad2_s = tally.path_rad, tally.square_rad2_s
        row.coulomb_applied_nm, row.viscous_applied_nms_per_rad = coulomb, viscous
        row.coulomb_estimated_nm = memory.estimated_coulomb_nm
        row.viscous_estimated_nms_per_rad = memory.estimated_viscous_nms_per_rad
        tally.friction_j = tally.net_j = tally.path_rad = tally.square_rad2_s = 0.0
        tally.cycles += 1
    return True


@compiled(inline=True)
def write_torques(torques: Float, memory: Record, i: int, interaction: float) -> None:
    """Write down the torques in force at sample i; memory for zeros that is never written to is never taken."""
    torques[0, i], torques[1, i] = interaction, memory.compensation_nm
    if memory.passivity_nm != 0.0:
        torques[2, i] = memory.passivity_nm
    if memory.limited_nm != 0.0:
        torques[3, i] = memory.limited_nm


@compiled()
def run_same_motion(control: Control, recorded: Recorded, q: Float) -> int:
    """Run a compensator along a part of a recording; return the number of samples, fewer than n if it diverges.

    The total torque S = F_m + u that drives the inner side in the recording stays. A compensator that gives u' instead
    leaves F' = S - u' to the person, which is what the compensator then measures. The position q, shape (n,), may be
    empty where the compensator has no use for it.
    """
    settings, memory, tally, feed, cuts, torques, rows = control
    t, dq, torque, logged = recorded
    for i in range(len(t)):
        total = torque[i] + logged[i] if len(logged) > 0 else torque[i]
        needed = total - memory.u_nm
        write_torques(torques, memory, i, needed)
        dt = t[i] - tally.t_s
        if memory.ticks > 0 and dt <= HOLE_S:
            moved = 0.5 * (memory.dq + dq[i]) * dt
            friction, exchange = 0.5 * (tally.total_nm + total) * moved, 0.5 * (memory.interaction_nm + needed) * moved
            count_energy(tally, settings, friction, exchange, moved, dt)
        if settings.kind == JOINT_MODEL:
            feed_friction(memory, feed, q[i], dq[i], i)
        if not tick(settings, memory, tally, rows, t[i], dq[i], needed, cuts[i] if len(cuts) > 1 else cuts[0]):
            return i
        tally.total_nm = total
    return len(t)


@compiled()
def run_closed_loop(control: Control, recorded: Recorded, loop: Loop, velocity: Float) -> int:
    """Move the joint and run its compensator at the stamps of a log; return the samples, fewer than n if it diverges.

    Where the joint starts again from the recording, its kinetic energy is put back to that of the recording: neither
    compensator nor ledger shall take the difference for friction. ``velocity`` receives the velocity, shape (n,).
    """
    settings, memory, tally, feed, cuts, torques, rows = control
    t, dq, push = recorded.t, recorded.dq, loop.push
    q, v, starts, bent = loop.q[0], dq[0], 0, loop.bent[0].copy()
    sign = np.sign(v)
    for i in range(len(t)):
        interaction = feel(q, v, sign, i, push[i], memory.u_nm, bent, loop) + loop.lacking[i]
        write_torques(torques, memory, i, interaction)
        velocity[i] = v
        again = loop.restart[i] and i > 0
        if again:  # what is still in the joint, friction has not taken
            surplus = 0.5 * loop.own_kg_m2 * (v * v - dq[i] * dq[i])
            memory.net_j -= surplus
            memory.energy_j -= surplus
            memory.active_energy_j -= surplus * memory.active
        if settings.kind == JOINT_MODEL:
            feed_friction(memory, feed, q, v, i)
        if not tick(settings, memory, tally, rows, t[i], v, interaction, cuts[i] if len(cuts) > 1 else cuts[0]):
            return i
        if again:
            q, v, starts = loop.q[i], dq[i], starts + 1
            sign = np.sign(v)
            for k in range(len(bent)):  # for a slice, numba compiles a message for seconds
                bent[k] = loop.bent[starts, k]
            memory.q_rad, memory.dq = q, v
        if i + 1 < len(t) and t[i + 1] - t[i] <= HOLE_S:
            before, u = q, memory.u_nm
            span = Step(t[i + 1] - t[i], push[i], push[i + 1], float(i), i + 1.0)
            pieces = max(1, int(np.ceil(span.h / loop.longest_s - 1e-6)))
            q, v, sign, lost = move(q, v, sign, span, u, pieces, bent, loop)
            count_energy(tally, settings, lost, lost - u * (q - before), q - before, span.h)
    return len(t)


@compiled(inline=True)
def feel(q: float, v: float, sign: float, i: int, push: float, u: float, bent: Float, loop: Loop) -> float:
    """Return what the sensor of a joint with tables feels of the push: that, less what the operator takes. [N m]"""
    spring, acceleration = loop.stiffness_nm_per_rad * q, 0.0
    if sign != 0.0:
        torque = taken(sign, q, abs(v), float(i), loop.tables)
        torque += bristle_nm(bent, 0.0, loop.tables.bristles) + bristle_damping(bent, sign, loop.tables.bristles) * v
        acceleration = (push + u - spring - torque) / loop.tables.inertia_kg_m2
    return float(push - loop.inertia_kg_m2 * acceleration - loop.damping_nms_per_rad * v - spring)


@compiled(inline=True)
def move(
    q: float, v: float, sign: float, span: Step, u: float, pieces: int, bent: Float, loop: Loop
) -> tuple[float, float, float, float]:
    """Move on to the next sample; return position, velocity, direction, and what friction, not gravity, took [J]."""
    h, lost, tables = span.h / pieces, 0.0, loop.tables
    rise = ((span.drive1 + u) - (span.drive0 + u)) / pieces
    for k in range(pieces):
        before, held, push = q, bent.copy(), span.drive0 + u + k * rise
        begin, end = span.begin + k / pieces, span.begin + (k + 1.0) / pieces
        # The operator's spring is read where the joint will be if it goes on: right to the order of the step.
        near, far = loop.stiffness_nm_per_rad * q, loop.stiffness_nm_per_rad * (q + h * v)
        q, v, sign = advance(q, v, sign, Step(h, push - near, push + rise - far, begin, end), bent, loop.tables)
        moved = q - before
        if moved != 0.0:
            position, speed, sample, mean = 0.5 * (before + q), abs(moved) / h, 0.5 * (begin + end), 0.5 * (held + bent)
            both = taken(1.0, position, speed, sample, tables) - taken(-1.0, position, speed, sample, tables)
            level = 0.5 * both - loop.damping_nms_per_rad * speed
            damping = bristle_damping(mean, math.copysign(1.0, moved), tables.bristles)
            lost += level * abs(moved) + (bristle_nm(mean, 0.0, tables.bristles) + damping * moved / h) * moved
    return q, v, sign, lost
