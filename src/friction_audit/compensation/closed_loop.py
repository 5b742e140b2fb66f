"""A tick of the controller within a replay, whatever moves the joint; compiled."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.compensators.law import JOINT_MODEL
from friction_audit.compensation.feed_forward import Feed, tell_friction
from friction_audit.compensation.kernels import step
from friction_audit.compensation.port import Course
from friction_audit.compensation.records import Record
from friction_audit.compensation.tally import close_row, count_energy, count_tick
from friction_audit.compiled import compiled
from friction_audit.dynamics.stick_slip import LONGEST_STEP_S, advance, forces
from friction_audit.joint_log import Float


class Control(NamedTuple):
    """What runs beside a joint, and where it is written down.

    Attributes:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        feed: What a compensator with a joint's model is told.
        cuts: Per sample FIND, or 1 where a cycle ends and 0 elsewhere, shape (n,); one entry stands for all.
        course: Receives the torques.
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """

    settings: Record
    memory: Record
    tally: Record
    feed: Feed
    cuts: NDArray[np.int64]
    course: Course
    rows: Float


@compiled()
def tick(  # noqa: PLR0913
    settings: Record,
    memory: Record,
    tally: Record,
    i: int,
    dt: float,
    v: float,
    interaction: float,
    cut: int,
    rows: Float,
) -> bool:
    """Run the compensator on sample i and count what it does; return False once the loop has diverged.

    Args:
        settings: Record of the compensator.
        memory: Its memory; changed.
        tally: Record of TALLY; changed.
        i: Sample.
        dt: Time since the sample before. [s]
        v: Velocity. [rad/s]
        interaction: Torque at the sensor. [N m]
        cut: FIND, or 1 where a cycle ends and 0 elsewhere.
        rows: Receives a row per cycle, shape (most, COLUMNS).
    """
    u, cycle, acted = memory.u_nm, memory.cycle, memory.acted
    coulomb, viscous = memory.coulomb_nm, memory.viscous_nms_per_rad
    step(settings, memory, v, interaction, dt, cut)
    if memory.unstable == 1:
        return False
    count_tick(tally, settings, memory, u, dt, i)
    if memory.cycle > cycle:
        close_row(tally, memory, coulomb, viscous, acted, i, rows)
    return True


@compiled()
def write_down(course: Course, i: int, interaction: float, memory: Record) -> None:
    """Write down the torques in force at sample i."""
    course.interaction[i] = interaction
    course.compensation[i], course.passivity[i] = memory.compensation_nm, memory.passivity_nm


@compiled()
def interval(t: Float, i: int) -> float:
    """Return the time since the sample before, 0 at the first one. [s]"""
    return t[i] - t[i - 1] if i > 0 else 0.0


class Drive(NamedTuple):
    """What drives the joint, n samples.

    Attributes:
        t: Time. [s]
        push: Torque on the joint, linear between the samples; of an operator at position zero and at rest. [N m]
        lacking: Torque that the joint's model lacks: the sensor feels it, ``push`` is without it. [N m]
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
def run_closed_loop(control: Control, body: Record, inertia_kg_m2: float, drive: Drive, motion: Float) -> int:
    """Move the joint and run its compensator at the stamps of a log; return the samples, fewer than n if it diverges.

    Where the joint starts again from the recording, its kinetic energy is put back to that of the recording: neither
    compensator nor ledger shall take the difference for friction.

    Args:
        control: The compensator and what it is written into.
        body: Joint and operator, one element of ``model.body.BODY``.
        inertia_kg_m2: Of the joint alone, behind the sensor. [kg m^2]
        drive: What drives it.
        motion: Receives the velocity, shape (n,). [rad/s]
    """
    settings, memory, tally, feed, cuts, course, rows = control
    t, push = drive.t, drive.push
    q, v = drive.q[0], drive.dq[0]
    sign = direction(v)
    for i in range(len(t)):
        acceleration, friction = forces(q, v, sign, push[i], memory.u_nm, body)
        interaction = inertia_kg_m2 * acceleration + friction + body.offset_nm - memory.u_nm + drive.lacking[i]
        write_down(course, i, interaction, memory)
        motion[i] = v
        again = drive.restart[i] and i > 0
        if again:
            put_back(memory, 0.5 * inertia_kg_m2 * (v * v - drive.dq[i] * drive.dq[i]))
        if settings.kind == JOINT_MODEL:
            tell_friction(memory, feed, q, v, i)
        cut = cuts[i] if len(cuts) > 1 else cuts[0]
        if not tick(settings, memory, tally, i, interval(t, i), v, interaction, cut, rows):
            return i
        if again:
            q, v = drive.q[i], drive.dq[i]
            sign = begin_again(memory, q, v)
        if i + 1 < len(t):
            before, span, u = q, t[i + 1] - t[i], memory.u_nm
            q, v, sign, taken = move(q, v, sign, span, push[i], push[i + 1], u, body)
            count_energy(tally, settings, taken, taken - u * (q - before), q - before, span)
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
def begin_again(memory: Record, q: float, v: float) -> float:
    """Begin the compensator's next interval where the joint starts again from the recording; return its direction."""
    memory.q_rad, memory.dq = q, v
    return direction(v)


@compiled()
def put_back(memory: Record, surplus_j: float) -> None:
    """Take kinetic energy out of the compensator's sums: what is still in the joint, friction has not taken."""
    memory.net_j -= surplus_j
    memory.energy_j -= surplus_j
    if memory.active == 1:
        memory.active_energy_j -= surplus_j
