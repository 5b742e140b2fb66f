"""A joint whose friction follows from its velocity and a compensator in closed loop, driven by what was recorded."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.model.forward import LONGEST_STEP_S, advance, forces
from friction_audit.replay.records import Record
from friction_audit.replay.tally import count_energy
from friction_audit.replay.tick import Control, interval, tick


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
    q, v = drive.q[0], drive.dq[0]
    sign = direction(v)
    for i in range(len(drive.t)):
        interaction = feel(q, v, sign, i, inertia_kg_m2, control.memory.u_nm, drive, body)
        motion[i] = v
        if begins_again(drive, i):
            put_back(control.memory, 0.5 * inertia_kg_m2 * (v * v - drive.dq[i] * drive.dq[i]))
        if not tick(control, i, interval(drive.t, i), q, v, interaction):
            return i
        if begins_again(drive, i):
            q, v, sign = start_again(control.memory, drive, i)
        if i + 1 < len(drive.t):
            before, u = q, control.memory.u_nm
            q, v, sign, taken = move(q, v, sign, i, u, drive, body)
            moved, span = q - before, drive.t[i + 1] - drive.t[i]
            count_energy(control.tally, control.settings, taken, taken - u * moved, moved, span)
    return len(drive.t)


@compiled()
def feel(q: float, v: float, sign: float, i: int, inertia_kg_m2: float, u: float, drive: Drive, body: Record) -> float:
    """Return what the sensor feels at a sample. [N m]"""
    acceleration, friction = forces(q, v, sign, drive.push[i], u, body)
    return float(inertia_kg_m2 * acceleration + friction + body.offset_nm - u + drive.lacking[i])


@compiled()
def move(
    q: float, v: float, sign: float, i: int, u: float, drive: Drive, body: Record
) -> tuple[float, float, float, float]:
    """Move the joint on to the next stamp, in pieces; result as of ``model.forward.advance``."""
    span = drive.t[i + 1] - drive.t[i]
    pieces = max(1, int(np.ceil(span / LONGEST_STEP_S - 1e-6)))
    h, rise, taken = span / pieces, (drive.push[i + 1] - drive.push[i]) / pieces, 0.0
    for k in range(pieces):
        start = drive.push[i] + k * rise
        q, v, sign, lost = advance(q, v, sign, h, start, start + rise, u, body)
        taken += lost
    return q, v, sign, taken


@compiled()
def direction(v: float) -> float:
    """Return in which direction a joint slides; 0 at rest."""
    return 0.0 if v == 0.0 else math.copysign(1.0, v)


@compiled()
def begins_again(drive: Drive, i: int) -> bool:
    """Return True if the joint starts again from the recording at a sample."""
    return bool(drive.restart[i] and i > 0)


@compiled()
def start_again(memory: Record, drive: Drive, i: int) -> tuple[float, float, float]:
    """Return position, velocity and direction as recorded; the compensator's next interval begins there too."""
    memory.q_rad, memory.dq = drive.q[i], drive.dq[i]
    return drive.q[i], drive.dq[i], direction(drive.dq[i])


@compiled()
def put_back(memory: Record, surplus_j: float) -> None:
    """Take kinetic energy out of the compensator's sums: what is still in the joint, friction has not taken."""
    memory.net_j -= surplus_j
    memory.energy_j -= surplus_j
    if memory.active == 1:
        memory.active_energy_j -= surplus_j
