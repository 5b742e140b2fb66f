"""One joint moved forward in time with stick and slip, compiled.

``Tables`` hold its torque over speed, position and time, and its bristles. The midpoint rule is of second order, stops
and break-aways included: where the velocity passes zero the joint stops inside the step, friction holds it until the
torque exceeds it, and that instant is found too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.torque_tables import Tables, bend_on, bristle_damping, bristle_nm, taken
from friction_audit.joint_log import Float

EVENTS = 8  # stops and break-aways that are resolved in one step


class Step(NamedTuple):
    """A step in time, under a torque that is linear in it."""

    h: float  # its length [s]
    drive0: float  # torque at its start [N m]
    drive1: float  # torque at its end [N m]
    begin: float  # its start, counted in samples of the recording that tables were made from
    end: float  # its end, likewise


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
