"""A fitted joint and a compensator in closed loop, driven by what was recorded."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.model.forward import LONGEST_STEP_S, advance, forces
from friction_audit.replay.divergence import SPEED_BOUND_RAD_S, beyond
from friction_audit.replay.kernels import step
from friction_audit.replay.port import Course
from friction_audit.replay.records import Record
from friction_audit.replay.tally import close_row, count_energy, count_tick


class Drive(NamedTuple):
    """What drives the joint, n samples.

    Attributes:
        t: Time. [s]
        push: Torque on the joint, linear between the samples; of an operator at position zero and at rest. [N m]
        lacking: Torque that the fitted joint lacks: the sensor feels it, ``push`` is without it. [N m]
        q: Position as recorded. [rad]
        dq: Velocity as recorded. [rad/s]
        restart: True where the joint starts again from the recording, shape (n,).
    """

    t: Float
    push: Float
    lacking: Float
    q: Float
    dq: Float
    restart: NDArray[np.bool_]


@compiled()
def run_closed_loop(  # noqa: PLR0913
    settings: Record,
    memory: Record,
    tally: Record,
    body: Record,
    inertia_kg_m2: float,
    drive: Drive,
    cuts: NDArray[np.int64],
    course: Course,
    motion: Float,
    rows: Float,
) -> int:
    """Move the joint and run its compensator at the stamps of a log; return the samples, fewer than n if it diverges.

    Where the joint starts again from the recording, its kinetic energy is put back to that of the recording: neither
    compensator nor ledger shall take the difference for friction.

    Args:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        body: Joint and operator, one element of ``model.body.BODY``.
        inertia_kg_m2: Of the joint alone, behind the sensor. [kg m^2]
        drive: What drives it.
        cuts: Per sample FIND, or 1 where a cycle ends and 0 elsewhere, shape (n,); one entry stands for all.
        course: Receives the torques.
        motion: Receives the velocity, shape (n,). [rad/s]
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """
    t = drive.t
    q, v = drive.q[0], drive.dq[0]
    sign = direction(v)
    for i in range(len(t)):
        dt = t[i] - t[i - 1] if i > 0 else 0.0
        u = memory.u_nm
        acceleration, friction = forces(q, v, sign, drive.push[i], u, body)
        interaction = inertia_kg_m2 * acceleration + friction - u + drive.lacking[i]
        course.interaction[i], motion[i] = interaction, v
        course.compensation[i], course.passivity[i] = memory.compensation_nm, memory.passivity_nm
        again = drive.restart[i] and i > 0
        if again:
            put_back(memory, 0.5 * inertia_kg_m2 * (v * v - drive.dq[i] * drive.dq[i]))
        coulomb, viscous, cycle = memory.coulomb_nm, memory.viscous_nms_per_rad, memory.cycle
        acted = memory.acted
        step(settings, memory, v, interaction, dt, cuts[i] if len(cuts) > 1 else cuts[0])
        if memory.unstable == 1 or beyond(v, SPEED_BOUND_RAD_S):
            return i
        count_tick(tally, settings, memory, u, dt, i)
        if memory.cycle > cycle:
            close_row(tally, memory, coulomb, viscous, acted, i, rows)
        if again:
            q, v = drive.q[i], drive.dq[i]
            sign = direction(v)
            memory.dq = v
        if i + 1 == len(t):
            break
        before, span = q, t[i + 1] - t[i]
        q, v, sign, taken = move(q, v, sign, span, drive.push[i], drive.push[i + 1], memory.u_nm, body)
        count_energy(tally, settings, taken, taken - memory.u_nm * (q - before), q - before, span)
    return len(t)


@compiled()
def move(
    q: float, v: float, sign: float, span: float, push0: float, push1: float, u: float, body: Record
) -> tuple[float, float, float, float]:
    """Move the joint on from one stamp to the next, in pieces; arguments and result as in ``model.forward.advance``."""
    pieces = max(1, int(np.ceil(span / LONGEST_STEP_S - 1e-6)))
    h, rise, taken = span / pieces, (push1 - push0) / pieces, 0.0
    for k in range(pieces):
        start = push0 + k * rise
        q, v, sign, lost = advance(q, v, sign, h, start, start + rise, u, body)
        taken += lost
    return q, v, sign, taken


@compiled()
def direction(v: float) -> float:
    """Return in which direction a joint slides; 0 at rest."""
    return 0.0 if v == 0.0 else math.copysign(1.0, v)


@compiled()
def put_back(memory: Record, surplus_j: float) -> None:
    """Take kinetic energy out of the compensator's sums: what is still in the joint, friction has not taken."""
    memory.net_j -= surplus_j
    memory.energy_j -= surplus_j
    if memory.active == 1:
        memory.active_energy_j -= surplus_j
