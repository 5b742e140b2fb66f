"""A joint of any terms moved forward under a recorded torque, piece by piece, each from its recorded start.

Torques that follow from the instant are tabulated, bristles follow their curve (``tables``). A term that needs the
past of the motion is asked for its torque along the motion found so far, and the motion is found again, until it no
longer changes; a term with which it never settles cannot be simulated.

What sits between the torque sensor and the side on which friction acts does not change that side's motion under a
measured torque; it changes what is measured. A delay of the torque is undone in the drive. A spring puts the measured
side ahead by torque times compliance. Within a play the torque is zero and does not tell where the measured side is:
that is taken from the recording, the other side at rest until a flank takes it along.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import FittedTerm, JointModel
from friction_audit.model.move import run_pieces
from friction_audit.model.tables import Tables, certain, tabulate
from friction_audit.model.term import Motion

SWEEPS = 12
SETTLED = 1e-3
"""Change of the velocity in a sweep at which it has settled, as a share of the velocity."""
RUNAWAY = 100.0
"""A velocity of so many times the largest recorded one is no result."""
LEAST_INERTIA = 1e-3
"""Share of the joint's inertia that terms must leave."""
SOFT = "soft_nm"
"""Ending of the name of a spring's parameter: torque up to which it is half as stiff."""
BETWEEN = ("delay", "spring", "play")
"""What is between the sensor and the side of friction."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Reading:
    """How the measured side differs from the side on which friction acts; shape (n,) each.

    Attributes:
        drive: Torque that drives the side of friction, at its time. [N m]
        ahead: By how much the measured side is ahead. [rad]
    """

    drive: Float
    ahead: Float


def simulate_along(model: JointModel, motion: Motion, drive: Float, pieces: NDArray[np.int64]) -> Float | None:
    """Simulate a joint under a recorded torque.

    Args:
        model: The joint.
        motion: The recording, on an even grid, n samples.
        drive: Torque F_m + u as recorded, shape (n,). [N m]
        pieces: First and last sample of each piece, shape (p, 2).

    Returns:
        Velocity on the measured side, shape (n,) [rad/s]: NaN outside of the pieces; None where it does not settle or
        grows beyond all bounds.
    """
    reading = _read_through(model, motion, drive)
    step = float(motion.t[1] - motion.t[0])
    inner = _inner(motion, reading, step)
    acting = [term for term in model.terms if term.term.forward not in BETWEEN]
    tables, past = tabulate(model.inertia_kg_m2, acting, replace(inner, rest=model.rest(inner)))
    if tables.inertia_kg_m2 <= LEAST_INERTIA * abs(model.inertia_kg_m2):
        return None
    bent = tables.bristles.states_along(inner.q)
    found = _settle(model, tables, past, inner, reading.drive, pieces, bent, step)
    return None if found is None else np.asarray(found + np.gradient(reading.ahead, step))


def _settle(
    model: JointModel,
    tables: Tables,
    past: Sequence[FittedTerm],
    recorded: Motion,
    drive: Float,
    pieces: NDArray[np.int64],
    bent: Float,
    step: float,
) -> Float | None:
    """Sweep until the motion and the torque of terms with a past fit each other; return the velocity."""
    motion, last = recorded, recorded.dq
    inside = _inside(pieces, len(drive))
    for _ in range(SWEEPS):
        found = run_pieces(step, drive, recorded.q, recorded.dq, pieces, bent, _with_past(tables, past, model, motion))
        velocity = found[1]
        if not (np.abs(velocity[inside]) <= RUNAWAY * np.max(np.abs(recorded.dq))).all():
            return None
        if not past or _rms(velocity[inside] - last[inside]) <= SETTLED * _rms(recorded.dq[inside]):
            return np.asarray(velocity)
        motion, last = _spliced(recorded, found, inside, pieces, step), velocity
    return None


def _with_past(tables: Tables, past: Sequence[FittedTerm], model: JointModel, motion: Motion) -> Tables:
    """Add the torque of terms with a past along a motion."""
    known = replace(motion, rest=model.rest(motion))
    for term in past:
        tables = tables._replace(time=tables.time + _ways(term.torque(known), certain(motion), motion.t))
    return tables


def _ways(torque: Float, way: Float, t: Float) -> Float:
    """Torque forwards and backwards, shape (2, n): against the motion or whatever the motion, what jumps less.

    Friction jumps where the direction turns; its level against the motion does not. What is not known where no
    direction is certain is read between.
    """
    sure = way != 0.0
    if not sure.any():
        return np.stack([torque, torque])
    level = np.interp(t, t[sure], (torque * way)[sure])
    turns = np.abs(np.diff(torque[sure])).sum() > np.abs(np.diff((torque * way)[sure])).sum()
    return np.stack([level, -level] if turns else [torque, torque])


def _spliced(
    recorded: Motion, found: Float, inside: NDArray[np.bool_], pieces: NDArray[np.int64], step: float
) -> Motion:
    """Put simulated pieces into a recording."""
    ddq = recorded.ddq.copy()
    for first, last in pieces:
        ddq[first : last + 1] = np.gradient(found[1, first : last + 1], step)
    q, dq = np.where(inside, found[0], recorded.q), np.where(inside, found[1], recorded.dq)
    return replace(recorded, q=q, dq=dq, ddq=ddq)


def _inside(pieces: NDArray[np.int64], samples: int) -> NDArray[np.bool_]:
    inside = np.zeros(samples, bool)
    for first, last in pieces:
        inside[first : last + 1] = True
    return inside


def _rms(signal: Float) -> float:
    return float(np.sqrt(np.mean(signal**2))) if len(signal) else 0.0


def _read_through(model: JointModel, motion: Motion, drive: Float) -> _Reading:
    """Undo what is between the sensor and the side of friction."""
    between = {term.term.forward: term for term in model.terms if term.term.forward in BETWEEN}
    if "delay" in between:
        drive = _undelayed(between["delay"], motion, drive)
    ahead = np.zeros(len(drive))
    if "spring" in between:
        ahead = ahead + _twist(between["spring"], drive)
    if "play" in between:
        ahead = ahead + _within(np.ascontiguousarray(motion.q), 0.5 * _parameter(between["play"], "_rad"))
    return _Reading(drive=drive, ahead=ahead)


def _twist(term: FittedTerm, drive: Float) -> Float:
    """By how far a spring is twisted: in proportion, and twice as far up to the torque at which it stiffens. [rad]"""
    soft = _parameter(term, SOFT) if any(p.name.endswith(SOFT) for p in term.term.parameters) else 0.0
    size = np.abs(drive)
    twist = _parameter(term, "_rad_per_nm") * np.minimum(2.0 * size, size + soft)
    return np.asarray(np.sign(drive) * twist)


def _undelayed(term: FittedTerm, motion: Motion, drive: Float) -> Float:
    """The torque at its time; of a load that is late too, what was taken away too early is given back."""
    load = np.zeros(len(drive)) if motion.load is None else motion.load * round(_parameter(term, "delayed_load"))
    return np.asarray(np.interp(motion.t + _delay(term, motion), motion.t, drive + load) - load)


def _delay(term: FittedTerm, motion: Motion) -> float:
    """By how much the torque is late: what becomes of one that rises by 1 N m/s. [s]"""
    still = np.zeros(len(motion.t))
    rising = replace(motion, dq=still, ddq=still, rest=motion.t - motion.t[0], load=None)
    return -float(np.median(term.torque(rising)))


def _parameter(term: FittedTerm, ending: str) -> float:
    """Return the one parameter of a term whose name has an ending.

    Raises:
        AnalysisError: If there is none, or more than one.
    """
    pairs = zip(term.term.parameters, term.values, strict=True)
    values = [value for parameter, value in pairs if parameter.name.endswith(ending)]
    if len(values) != 1:
        raise AnalysisError(
            f"term {term.name}: {len(values)} parameters end on {ending}; expected one, for it is a {term.term.forward}"
        )
    return values[0]


@compiled()
def _within(q: Float, half: float) -> Float:
    """By how much the measured side is ahead of a side that friction holds until a flank takes it along."""
    ahead = np.zeros(len(q))
    for i in range(1, len(q)):
        ahead[i] = min(half, max(-half, ahead[i - 1] + q[i] - q[i - 1]))
    return ahead


def _inner(motion: Motion, reading: _Reading, step: float) -> Motion:
    """The recorded motion of the side on which friction acts."""
    if not reading.ahead.any():
        return motion
    ahead_dq = np.gradient(reading.ahead, step)
    return replace(
        motion,
        q=motion.q - reading.ahead,
        dq=motion.dq - ahead_dq,
        ddq=motion.ddq - np.gradient(ahead_dq, step),
    )
