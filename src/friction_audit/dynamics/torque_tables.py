"""Tables of what the terms of a joint take along a recording, as the compiled forward simulation reads them.

A term says what torque a motion takes; a simulation asks at every step what is taken here, now, at this speed. The
terms are therefore asked for motions that vary one quantity at a time, and the answers are kept as tables over speed,
position or time, for each direction. Where a table, read along the recorded motion, does not give what the term gives
there, the term follows from more than the instant: it is left to the caller.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.bristles import NO_BRISTLES, Bristles, bristles_of
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.joint_log import Float, read_only

CRAWL_RAD_S = 1e-9  # stands for the limit at zero speed
HEADROOM = 1.5  # speeds are tabulated up to this multiple of the largest one of the recording
MARGIN, LEAST_MARGIN_RAD = 0.25, 0.05  # positions beyond the recorded range, as a share of it and at least
TOLERANCE = 0.02  # largest rms error of tables along the recording, as a share of the term's torque
BRISTLE_TOLERANCE = 0.05  # the same of bristles, whose path between samples is not known
ROUNDING_NM = 1e-6
SLOW = 1e-3  # below this share of the largest speed a recorded motion has no certain direction

LONGEST_STEP_S = 5e-4
SHARE_OF_SWING = 0.2  # longest step over 1 / the angular frequency at which the joint swings on its stiffest torque
MOST_STEPS = 200  # per sample of the recording


class Tables(NamedTuple):
    """Torque that a joint takes, one row forwards, one backwards; what is ``per_speed`` is multiplied by the speed."""

    inertia_kg_m2: float  # inertia
    speed_step: float  # spacing of the table over speed, which begins at rest [rad/s]
    speed: Float  # torque over speed, shape (2, n) [N m]
    position_start: float  # first position of the tables over it [rad]
    position_step: float  # their spacing [rad]
    position: Float  # torque over position, shape (2, n) [N m]
    position_per_speed: Float  # shape (2, n) [N m s/rad]
    time: Float  # torque at the stamps of the recording, shape (2, n) [N m]
    time_per_speed: Float  # shape (2, n) [N m s/rad]
    bristles: Bristles


ADDED = ("inertia_kg_m2", "speed", "position", "position_per_speed", "time", "time_per_speed")


def tabulate(inertia_kg_m2: float, terms: Iterable[Term], motion: Motion) -> tuple[Tables, tuple[Term, ...]]:
    """Tabulate the terms that act by a torque along an even recording; return also those that no table holds."""
    n, nothing = len(motion.t), np.zeros((2, 1))  # a table of one entry is level
    top = HEADROOM * max(float(np.max(np.abs(motion.dq), initial=0.0)), CRAWL_RAD_S)
    low, high = float(motion.q.min()), float(motion.q.max())
    margin = max(MARGIN * (high - low), LEAST_MARGIN_RAD)
    steps: dict[str, Any] = {"speed_step": top / (n - 1), "position_step": (high - low + 2.0 * margin) / (n - 1)}
    torques: dict[str, Any] = dict.fromkeys(ADDED[2:], nothing) | {"speed": np.zeros((2, n)), "bristles": NO_BRISTLES}
    empty = Tables(inertia_kg_m2=0.0, position_start=low - margin, **steps, **torques)
    tables, past = empty._replace(inertia_kg_m2=inertia_kg_m2), []
    for term in terms:
        # The fewer a recorded quantity is needed for, the better: speed, then position, then time.
        forms = _forms(term, motion, empty)
        if term.effect.forward == "bristle":  # one curve, or springs, with the dry friction whose place they take
            dry, *both = bristles_of(term)
            forms = (empty._replace(speed=np.array([[dry], [-dry]]), bristles=found) for found in both)
        share = next((share for share in forms if _holds(share, term, motion)), None)
        bent = [one.bristles for one in (share, tables) if one and len(one.bristles.path) + len(one.bristles.reach)]
        if share is None or len(bent) > 1:
            past.append(term)
        else:
            added: dict[str, Any] = {name: getattr(tables, name) + getattr(share, name) for name in ADDED}
            tables = tables._replace(**added, bristles=bent[0] if bent else NO_BRISTLES)
    return tables, tuple(past)


def certain(motion: Motion) -> Float:
    """Direction of a recorded motion: -1, 1, or 0 where it is not certain, shape (n,)."""
    return np.where(np.abs(motion.dq) > SLOW * np.max(np.abs(motion.dq), initial=0.0), np.sign(motion.dq), 0.0)


def _holds(share: Tables, term: Term, motion: Motion) -> bool:
    """Whether the tables of a term give its torque along the recording, where the direction is certain."""
    held = share.bristles.along(motion.q)
    held = held + share.bristles.damping_s * np.gradient(held, motion.t)
    found = share.inertia_kg_m2 * motion.ddq + taken_along(read_only(motion.q), read_only(motion.dq), share) + held
    sure, torque = certain(motion) != 0.0, term.torque(motion)
    allowed = BRISTLE_TOLERANCE if term.effect.forward == "bristle" else TOLERANCE
    return bool(rms((torque - found)[sure]) <= allowed * rms(torque[sure]) + ROUNDING_NM)


def rms(signal: Float) -> float:
    """Return the root of the mean square of a signal, 0 of none."""
    return float(np.sqrt(np.mean(signal**2))) if len(signal) else 0.0


def _forms(term: Term, motion: Motion, empty: Tables) -> Iterable[Tables]:
    """Yield a term over speed, position and time, with its inertia: nonsense for a term that needs the past."""
    n = len(motion.t)
    still, top = np.zeros(n), empty.speed_step * (n - 1)

    def ask(speed: float | Float, motion: Motion) -> Float:
        with np.errstate(all="ignore"):
            return np.stack([term.torque(replace(motion, dq=sign * speed + still)) for sign in (1.0, -1.0)])

    with np.errstate(all="ignore"):
        more = term.torque(replace(motion, ddq=motion.ddq + 1.0))
    empty = empty._replace(inertia_kg_m2=float(np.mean(more - term.torque(motion))))
    speeds = np.asarray(empty.speed_step * np.arange(n), np.float64)
    speeds[0] = min(CRAWL_RAD_S, 0.5 * empty.speed_step)
    unmoved = replace(motion, ddq=still)
    yield empty._replace(speed=ask(speeds, replace(unmoved, q=np.full(n, float(np.median(motion.q))))))
    positions = np.asarray(empty.position_start + empty.position_step * np.arange(n), np.float64)
    for over, along in (("position", replace(unmoved, q=positions)), ("time", unmoved)):
        level, moving = ask(CRAWL_RAD_S, along), ask(0.5 * top, along)
        shares: dict[str, Any] = {over: level, f"{over}_per_speed": (moving - level) / (0.5 * top)}
        yield empty._replace(**shares)


@compiled(inline=True)
def read(table: Float, row: int, entry: float) -> float:
    """Read a row of a table between its entries; level beyond its ends. (A row by itself costs as much as reading.)"""
    last = table.shape[1] - 1
    if last == 0:
        return float(table[row, 0])
    entry = min(max(entry, 0.0), float(last))
    low = min(int(entry), last - 1)
    return float(table[row, low] + (entry - low) * (table[row, low + 1] - table[row, low]))


@compiled()
def taken(sign: float, q: float, speed: float, sample: float, tables: Tables) -> float:
    """Return what a joint takes without its bristles, forwards (1.0) or backwards, at a sample of the recording."""
    row = 0 if sign > 0.0 else 1
    entry = (q - tables.position_start) / tables.position_step
    per_speed = read(tables.position_per_speed, row, entry) + read(tables.time_per_speed, row, sample)
    torque = read(tables.speed, row, speed / tables.speed_step) + read(tables.position, row, entry)
    return torque + read(tables.time, row, sample) + per_speed * speed


@compiled()
def taken_along(q: Float, dq: Float, tables: Tables) -> Float:
    """Return what a joint takes without its bristles at every sample of the recording, shape (n,)."""
    out = np.empty(len(q))
    for i in range(len(q)):
        out[i] = taken(-1.0 if dq[i] < 0.0 else 1.0, q[i], abs(dq[i]), float(i), tables)
    return out


def steps_per_sample(step_s: float, tables: Tables) -> int:
    """Return how many steps a sample of the recording takes, so that no spring is too stiff for them."""
    drops = -np.diff(tables.bristles.torque) / np.diff(tables.bristles.path)
    stiffness = np.max(drops, initial=np.sum(tables.bristles.stiffness))
    steepest = np.max(np.abs(np.diff(tables.position)) / tables.position_step, initial=0.0)
    swing = np.sqrt((stiffness + steepest) / tables.inertia_kg_m2)
    longest = min(LONGEST_STEP_S, SHARE_OF_SWING / max(swing, 1e-9))
    return max(1, min(MOST_STEPS, int(np.ceil(step_s / longest - 1e-6))))
