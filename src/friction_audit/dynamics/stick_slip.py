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


@compiled(inline=True)
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
    damping = bristle_damping(bent, sign, tables)
    torque = taken(sign, q, abs(v), step.begin, tables) + bristle_nm(bent, 0.0, tables) + damping * v
    middle = v + 0.5 * step.h * (step.drive0 - torque) / tables.inertia_kg_m2
    speed, ahead = max(0.0, middle * sign), 0.5 * step.h * v
    moment, drive = 0.5 * (step.begin + step.end), 0.5 * (step.drive0 + step.drive1)
    torque = taken(sign, q + ahead, speed, moment, tables) + bristle_nm(bent, ahead, tables) + damping * speed * sign
    return v + step.h * (drive - torque) / tables.inertia_kg_m2


@compiled()
def advance(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> tuple[float, float, float]:
    """Move a joint with tables on by a step; return position, velocity and direction at the end.

    The direction is 0 if friction holds it; the state of the bristles, shape (1 + m,), changes.
    """
    for _ in range(EVENTS):
        if sign == 0.0:
            held = bristle_nm(bent, 0.0, tables)
            forwards, backwards = taken(1.0, q, 0.0, step.begin, tables), taken(-1.0, q, 0.0, step.begin, tables)
            if forwards < backwards:
                # Bristles bear all the friction: nothing dry is left that could hold the joint.
                forwards = backwards = 0.5 * (forwards + backwards)
            # The share of the step after which it moves, and the direction.
            start, end, share = step.drive0 - held, step.drive1 - held, 0.0
            if start > forwards or start < backwards:
                sign = 1.0 if start > forwards else -1.0
            elif end > forwards or end < backwards:
                sign, level = (1.0, forwards) if end > forwards else (-1.0, backwards)
                share = (level - start) / (end - start)
            else:
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

    Pieces are first and last sample, shape (p, 2); a sample of ``step_s`` takes ``steps`` steps. The drive is linear
    between samples. Drive, recorded position and velocity have the shape (n,), the bristles' state along the recording
    (n, 1 + m). Returns position and velocity, NaN outside of the pieces, shape (2, n).
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
