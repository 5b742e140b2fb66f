"""One joint moved forward in time with stick and slip, compiled.

The friction of the joint has one of two forms, and each has its rule for a step. A ``Body`` has Coulomb, viscous and
constant torque as numbers and other friction sampled over the speed: the trapezoidal rule, solved exactly, whose energy
balance closes to rounding. ``Tables`` hold torque over speed, position and time, and bristles: the midpoint rule. Both
are of second order, stops and break-aways included: where the velocity passes zero the joint stops inside the step,
friction holds it until the torque exceeds it, and that instant is found too.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Model, Motion, Term
from friction_audit.dynamics.torque_tables import Tables, bend_on, bristle_damping, bristle_nm, taken
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

EVENTS = 8  # stops and break-aways that are resolved in one step
BODY_STEP_S = 2e-4  # longest step of a body

CURVE_POINTS, CURVE_TOP_RAD_S = 4097, 4.0  # sampling of friction over the speed; level beyond its end

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
        ("excess_nm", "f8", (2, CURVE_POINTS)),  # friction above Coulomb friction over the speed, forwards, backwards
    ],
    align=True,
)
Body: TypeAlias = Any  # one element of an array of BODY


class Step(NamedTuple):
    """A step in time, under a torque that is linear in it.

    Attributes:
        h: Its length. [s]
        drive0: Torque at its start. [N m]
        drive1: Torque at its end. [N m]
        begin: Its start, counted in samples of the recording that tables were made from.
        end: Its end, likewise.
    """

    h: float
    drive0: float
    drive1: float
    begin: float
    end: float


def make_body(
    model: Model, *, mass_kg_m2: float = 0.0, damping_nms_per_rad: float = 0.0, stiffness_nm_per_rad: float = 0.0
) -> Body:
    """Return a joint whose friction follows from the velocity, held by the impedance of an operator.

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
    sampled = []
    for term in model.terms:
        if term.name in ("coulomb", "viscous", "offset"):
            body[term.effect.coefficients[0].name] = term.values[0]
        else:
            sampled.append(term)
    if sampled:
        body["has_excess"], body["excess_step_rad_s"] = 1, CURVE_TOP_RAD_S / (CURVE_POINTS - 1)
        body["excess_nm"] = [_curve(sampled, 1.0), _curve(sampled, -1.0)]
        if np.min(body["coulomb_nm"] + body["excess_nm"]) < 0.0:
            names = ", ".join(term.name for term in sampled)
            raise AnalysisError(f"the model's friction pushes at some speed: {names} outweigh Coulomb friction")
    return body


def _curve(terms: Sequence[Term], sign: float) -> Float:
    speed = np.linspace(0.0, CURVE_TOP_RAD_S, CURVE_POINTS)
    speed[0] = 1e-12  # the limit at zero speed is what holds a joint at rest
    still = np.zeros(CURVE_POINTS)
    motion = Motion(t=still, q=still, dq=sign * speed, ddq=still)
    return np.asarray(sign * np.sum([term.torque(motion) for term in terms], axis=0))


@compiled()
def break_away(start: float, end: float, forwards: float, backwards: float) -> tuple[float, float]:
    """Return the share of a step after which a held joint moves, and the direction; 1 and 0 where it does not move."""
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
def rest_of(step: Step, share: float) -> Step:
    """Return what is left of a step after a share of it."""
    return Step(
        (1.0 - share) * step.h,
        step.drive0 + share * (step.drive1 - step.drive0),
        step.drive1,
        step.begin + share * (step.end - step.begin),
        step.end,
    )


@compiled()
def level(v: float, sign: float, body: Body) -> float:
    """Return the friction of a body without its viscous part. [N m]"""
    if body.has_excess == 0:
        return float(body.coulomb_nm)
    curve = body.excess_nm[0 if sign > 0.0 else 1]
    place = min(abs(v) / body.excess_step_rad_s, len(curve) - 1.0)
    low = min(int(place), len(curve) - 2)
    return float(body.coulomb_nm + curve[low] + (place - low) * (curve[low + 1] - curve[low]))


@compiled()
def slide_body(q: float, v: float, step: Step, steady: float, body: Body) -> tuple[float, float]:
    """Return position and velocity after sliding through a step under a further steady torque."""
    h, loss, stiffness = step.h, body.damping_nms_per_rad + body.viscous_nms_per_rad, body.stiffness_nm_per_rad
    force = step.drive0 - stiffness * q - loss * v + steady
    predicted = step.drive1 - stiffness * (q + 0.5 * h * v) + steady
    v_next = (body.mass_kg_m2 * v + 0.5 * h * (force + predicted)) / (
        body.mass_kg_m2 + 0.5 * h * (0.5 * h * stiffness + loss)
    )
    return q + 0.5 * h * (v + v_next), v_next


@compiled()
def find_stop(q: float, v: float, v_end: float, step: Step, steady: float, body: Body) -> tuple[float, float]:
    """Return the share of a step after which the velocity is zero, by regula falsi, and the position there."""
    low, v_low, high, v_high = 0.0, v, 1.0, v_end
    share, place = 0.0, q
    for _ in range(6):
        share = low + (high - low) * v_low / (v_low - v_high)
        end = step.drive0 + share * (step.drive1 - step.drive0)
        place, speed = slide_body(q, v, Step(share * step.h, step.drive0, end, 0.0, 0.0), steady, body)
        if speed == 0.0:
            break
        if (speed > 0.0) == (v > 0.0):
            low, v_low = share, speed
        else:
            high, v_high = share, speed
    return share, place


@compiled()
def advance_body(
    q: float, v: float, sign: float, step: Step, u: float, body: Body
) -> tuple[float, float, float, float]:
    """Move a body on by a step.

    Args:
        q: Position. [rad]
        v: Velocity. [rad/s]
        sign: Direction in which it slides; 0 if friction holds it.
        step: The step.
        u: Torque held over the step. [N m]
        body: The joint.

    Returns:
        Position, velocity and direction at the end, and what friction has taken. [J]
    """
    taken = 0.0
    steady = u - body.offset_nm
    for _ in range(EVENTS):
        if sign == 0.0:
            pull = steady - body.stiffness_nm_per_rad * q
            forwards, backwards = level(0.0, 1.0, body), -level(0.0, -1.0, body)
            share, sign = break_away(step.drive0 + pull, step.drive1 + pull, forwards, backwards)
            if sign == 0.0:
                return q, 0.0, 0.0, taken
            step = rest_of(step, share)
        friction = level(v, sign, body)
        q_next, v_next = slide_body(q, v, step, steady - friction * sign, body)
        if body.has_excess == 1:
            friction = level(0.5 * (v + v_next) if v_next * sign > 0.0 else 0.5 * v, sign, body)
            q_next, v_next = slide_body(q, v, step, steady - friction * sign, body)
        if v_next * sign >= 0.0:
            lost = friction + 0.5 * body.viscous_nms_per_rad * abs(v + v_next)
            return q_next, v_next, sign, taken + lost * abs(q_next - q)
        share, q_stop = find_stop(q, v, v_next, step, steady - friction * sign, body)
        taken += (friction + 0.5 * body.viscous_nms_per_rad * abs(v)) * abs(q_stop - q)
        q, v, sign = q_stop, 0.0, 0.0
        step = rest_of(step, share)
    return q, 0.0, 0.0, taken


@compiled()
def body_forces(q: float, v: float, sign: float, drive: float, u: float, body: Body) -> tuple[float, float]:
    """Return acceleration [rad/s^2] and friction torque [N m] of a body at one instant."""
    drive = drive + u - body.offset_nm - body.stiffness_nm_per_rad * q - body.damping_nms_per_rad * v
    if sign == 0.0:
        return 0.0, drive
    friction = level(v, sign, body) * sign + body.viscous_nms_per_rad * v
    return (drive - friction) / body.mass_kg_m2, friction


@compiled()
def slide(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> float:
    """Return the velocity of a joint with tables after sliding through a step in one direction."""
    way = 0 if sign > 0.0 else 1
    damping = bristle_damping(bent, sign, tables)
    torque = taken(way, q, abs(v), step.begin, tables) + bristle_nm(bent, 0.0, tables) + damping * v
    middle = v + 0.5 * step.h * (step.drive0 - torque) / tables.inertia_kg_m2
    speed, ahead = max(0.0, middle * sign), 0.5 * step.h * v
    moment, drive = 0.5 * (step.begin + step.end), 0.5 * (step.drive0 + step.drive1)
    torque = taken(way, q + ahead, speed, moment, tables) + bristle_nm(bent, ahead, tables) + damping * speed * sign
    return v + step.h * (drive - torque) / tables.inertia_kg_m2


@compiled()
def advance(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> tuple[float, float, float]:
    """Move a joint with tables on by a step; return position, velocity and direction at the end.

    Args:
        q: Position. [rad]
        v: Velocity. [rad/s]
        sign: Direction in which it slides; 0 if friction holds it.
        step: The step.
        bent: State of the bristles, shape (1 + m,); changed.
        tables: What the joint takes.
    """
    for _ in range(EVENTS):
        if sign == 0.0:
            held = bristle_nm(bent, 0.0, tables)
            forwards, backwards = taken(0, q, 0.0, step.begin, tables), taken(1, q, 0.0, step.begin, tables)
            if forwards < backwards:
                # Bristles bear all the friction: nothing dry is left that could hold the joint.
                forwards = backwards = 0.5 * (forwards + backwards)
            share, sign = break_away(step.drive0 - held, step.drive1 - held, forwards, backwards)
            if sign == 0.0:
                return q, 0.0, 0.0
            step = rest_of(step, share)
        after = slide(q, v, sign, step, bent, tables)
        if after * sign >= 0.0:
            way = 0.5 * step.h * (v + after)
            bend_on(bent, way, tables)
            return q + way, after, sign
        share = v / (v - after)
        way = 0.5 * share * step.h * v
        bend_on(bent, way, tables)
        q, v, sign = q + way, 0.0, 0.0
        step = rest_of(step, share)
    return q, 0.0, 0.0


@compiled()
def run_pieces(
    step_s: float, steps: int, drive: Float, q: Float, dq: Float, pieces: NDArray[np.int64], bent: Float, tables: Tables
) -> Float:
    """Move a joint with tables through pieces of a recording, each from the recorded start.

    Args:
        step_s: Spacing of the samples. [s]
        steps: Steps per sample.
        drive: Torque at the samples, linear between, shape (n,). [N m]
        q: Recorded position, shape (n,). [rad]
        dq: Recorded velocity, shape (n,). [rad/s]
        pieces: First and last sample of each piece, shape (p, 2).
        bent: State of the bristles along the recording, shape (n, 1 + m).
        tables: What the joint takes.

    Returns:
        Position and velocity, NaN outside of the pieces, shape (2, n).
    """
    out = np.full((2, len(drive)), np.nan)
    for p in range(len(pieces)):
        first, last = pieces[p]
        place, v, now = q[first], dq[first], bent[first].copy()
        sign = np.sign(v)
        out[0, first], out[1, first] = place, v
        for i in range(first, last):
            rise = (drive[i + 1] - drive[i]) / steps
            for k in range(steps):
                push = drive[i] + k * rise
                step = Step(step_s / steps, push, push + rise, i + k / steps, i + (k + 1.0) / steps)
                place, v, sign = advance(place, v, sign, step, now, tables)
            out[0, i + 1], out[1, i + 1] = place, v
    return out
