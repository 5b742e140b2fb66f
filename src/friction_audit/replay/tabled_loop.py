"""A joint whose torque is tabulated and a compensator in closed loop, driven by what was recorded.

What holds for ``closed_loop`` holds here; the joint is moved as ``model.move`` does, and may have bristles.
"""

from typing import NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.model.move import Step, advance, drag, held_torque, taken
from friction_audit.model.tables import Tables
from friction_audit.replay.closed_loop import Drive, begins_again, direction, put_back, start_again
from friction_audit.replay.tally import count_energy
from friction_audit.replay.tick import Control, interval, tick


class TabledJoint(NamedTuple):
    """Joint and operator.

    Attributes:
        tables: What both take but for the operator's spring, and the inertia of both.
        inertia_kg_m2: Inertia of the operator. [kg m^2]
        damping_nms_per_rad: Damping of the operator, in the tables too. [N m s/rad]
        stiffness_nm_per_rad: Stiffness of the operator, against position zero. [N m/rad]
        longest_s: Longest step. [s]
        bent: State of the bristles at the first sample and at every new start, shape (r, 1 + m).
    """

    tables: Tables
    inertia_kg_m2: float
    damping_nms_per_rad: float
    stiffness_nm_per_rad: float
    longest_s: float
    bent: Float


@compiled()
def run_tabled_loop(control: Control, joint: TabledJoint, drive: Drive, motion: Float) -> int:
    """Move the joint and run its compensator at the stamps of a log; arguments and result as of ``run_closed_loop``."""
    q, v, starts, bent = drive.q[0], drive.dq[0], 0, joint.bent[0].copy()
    own_kg_m2 = joint.tables.inertia_kg_m2 - joint.inertia_kg_m2
    sign = direction(v)
    for i in range(len(drive.t)):
        interaction = feel(q, v, sign, i, control.memory.u_nm, bent, drive, joint)
        motion[i] = v
        if begins_again(drive, i):
            put_back(control.memory, 0.5 * own_kg_m2 * (v * v - drive.dq[i] * drive.dq[i]))
        if not tick(control, i, interval(drive.t, i), q, v, interaction):
            return i
        if begins_again(drive, i):
            q, v, sign = start_again(control.memory, drive, i)
            starts += 1
            bent[:] = joint.bent[starts]
        if i + 1 < len(drive.t):
            before, u = q, control.memory.u_nm
            q, v, sign, lost = move(q, v, sign, i, u, bent, drive, joint)
            moved, span = q - before, drive.t[i + 1] - drive.t[i]
            count_energy(control.tally, control.settings, lost, lost - u * moved, moved, span)
    return len(drive.t)


@compiled()
def feel(q: float, v: float, sign: float, i: int, u: float, bent: Float, drive: Drive, joint: TabledJoint) -> float:
    """Return what the sensor feels at a sample: the push, less what the operator's own impedance takes of it. [N m]"""
    spring, acceleration = joint.stiffness_nm_per_rad * q, 0.0
    if sign != 0.0:
        torque = taken(0 if sign > 0.0 else 1, q, abs(v), float(i), joint.tables)
        torque += held_torque(bent, 0.0, joint.tables) + drag(bent, sign, joint.tables) * v
        acceleration = (drive.push[i] + u - spring - torque) / joint.tables.inertia_kg_m2
    impedance = joint.inertia_kg_m2 * acceleration + joint.damping_nms_per_rad * v + spring
    return float(drive.push[i] + drive.lacking[i] - impedance)


@compiled()
def move(
    q: float, v: float, sign: float, i: int, u: float, bent: Float, drive: Drive, joint: TabledJoint
) -> tuple[float, float, float, float]:
    """Move the joint on to the next stamp, in pieces; return place, velocity, direction and what friction took [J]."""
    span = drive.t[i + 1] - drive.t[i]
    pieces = max(1, int(np.ceil(span / joint.longest_s - 1e-6)))
    h, rise, lost = span / pieces, (drive.push[i + 1] - drive.push[i]) / pieces, 0.0
    for k in range(pieces):
        push, begin, end, held = drive.push[i] + k * rise + u, i + k / pieces, i + (k + 1.0) / pieces, bent.copy()
        # The operator's spring is read where the joint will be if it goes on: right to the order of the step.
        springs = joint.stiffness_nm_per_rad * q, joint.stiffness_nm_per_rad * (q + h * v)
        before = q
        q, v, sign = advance(
            q, v, sign, Step(h, push - springs[0], push + rise - springs[1], begin, end), bent, joint.tables
        )
        lost += dissipated(0.5 * (before + q), q - before, h, 0.5 * (begin + end), 0.5 * (held + bent), joint)
    return q, v, sign, lost


@compiled()
def dissipated(q: float, moved: float, h: float, moment: float, bent: Float, joint: TabledJoint) -> float:
    """Return what friction takes in a step: what turns with the direction, and the bristles. [J]

    What acts the same way in both directions, as gravity does, gives back what it takes.
    """
    if moved == 0.0:
        return 0.0
    speed, sign = abs(moved) / h, direction(moved)
    both = taken(0, q, speed, moment, joint.tables) - taken(1, q, speed, moment, joint.tables)
    level = 0.5 * both - joint.damping_nms_per_rad * speed
    bristles = held_torque(bent, 0.0, joint.tables) + drag(bent, sign, joint.tables) * moved / h
    return float(level * abs(moved) + bristles * moved)
