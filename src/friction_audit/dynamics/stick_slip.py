"""A joint's model as the record of numbers that the compiled step reads by name."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Model, Motion, Term
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

Record: TypeAlias = Any
"""One element of an array of BODY."""

EXCESS_POINTS = 4097
EXCESS_TOP_RAD_S = 4.0
"""Speed up to which a law of friction is sampled; beyond, it is continued level."""

PLAIN = ("coulomb", "viscous", "offset")
"""Terms that the step has as numbers; others of the velocity alone are sampled."""

BODY = np.dtype(
    [
        ("mass_kg_m2", "f8"),  # inertia of the joint and of the operator
        ("damping_nms_per_rad", "f8"),  # of the operator
        ("stiffness_nm_per_rad", "f8"),  # of the operator, against position zero
        ("coulomb_nm", "f8"),
        ("viscous_nms_per_rad", "f8"),
        ("offset_nm", "f8"),
        ("has_excess", "i8"),
        ("excess_step_rad_s", "f8"),
        ("excess_nm", "f8", (2, EXCESS_POINTS)),  # friction above Coulomb's by speed, forwards and backwards
    ],
    align=True,
)
"""What moves, and what acts on it."""


def make_body(
    model: Model, *, mass_kg_m2: float = 0.0, damping_nms_per_rad: float = 0.0, stiffness_nm_per_rad: float = 0.0
) -> Record:
    """Return the body of a joint, held by an operator where an impedance is given.

    Coulomb, viscous and constant torque enter as numbers; all other terms that follow from the velocity alone are
    sampled together, by direction, so that a joint at rest is held by their limit at speed zero.

    Raises:
        AnalysisError: If a term follows from more than the velocity, the inertia is not above zero, or friction would
            push.
    """
    if model.inertia_kg_m2 <= 0.0:
        raise AnalysisError(
            f"inertia_kg_m2 = {model.inertia_kg_m2:g}; expected a number above 0: a joint without inertia has no motion"
            " to simulate; give the reflected inertia, rotor and gear included"
        )
    unable = [term.name for term in model.terms if not term.effect.speed_only]
    if unable:
        raise AnalysisError(
            f"the model's {', '.join(unable)} follow from more than the velocity; the forward simulation expects terms"
            " of the velocity alone; take them out, or take their torque from the drive"
        )
    body = np.zeros(1, dtype=BODY)[0]
    body["mass_kg_m2"] = model.inertia_kg_m2 + mass_kg_m2
    body["damping_nms_per_rad"], body["stiffness_nm_per_rad"] = damping_nms_per_rad, stiffness_nm_per_rad
    for term in model.terms:
        if term.name in PLAIN:
            body[term.effect.coefficients[0].name] = term.values[0]
    sampled = [term for term in model.terms if term.name not in PLAIN]
    if sampled:
        body["has_excess"], body["excess_step_rad_s"] = 1, EXCESS_TOP_RAD_S / (EXCESS_POINTS - 1)
        body["excess_nm"] = np.array([_sample(sampled, 1.0), _sample(sampled, -1.0)])
        if np.min(body["coulomb_nm"] + body["excess_nm"]) < 0.0:
            names = ", ".join(term.name for term in sampled)
            raise AnalysisError(f"the model's friction pushes at some speed: {names} outweigh Coulomb friction")
    return body


def _sample(terms: list[Term], sign: float) -> Float:
    """Return the terms' torque against the motion, by speed in one direction, the limit at zero included."""
    speed = np.linspace(0.0, EXCESS_TOP_RAD_S, EXCESS_POINTS)
    speed[0] = 1e-12
    still = np.zeros(EXCESS_POINTS)
    motion = Motion(t=still, q=still, dq=sign * speed, ddq=still)
    return np.asarray(sign * np.sum([term.torque(motion) for term in terms], axis=0))


LONGEST_STEP_S = 2e-4
EVENTS = 8
ROOT_ITERATIONS = 6


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Operator:
    """Impedance of the person who holds the joint; its push is part of the drive.

    With push = F_m + m ddq + b dq + k q taken from a recording, (m + B) ddq' = push - b dq' - k q' + u' - tau_f'.

    Attributes:
        inertia_kg_m2: Inertia m.
        damping_nms_per_rad: Damping b.
        stiffness_nm_per_rad: Stiffness k, against position zero.
    """

    inertia_kg_m2: float = 0.0
    damping_nms_per_rad: float = 0.0
    stiffness_nm_per_rad: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ForwardMotion:
    """Motion that a model gives, shape (n,) each.

    Attributes:
        q: Position. [rad]
        dq: Velocity; exactly 0 where friction holds the joint. [rad/s]
        ddq: Acceleration. [rad/s^2]
        friction: Friction torque; at rest whatever holds the joint. [N m]
        dissipated: Energy that friction has taken so far. [J]
    """

    q: Float
    dq: Float
    ddq: Float
    friction: Float
    dissipated: Float


def simulate(
    model: Model, t: Float, drive: Float, *, q: float = 0.0, dq: float = 0.0, operator: Operator | None = None
) -> ForwardMotion:
    """Simulate one joint under a sampled torque.

    Args:
        model: The joint; terms must follow from the velocity alone.
        t: Times of the samples, rising, at any distance, shape (n,). [s]
        drive: Torque F_m + u on the inner side, or the push of an operator; linear between samples, shape (n,). [N m]
        q: Position at the start. [rad]
        dq: Velocity at the start. [rad/s]
        operator: Impedance that holds the joint; None if the drive is all there is.

    Raises:
        AnalysisError: If the model cannot be simulated, or times or drive are no finite numbers in order.
    """
    if len(t) != len(drive) or not (np.isfinite(t).all() and np.isfinite(drive).all() and (np.diff(t) > 0.0).all()):
        raise AnalysisError("forward simulation: times and drive must be finite, as many, and times must rise")
    held = operator or Operator()
    body = make_body(
        model,
        mass_kg_m2=held.inertia_kg_m2,
        damping_nms_per_rad=held.damping_nms_per_rad,
        stiffness_nm_per_rad=held.stiffness_nm_per_rad,
    )
    rows = run(np.ascontiguousarray(t), np.ascontiguousarray(drive), q, dq, body)
    return ForwardMotion(q=rows[0], dq=rows[1], ddq=rows[2], friction=rows[3], dissipated=rows[4])


@compiled()
def level(v: float, sign: float, body: Record) -> float:
    """Return friction without its viscous part at a speed, in a direction. [N m]"""
    if body.has_excess == 0:
        return float(body.coulomb_nm)
    curve = body.excess_nm[0 if sign > 0.0 else 1]
    place = min(abs(v) / body.excess_step_rad_s, len(curve) - 1.0)
    low = min(int(place), len(curve) - 2)
    return float(body.coulomb_nm + curve[low] + (place - low) * (curve[low + 1] - curve[low]))


@compiled()
def slide(
    q: float, v: float, h: float, drive0: float, drive1: float, steady: float, body: Record
) -> tuple[float, float]:
    """Slide for h under a drive and a steady torque: one step of the trapezoidal rule, solved exactly."""
    loss = body.damping_nms_per_rad + body.viscous_nms_per_rad
    stiffness = body.stiffness_nm_per_rad
    force = drive0 - stiffness * q - loss * v + steady
    predicted = drive1 - stiffness * (q + 0.5 * h * v) + steady
    v_next = (body.mass_kg_m2 * v + 0.5 * h * (force + predicted)) / (
        body.mass_kg_m2 + 0.5 * h * (0.5 * h * stiffness + loss)
    )
    return q + 0.5 * h * (v + v_next), v_next


@compiled()
def find_stop(
    q: float, v: float, v_end: float, h: float, drive0: float, drive1: float, steady: float, body: Record
) -> tuple[float, float]:
    """Find the share of h after which the velocity is zero, by regula falsi; return it and the position."""
    low, v_low, high, v_high = 0.0, v, 1.0, v_end
    share, place = 0.0, q
    for _ in range(ROOT_ITERATIONS):
        share = low + (high - low) * v_low / (v_low - v_high)
        place, speed = slide(q, v, share * h, drive0, drive0 + share * (drive1 - drive0), steady, body)
        if speed == 0.0:
            break
        if (speed > 0.0) == (v > 0.0):
            low, v_low = share, speed
        else:
            high, v_high = share, speed
    return share, place


@compiled()
def break_away(start: float, end: float, body: Record) -> tuple[float, float]:
    """Find when friction no longer holds a joint at rest.

    Args:
        start: Torque on the joint at the start of the step. [N m]
        end: Torque at its end. [N m]
        body: The joint.

    Returns:
        Share of the step after which it moves, and the direction; 1 and 0 where it is held throughout.
    """
    forwards, backwards = level(0.0, 1.0, body), -level(0.0, -1.0, body)
    if start > forwards:
        return 0.0, 1.0
    if start < backwards:
        return 0.0, -1.0
    if end > forwards:
        return (forwards - start) / (end - start), 1.0
    if end < backwards:
        return (backwards - start) / (end - start), -1.0
    return 1.0, 0.0


@compiled()
def advance(
    q: float, v: float, sign: float, h: float, drive0: float, drive1: float, u: float, body: Record
) -> tuple[float, float, float, float]:
    """Move one joint on by a step with stick and slip.

    Args:
        q: Position. [rad]
        v: Velocity. [rad/s]
        sign: Direction in which it slides; 0 if friction holds it.
        h: Step. [s]
        drive0: External torque at the start of the step. [N m]
        drive1: External torque at its end, linear between. [N m]
        u: Torque held over the step. [N m]
        body: One element of BODY.

    Returns:
        Position, velocity and direction at the end, and what friction has taken in the step. [J]
    """
    taken = 0.0
    steady = u - body.offset_nm
    for _ in range(EVENTS):
        if sign == 0.0:
            pull = steady - body.stiffness_nm_per_rad * q
            share, sign = break_away(drive0 + pull, drive1 + pull, body)
            if sign == 0.0:
                return q, 0.0, 0.0, taken
            h, drive0 = (1.0 - share) * h, drive0 + share * (drive1 - drive0)
        friction = level(v, sign, body)
        q_next, v_next = slide(q, v, h, drive0, drive1, steady - friction * sign, body)
        if body.has_excess == 1:
            friction = level(0.5 * (v + v_next) if v_next * sign > 0.0 else 0.5 * v, sign, body)
            q_next, v_next = slide(q, v, h, drive0, drive1, steady - friction * sign, body)
        if v_next * sign >= 0.0:
            lost = friction + 0.5 * body.viscous_nms_per_rad * abs(v + v_next)
            return q_next, v_next, sign, taken + lost * abs(q_next - q)
        share, q_stop = find_stop(q, v, v_next, h, drive0, drive1, steady - friction * sign, body)
        taken += (friction + 0.5 * body.viscous_nms_per_rad * abs(v)) * abs(q_stop - q)
        q, v, sign = q_stop, 0.0, 0.0
        h, drive0 = (1.0 - share) * h, drive0 + share * (drive1 - drive0)
    return q, 0.0, 0.0, taken


@compiled()
def forces(q: float, v: float, sign: float, drive: float, u: float, body: Record) -> tuple[float, float]:
    """Return acceleration [rad/s^2] and friction torque [N m] at one instant."""
    drive = drive + u - body.offset_nm - body.stiffness_nm_per_rad * q - body.damping_nms_per_rad * v
    if sign == 0.0:
        return 0.0, drive
    friction = level(v, sign, body) * sign + body.viscous_nms_per_rad * v
    return (drive - friction) / body.mass_kg_m2, friction


@compiled()
def run(t: Float, drive: Float, q: float, v: float, body: Record) -> Float:
    """Return rows q, dq, ddq, friction and dissipated energy, shape (5, n); see ``simulate``."""
    out = np.zeros((5, len(t)))
    sign, taken = float(np.sign(v)), 0.0
    for i in range(len(t)):
        if i > 0:
            steps = max(1, int(np.ceil((t[i] - t[i - 1]) / LONGEST_STEP_S - 1e-6)))
            h, rise = (t[i] - t[i - 1]) / steps, (drive[i] - drive[i - 1]) / steps
            for k in range(steps):
                start = drive[i - 1] + k * rise
                q, v, sign, lost = advance(q, v, sign, h, start, start + rise, 0.0, body)
                taken += lost
        out[0, i], out[1, i], out[4, i] = q, v, taken
        out[2, i], out[3, i] = forces(q, v, sign, drive[i], 0.0, body)
    return out
