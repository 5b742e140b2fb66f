"""A joint whose torque is tabulated, moved forward in time with stick and slip, compiled.

Between events the joint slides under drive - torque(direction, place, speed, time) - bristles, the drive being linear
in time over the step: the midpoint rule, of second order. Where the velocity passes zero the joint stops inside the
step; friction holds it as long as the drive is between what it takes forwards and what it takes backwards, and the
instant of break-away is found from the drive.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.bristles import bend, slope, stretch
from friction_audit.dynamics.torque_tables import Tables
from friction_audit.joint_log import Float

EVENTS = 8
LONGEST_STEP_S = 5e-4
SHARE_OF_SWING = 0.2
"""Longest step as a share of 1 / the angular frequency at which the joint swings on its stiffest torque."""
MOST_STEPS = 200
"""Per sample."""


class Step(NamedTuple):
    """A step in time.

    Attributes:
        h: Its length. [s]
        drive0: Torque at its start. [N m]
        drive1: Torque at its end, linear between. [N m]
        begin: Its start, counted in samples of the recording.
        end: Its end, likewise.
    """

    h: float
    drive0: float
    drive1: float
    begin: float
    end: float


@compiled()
def read(table: Float, place: float) -> float:
    """Read a table between its entries; level beyond its ends."""
    place = min(max(place, 0.0), len(table) - 1.0)
    low = min(int(place), len(table) - 2)
    return float(table[low] + (place - low) * (table[low + 1] - table[low]))


@compiled()
def taken(way: int, q: float, speed: float, moment: float, tables: Tables) -> float:
    """Return what the joint takes without its bristles, in a direction, at a moment counted in samples. [N m]"""
    place = (q - tables.place_start) / tables.place_step
    per_speed = read(tables.place_per_speed[way], place) + read(tables.time_per_speed[way], moment)
    level = read(tables.speed[way], speed / tables.speed_step) + read(tables.place[way], place)
    return level + read(tables.time[way], moment) + per_speed * speed


@compiled()
def held_torque(bent: Float, way: float, tables: Tables) -> float:
    """Return the torque of the bristles a piece of the way ahead. [N m]"""
    torque = bend(bent[0], way, tables.bristle_path, tables.bristle_torque)
    for k in range(len(tables.spring_reach)):
        torque += tables.spring_stiffness[k] * stretch(bent[1 + k], way, tables.spring_reach[k])
    return torque


@compiled()
def bend_on(bent: Float, way: float, tables: Tables) -> None:
    """Let the bristles follow a piece of the way, in place."""
    bent[0] = bend(bent[0], way, tables.bristle_path, tables.bristle_torque)
    for k in range(len(tables.spring_reach)):
        bent[1 + k] = stretch(bent[1 + k], way, tables.spring_reach[k])


@compiled()
def drag(bent: Float, sign: float, tables: Tables) -> float:
    """Return the damping of the bristles that bend on in a direction. [N m s/rad]"""
    if tables.bristle_damping_s == 0.0:
        return 0.0
    stiffness = slope(bent[0], sign, tables.bristle_path, tables.bristle_torque)
    for k in range(len(tables.spring_reach)):
        if bent[1 + k] * sign < tables.spring_reach[k]:
            stiffness += tables.spring_stiffness[k]
    return float(tables.bristle_damping_s * stiffness)


@compiled()
def break_away(start: float, end: float, q: float, moment: float, tables: Tables) -> tuple[float, float]:
    """Find when the drive, less the bristles, moves a joint at rest.

    Returns:
        Share of the step after which it moves, and the direction; 1 and 0 where it is held throughout.
    """
    forwards, backwards = taken(0, q, 0.0, moment, tables), taken(1, q, 0.0, moment, tables)
    if forwards < backwards:
        # Bristles bear all there is: nothing dry is left that could hold the joint.
        forwards = backwards = 0.5 * (forwards + backwards)
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
def slide(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> float:
    """Return the velocity after sliding through a step in one direction."""
    way = 0 if sign > 0.0 else 1
    damping = drag(bent, sign, tables)
    torque = taken(way, q, abs(v), step.begin, tables) + held_torque(bent, 0.0, tables) + damping * v
    middle = v + 0.5 * step.h * (step.drive0 - torque) / tables.inertia_kg_m2
    speed, ahead = max(0.0, middle * sign), 0.5 * step.h * v
    moment, drive = 0.5 * (step.begin + step.end), 0.5 * (step.drive0 + step.drive1)
    torque = taken(way, q + ahead, speed, moment, tables) + held_torque(bent, ahead, tables) + damping * speed * sign
    return v + step.h * (drive - torque) / tables.inertia_kg_m2


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
def advance(q: float, v: float, sign: float, step: Step, bent: Float, tables: Tables) -> tuple[float, float, float]:
    """Move the joint on by a step with stick and slip.

    Args:
        q: Position. [rad]
        v: Velocity. [rad/s]
        sign: Direction in which it slides; 0 if friction holds it.
        step: The step.
        bent: State of the bristles, shape (1 + m,); changed.
        tables: What the joint takes.

    Returns:
        Position, velocity and direction at the end.
    """
    for _ in range(EVENTS):
        if sign == 0.0:
            held = held_torque(bent, 0.0, tables)
            share, sign = break_away(step.drive0 - held, step.drive1 - held, q, step.begin, tables)
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
def steps_per_sample(step_s: float, tables: Tables) -> int:
    """Return how many steps of the simulation a sample takes, so that no spring is too stiff for them."""
    steepest, stiffness = 0.0, np.sum(tables.spring_stiffness)
    for k in range(len(tables.bristle_path) - 1):
        drop = tables.bristle_torque[k] - tables.bristle_torque[k + 1]
        stiffness = max(stiffness, drop / (tables.bristle_path[k + 1] - tables.bristle_path[k]))
    for way in range(2):
        for k in range(len(tables.place[way]) - 1):
            steepest = max(steepest, abs(tables.place[way, k + 1] - tables.place[way, k]) / tables.place_step)
    swing = np.sqrt((stiffness + steepest) / tables.inertia_kg_m2)
    longest = min(LONGEST_STEP_S, SHARE_OF_SWING / max(swing, 1e-9))
    return max(1, min(MOST_STEPS, int(np.ceil(step_s / longest - 1e-6))))


@compiled()
def run(
    step_s: float,
    drive: Float,
    start: tuple[float, float],
    first: int,
    last: int,
    bent: Float,
    tables: Tables,
    out: Float,
) -> None:
    """Move the joint from one sample of the recording to another.

    Args:
        step_s: Spacing of the samples. [s]
        drive: Torque at the samples, linear between, shape (n,). [N m]
        start: Position [rad] and velocity [rad/s] at the first sample.
        first: First sample.
        last: Last sample.
        bent: State of the bristles at the first sample, shape (1 + m,); changed.
        tables: What the joint takes.
        out: Receives position and velocity at samples first to last, shape (2, n).
    """
    steps = steps_per_sample(step_s, tables)
    q, v = start
    sign = np.sign(v)
    out[0, first], out[1, first] = q, v
    for i in range(first, last):
        rise = (drive[i + 1] - drive[i]) / steps
        for k in range(steps):
            push = drive[i] + k * rise
            step = Step(step_s / steps, push, push + rise, i + k / steps, i + (k + 1.0) / steps)
            q, v, sign = advance(q, v, sign, step, bent, tables)
        out[0, i + 1], out[1, i + 1] = q, v


@compiled()
def run_pieces(
    step_s: float,
    drive: Float,
    q: Float,
    dq: Float,
    pieces: NDArray[np.int64],
    bent: Float,
    tables: Tables,
) -> Float:
    """Move the joint through pieces of a recording, each from the recorded start; see ``run``.

    Args:
        step_s: Spacing of the samples. [s]
        drive: Torque, shape (n,). [N m]
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
        run(step_s, drive, (q[first], dq[first]), first, last, bent[first].copy(), tables, out)
    return out
