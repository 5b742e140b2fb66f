"""Lookup tables of the torque of model terms, with linear interpolation, for the compiled forward simulation.

A term gives the torque along a whole motion; the integrator needs it at one instant. Each term is therefore evaluated
on motions that vary one quantity, and tabulated over speed, position or time, for each direction. A term whose table
does not reproduce its torque along the recorded motion has memory. It is not tabulated but returned to the caller.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.bristles import NO_BRISTLES, Bristles, fit_bristles
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.joint_log import Float, read_only

CRAWL_RAD_S = 1e-9  # replaces zero speed, where a term has no direction
HEADROOM = 1.5  # speeds are tabulated up to this multiple of the largest one of the recording
MARGIN, LEAST_MARGIN_RAD = 0.25, 0.05  # positions beyond the recorded range, as a share of it and at least
TOLERANCE = 0.02  # largest rms error of tables along the recording, as a share of the term's torque
BRISTLE_TOLERANCE = 0.05  # the same for bristles, whose displacement between samples is unknown
ROUNDING_NM = 1e-6
SLOW = 1e-3  # below this share of the largest speed the direction of a recorded motion is uncertain

LONGEST_STEP_S = 5e-4
STEP_PHASE_RAD = 0.2  # longest step times the angular frequency of the inertia on its largest stiffness [rad]
MOST_STEPS = 200  # per sample of the recording


class Tables(NamedTuple):
    """Resisting torque of a joint, one row forwards, one backwards; ``per_speed`` ones are multiplied by the speed."""

    inertia_kg_m2: float  # inertia [kg m^2]
    speed_step: float  # spacing of the table over speed, which starts at 0 [rad/s]
    speed: Float  # torque over speed, shape (2, n) [N m]
    position_start: float  # first position of the tables over it [rad]
    position_step: float  # spacing of the tables over position [rad]
    position: Float  # torque over position, shape (2, n) [N m]
    position_per_speed: Float  # shape (2, n) [N m s/rad]
    time: Float  # torque at the samples of the recording, shape (2, n) [N m]
    time_per_speed: Float  # shape (2, n) [N m s/rad]
    bristles: Bristles


ADDED = ("inertia_kg_m2", "speed", "position", "position_per_speed", "time", "time_per_speed")


def tabulate(inertia_kg_m2: float, terms: Iterable[Term], motion: Motion) -> tuple[Tables, tuple[Term, ...]]:
    """Tabulate terms along an evenly sampled recording; return also the terms with memory, which no table holds."""
    n, constant = len(motion.t), np.zeros((2, 1))  # a table of one entry is constant
    top = HEADROOM * max(float(np.max(np.abs(motion.dq), initial=0.0)), CRAWL_RAD_S)
    low, high = float(motion.q.min()), float(motion.q.max())
    margin = max(MARGIN * (high - low), LEAST_MARGIN_RAD)
    steps: dict[str, Any] = {"speed_step": top / (n - 1), "position_step": (high - low + 2.0 * margin) / (n - 1)}
    torques: dict[str, Any] = dict.fromkeys(ADDED[2:], constant) | {"speed": np.zeros((2, n)), "bristles": NO_BRISTLES}
    empty = Tables(inertia_kg_m2=0.0, position_start=low - margin, **steps, **torques)
    tables, with_memory = empty._replace(inertia_kg_m2=inertia_kg_m2), []
    for term in terms:
        # The first table that reproduces the term is taken: over speed, then position, then time.
        candidates = _candidates(term, motion, empty)
        if term.effect.forward == "bristle":  # Dahl, then Maxwell-slip, with the Coulomb friction that they replace
            dry, *models = fit_bristles(term)
            candidates = (empty._replace(speed=np.array([[dry], [-dry]]), bristles=model) for model in models)
        added = next((one for one in candidates if _reproduces(one, term, motion)), None)
        used = [one.bristles for one in (added, tables) if one and len(one.bristles.path) + len(one.bristles.stiffness)]
        if added is None or len(used) > 1:
            with_memory.append(term)
        else:
            sums: dict[str, Any] = {name: getattr(tables, name) + getattr(added, name) for name in ADDED}
            tables = tables._replace(**sums, bristles=used[0] if used else NO_BRISTLES)
    return tables, tuple(with_memory)


def certain_direction(motion: Motion) -> Float:
    """Return the direction of a recorded motion: -1, 1, or 0 where it is uncertain, shape (n,)."""
    return np.where(np.abs(motion.dq) > SLOW * np.max(np.abs(motion.dq), initial=0.0), np.sign(motion.dq), 0.0)


def _reproduces(tables: Tables, term: Term, motion: Motion) -> bool:
    """Whether the tables of a term give its torque along the recording, where the direction is certain."""
    elastic = tables.bristles.torque_along(motion.q)
    found = tables.inertia_kg_m2 * motion.ddq + lookup_along(read_only(motion.q), read_only(motion.dq), tables)
    found = found + (elastic + tables.bristles.damping_s * np.gradient(elastic, motion.t))
    sure, torque = certain_direction(motion) != 0.0, term.torque(motion)
    allowed = BRISTLE_TOLERANCE if term.effect.forward == "bristle" else TOLERANCE
    return bool(rms((torque - found)[sure]) <= allowed * rms(torque[sure]) + ROUNDING_NM)


def rms(signal: Float) -> float:
    """Return the root mean square of a signal, 0 for an empty one."""
    return float(np.sqrt(np.mean(signal**2))) if len(signal) else 0.0


def _candidates(term: Term, motion: Motion, empty: Tables) -> Iterable[Tables]:
    """Yield tables of a term over speed, position and time, with its inertia; they are wrong for one with memory."""
    n = len(motion.t)
    still, top = np.zeros(n), empty.speed_step * (n - 1)

    def torque_at(speed: float | Float, motion: Motion) -> Float:
        with np.errstate(all="ignore"):
            return np.stack([term.torque(replace(motion, dq=sign * speed + still)) for sign in (1.0, -1.0)])

    with np.errstate(all="ignore"):
        more = term.torque(replace(motion, ddq=motion.ddq + 1.0))
    empty = empty._replace(inertia_kg_m2=float(np.mean(more - term.torque(motion))))
    speeds = np.asarray(empty.speed_step * np.arange(n), np.float64)
    speeds[0] = min(CRAWL_RAD_S, 0.5 * empty.speed_step)
    unmoved = replace(motion, ddq=still)
    yield empty._replace(speed=torque_at(speeds, replace(unmoved, q=np.full(n, float(np.median(motion.q))))))
    positions = np.asarray(empty.position_start + empty.position_step * np.arange(n), np.float64)
    for over, along in (("position", replace(unmoved, q=positions)), ("time", unmoved)):
        level, moving = torque_at(CRAWL_RAD_S, along), torque_at(0.5 * top, along)
        filled: dict[str, Any] = {over: level, f"{over}_per_speed": (moving - level) / (0.5 * top)}
        yield empty._replace(**filled)


@compiled(inline=True)
def interpolate(table: Float, row: int, entry: float) -> float:
    """Interpolate a row of a table linearly, constant beyond its ends. (Slicing the row would take as long again.)"""
    last = table.shape[1] - 1
    if last == 0:
        return float(table[row, 0])
    entry = min(max(entry, 0.0), float(last))
    low = min(int(entry), last - 1)
    return float(table[row, low] + (entry - low) * (table[row, low + 1] - table[row, low]))


@compiled()
def lookup_nm(sign: float, q: float, speed: float, sample: float, tables: Tables) -> float:
    """Return the resisting torque without bristles, forwards (1.0) or backwards, at a sample. [N m]"""
    row = 0 if sign > 0.0 else 1
    entry = (q - tables.position_start) / tables.position_step
    per_speed = interpolate(tables.position_per_speed, row, entry) + interpolate(tables.time_per_speed, row, sample)
    torque = interpolate(tables.speed, row, speed / tables.speed_step) + interpolate(tables.position, row, entry)
    return torque + interpolate(tables.time, row, sample) + per_speed * speed


@compiled()
def lookup_along(q: Float, dq: Float, tables: Tables) -> Float:
    """Return the resisting torque without bristles at every sample of the recording, shape (n,). [N m]"""
    out = np.empty(len(q))
    for i in range(len(q)):
        out[i] = lookup_nm(-1.0 if dq[i] < 0.0 else 1.0, q[i], abs(dq[i]), float(i), tables)
    return out


def steps_per_sample(step_s: float, tables: Tables) -> int:
    """Return the integration steps per sample of the recording; the stiffest spring decides."""
    drops = -np.diff(tables.bristles.torque) / np.diff(tables.bristles.path)
    stiffness = np.max(drops, initial=np.sum(tables.bristles.stiffness))
    steepest = np.max(np.abs(np.diff(tables.position)) / tables.position_step, initial=0.0)
    frequency = np.sqrt((stiffness + steepest) / tables.inertia_kg_m2)
    longest = min(LONGEST_STEP_S, STEP_PHASE_RAD / max(frequency, 1e-9))
    return max(1, min(MOST_STEPS, int(np.ceil(step_s / longest - 1e-6))))
