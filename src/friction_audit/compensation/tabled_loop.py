"""A joint whose torque is tabulated and a compensator in closed loop, driven by what was recorded.

What holds for ``closed_loop`` holds here; the joint is moved as ``model.move`` does, and may have bristles.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from friction_audit.compensation.closed_loop import (
    Control,
    Drive,
    begin_again,
    direction,
    interval,
    put_back,
    tick,
    write_down,
)
from friction_audit.compensation.compensators.law import JOINT_MODEL
from friction_audit.compensation.feed_forward import NO_MODEL, past_refusal, refusal, straighten, tell_friction
from friction_audit.compensation.operator_fit import LEAST_INERTIA_KG_M2, FittedJoint, FittedOperator, fit_joint
from friction_audit.compensation.records import Record
from friction_audit.compensation.tally import count_energy
from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.move import Step, advance, drag, held_torque, steps_per_sample, taken
from friction_audit.dynamics.stick_slip import make_body
from friction_audit.dynamics.torque_tables import Tables, tabulate
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float


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
    settings, memory, tally, feed, cuts, course, rows = control
    t, push = drive.t, drive.push
    q, v, starts, bent = drive.q[0], drive.dq[0], 0, joint.bent[0].copy()
    own_kg_m2 = joint.tables.inertia_kg_m2 - joint.inertia_kg_m2
    sign = direction(v)
    for i in range(len(t)):
        interaction = feel(q, v, sign, i, push[i], memory.u_nm, bent, joint) + drive.lacking[i]
        write_down(course, i, interaction, memory)
        motion[i] = v
        again = drive.restart[i] and i > 0
        if again:
            put_back(memory, 0.5 * own_kg_m2 * (v * v - drive.dq[i] * drive.dq[i]))
        if settings.kind == JOINT_MODEL:
            tell_friction(memory, feed, q, v, i)
        cut = cuts[i] if len(cuts) > 1 else cuts[0]
        if not tick(settings, memory, tally, i, interval(t, i), v, interaction, cut, rows):
            return i
        if again:
            q, v, starts = drive.q[i], drive.dq[i], starts + 1
            sign, bent[:] = begin_again(memory, q, v), joint.bent[starts]
        if i + 1 < len(t):
            before, span, u = q, t[i + 1] - t[i], memory.u_nm
            q, v, sign, lost = move(q, v, sign, Step(span, push[i] + u, push[i + 1] + u, i, i + 1.0), bent, joint)
            count_energy(tally, settings, lost, lost - u * (q - before), q - before, span)
    return len(t)


@compiled()
def feel(q: float, v: float, sign: float, i: int, push: float, u: float, bent: Float, joint: TabledJoint) -> float:
    """Return what is felt at a sample of the push: that, less what the operator's own impedance takes of it. [N m]"""
    spring, acceleration = joint.stiffness_nm_per_rad * q, 0.0
    if sign != 0.0:
        torque = taken(0 if sign > 0.0 else 1, q, abs(v), float(i), joint.tables)
        torque += held_torque(bent, 0.0, joint.tables) + drag(bent, sign, joint.tables) * v
        acceleration = (push + u - spring - torque) / joint.tables.inertia_kg_m2
    return float(push - joint.inertia_kg_m2 * acceleration - joint.damping_nms_per_rad * v - spring)


@compiled()
def move(
    q: float, v: float, sign: float, whole: Step, bent: Float, joint: TabledJoint
) -> tuple[float, float, float, float]:
    """Move the joint on through a step, in pieces; return place, velocity, direction and what friction took [J]."""
    pieces = max(1, int(np.ceil(whole.h / joint.longest_s - 1e-6)))
    h, rise, lost = whole.h / pieces, (whole.drive1 - whole.drive0) / pieces, 0.0
    for k in range(pieces):
        before, held, push = q, bent.copy(), whole.drive0 + k * rise
        begin, end = whole.begin + k / pieces, whole.begin + (k + 1.0) / pieces
        # The operator's spring is read where the joint will be if it goes on: right to the order of the step.
        near, far = joint.stiffness_nm_per_rad * q, joint.stiffness_nm_per_rad * (q + h * v)
        q, v, sign = advance(q, v, sign, Step(h, push - near, push + rise - far, begin, end), bent, joint.tables)
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


CONSTANT = ("offset", "torque_bias")
"""Terms of a constant torque."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class MovedJoint:
    """A joint that can be simulated in a compensator's loop.

    Attributes:
        model: Its model.
        fitted: The fit to the log that the model is; None where it is of a file.
        tables: What its terms take along the recording; None where they follow from the velocity alone.
    """

    model: JointModel
    fitted: FittedJoint | None = None
    tables: Tables | None = None


def fitted_joint(friction: JointFriction) -> MovedJoint | str:
    """Return the joint that the log shows, or why it cannot be simulated."""
    fitted = fit_joint(friction)
    return fitted if isinstance(fitted, str) else MovedJoint(model=fitted.model, fitted=fitted)


def modelled_joint(model: JointModel | None, motion: Motion) -> MovedJoint | str:
    """Return the joint of a model file, or why it cannot be simulated.

    Args:
        model: Its model, if the file has one.
        motion: The recording.
    """
    if model is None:
        return NO_MODEL
    unable = refusal(model.terms)
    if unable:
        return unable
    if all(term.effect.speed_only for term in model.terms):
        return _of_speed(model)
    tables, past = tabulate(model.inertia_kg_m2, model.terms, motion)
    if past:
        return past_refusal(past)
    reason = _too_light(tables.inertia_kg_m2)
    return reason or MovedJoint(model=model, tables=tables)


def _of_speed(model: JointModel) -> MovedJoint | str:
    reason = _too_light(model.inertia_kg_m2)
    try:
        make_body(_with_offset(model))
    except AnalysisError as error:
        reason = reason or str(error)
    return reason or MovedJoint(model=model)


def _too_light(inertia_kg_m2: float) -> str:
    if inertia_kg_m2 > LEAST_INERTIA_KG_M2:
        return ""
    return (
        f"its model has an inertia of {inertia_kg_m2:.3g} kg m^2, of a torque from which the inertia was taken out; "
        "without it nobody knows how it would have moved; put that of the joint into the file, or use "
        "--assume same-motion"
    )


def body_of(joint: MovedJoint, operator: FittedOperator | None) -> Record:
    """Return a joint whose friction follows from the velocity, and the person who holds it."""
    mass, damping, stiffness = impedance(operator)
    model = _with_offset(joint.model)
    return make_body(model, mass_kg_m2=mass, damping_nms_per_rad=damping, stiffness_nm_per_rad=stiffness)


def _with_offset(model: JointModel) -> JointModel:
    """Return a model whose constant torque is an offset, which is not taken for friction."""
    constant = sum(term.values[0] for term in model.terms if term.name in CONSTANT)
    others = tuple(term for term in model.terms if term.name not in CONSTANT)
    return replace(model, terms=(*others, FittedTerm("offset", (constant,))))


def tabled_of(
    tables: Tables, operator: FittedOperator | None, motion: Motion, starts: Float, step_s: float
) -> TabledJoint:
    """Return a joint whose torque is tabulated, and the person who holds it.

    Args:
        tables: What the joint takes along the recording.
        operator: The person, or None.
        motion: The recording.
        starts: Samples at which the joint starts from the recording, the first one among them, shape (r,).
        step_s: Spacing of the samples. [s]
    """
    mass, damping, stiffness = impedance(operator)
    held = straighten(tables._replace(inertia_kg_m2=tables.inertia_kg_m2 + mass), damping_nms_per_rad=damping)
    return TabledJoint(
        tables=held,
        inertia_kg_m2=mass,
        damping_nms_per_rad=damping,
        stiffness_nm_per_rad=stiffness,
        longest_s=step_s / steps_per_sample(step_s, held),
        bent=np.ascontiguousarray(tables.bristles.states_along(motion.q)[starts]),
    )


def impedance(operator: FittedOperator | None) -> tuple[float, float, float]:
    """Return inertia, damping and stiffness of the person; of nobody, zeros."""
    if operator is None:
        return 0.0, 0.0, 0.0
    return operator.inertia.value, operator.damping.value, operator.stiffness.value
