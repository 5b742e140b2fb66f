"""Tables of what the terms of a joint take along a recording, as the compiled forward simulation reads them.

A term says what torque a motion takes; a simulation asks at every step what is taken here, now, at this speed. The
terms are therefore asked for motions that vary one thing at a time, and the answers are kept as tables over speed, over
place or over time, for each direction. Where a table, read along the recorded motion, does not give what the term gives
there, the term follows from more than the instant: it is left to the caller.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from friction_audit.dynamics.bristles import NO_BRISTLES, Bristles, bristles_of
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.joint_log import Float

CRAWL_RAD_S = 1e-9
"""Speed that stands for the limit at rest."""
HEADROOM = 1.5
"""Speeds are tabulated up to so many times the largest of the recording."""
MARGIN = 0.25
"""Places are tabulated so much of the recorded range beyond its ends."""
LEAST_MARGIN_RAD = 0.05
TOLERANCE = 0.02
"""Largest error of tables along the recording, as a share of the term's torque."""
BRISTLE_TOLERANCE = 0.05
"""The same of bristles, whose path the samples of a recording do not show between them."""
ROUNDING_NM = 1e-6
SLOW = 1e-3
"""Below this share of the largest speed a recorded motion has no certain direction."""


class Tables(NamedTuple):
    """Torque that a joint takes, against the drive, signed; n samples of a recording.

    Tables have one row per direction, forwards and backwards; those ``per_speed`` are multiplied by the speed.

    Attributes:
        inertia_kg_m2: Inertia.
        speed_step: Spacing of the table over speed, which begins at rest. [rad/s]
        speed: Torque over speed, shape (2, n). [N m]
        place_start: First place of the tables over it. [rad]
        place_step: Their spacing. [rad]
        place: Torque over place, shape (2, n). [N m]
        place_per_speed: Shape (2, n). [N m s/rad]
        time: Torque at the stamps of the recording, shape (2, n). [N m]
        time_per_speed: Shape (2, n). [N m s/rad]
        bristle_path: Path of the curve of the bristles, shape (k,). [rad]
        bristle_torque: Torque of that curve. [N m]
        spring_stiffness: Stiffness of bristles that are springs, shape (m,). [N m/rad]
        spring_reach: Deflection at which each slips, shape (m,). [rad]
        bristle_damping_s: Damping of the bristles over their stiffness. [s]
    """

    inertia_kg_m2: float
    speed_step: float
    speed: Float
    place_start: float
    place_step: float
    place: Float
    place_per_speed: Float
    time: Float
    time_per_speed: Float
    bristle_path: Float
    bristle_torque: Float
    spring_stiffness: Float
    spring_reach: Float
    bristle_damping_s: float

    @property
    def bristles(self) -> Bristles:
        """The bristles."""
        return Bristles(
            path=self.bristle_path,
            torque=self.bristle_torque,
            stiffness=self.spring_stiffness,
            reach=self.spring_reach,
            damping_s=self.bristle_damping_s,
        )


def tabulate(inertia_kg_m2: float, terms: Iterable[Term], motion: Motion) -> tuple[Tables, tuple[Term, ...]]:
    """Tabulate the terms of a joint.

    Args:
        inertia_kg_m2: Its inertia.
        terms: Terms that act by a torque, instantly or by bristles.
        motion: The recording, on an even grid.

    Returns:
        The tables, and the terms that no table holds; second bristles are among them.
    """
    tables, past = _empty(motion)._replace(inertia_kg_m2=inertia_kg_m2), []
    for term in terms:
        forms = BRISTLE_FORMS if term.effect.forward == "bristle" else FORMS
        share = next((share for form in forms if _holds(share := form(term, motion), term, motion)), None)
        if share is None or (share.bristles.some and tables.bristles.some):
            past.append(term)
        else:
            tables = _add(tables, share)
    return tables, tuple(past)


def certain(motion: Motion) -> Float:
    """Direction of a recorded motion: -1, 1, or 0 where it is not certain, shape (n,)."""
    return np.where(np.abs(motion.dq) > SLOW * np.max(np.abs(motion.dq), initial=0.0), np.sign(motion.dq), 0.0)


def _empty(motion: Motion) -> Tables:
    n = len(motion.t)
    top = HEADROOM * max(float(np.max(np.abs(motion.dq), initial=0.0)), CRAWL_RAD_S)
    low, high = float(motion.q.min()), float(motion.q.max())
    margin = max(MARGIN * (high - low), LEAST_MARGIN_RAD)
    still = np.zeros((2, n))
    return Tables(
        inertia_kg_m2=0.0,
        speed_step=top / (n - 1),
        speed=still,
        place_start=low - margin,
        place_step=(high - low + 2.0 * margin) / (n - 1),
        place=still,
        place_per_speed=still,
        time=still,
        time_per_speed=still,
        bristle_path=NO_BRISTLES.path,
        bristle_torque=NO_BRISTLES.torque,
        spring_stiffness=NO_BRISTLES.stiffness,
        spring_reach=NO_BRISTLES.reach,
        bristle_damping_s=NO_BRISTLES.damping_s,
    )


def _add(one: Tables, other: Tables) -> Tables:
    return one._replace(
        inertia_kg_m2=one.inertia_kg_m2 + other.inertia_kg_m2,
        speed=one.speed + other.speed,
        place=one.place + other.place,
        place_per_speed=one.place_per_speed + other.place_per_speed,
        time=one.time + other.time,
        time_per_speed=one.time_per_speed + other.time_per_speed,
        bristle_path=np.append(one.bristle_path, other.bristle_path),
        bristle_torque=np.append(one.bristle_torque, other.bristle_torque),
        spring_stiffness=np.append(one.spring_stiffness, other.spring_stiffness),
        spring_reach=np.append(one.spring_reach, other.spring_reach),
        bristle_damping_s=one.bristle_damping_s + other.bristle_damping_s,
    )


def _holds(share: Tables, term: Term, motion: Motion) -> bool:
    """Whether the tables of a term give its torque along the recording, wherever the direction is certain."""
    sure = certain(motion) != 0.0
    torque = term.torque(motion)
    error = (torque - read_along(share, motion))[sure]
    allowed = BRISTLE_TOLERANCE if term.effect.forward == "bristle" else TOLERANCE
    return bool(_rms(error) <= allowed * _rms(torque[sure]) + ROUNDING_NM)


def read_along(tables: Tables, motion: Motion) -> Float:
    """Read tables along the recording that they were made from: the torque it takes, shape (n,). [N m]"""
    speed = np.abs(motion.dq)
    at_speed, at_place = speed / tables.speed_step, (motion.q - tables.place_start) / tables.place_step
    held = tables.bristles.along(motion.q)
    held = held + tables.bristle_damping_s * np.gradient(held, motion.t)
    ways = [
        _read(tables.speed[way], at_speed)
        + _read(tables.place[way], at_place)
        + _read(tables.place_per_speed[way], at_place) * speed
        + tables.time[way]
        + tables.time_per_speed[way] * speed
        for way in (0, 1)
    ]
    return np.asarray(tables.inertia_kg_m2 * motion.ddq + np.where(motion.dq < 0.0, ways[1], ways[0]) + held)


def _read(table: Float, at: Float) -> Float:
    """Read a table at steps from its first entry; most are zero, and need no reading."""
    if not table.any():
        return table
    first = np.clip(at.astype(np.int64), 0, len(table) - 2)
    low, high = table[first], table[first + 1]
    with np.errstate(all="ignore"):  # entries of a form that does not fit may be nonsense
        return np.asarray(low + np.clip(at - first, 0.0, 1.0) * (high - low))


def _rms(signal: Float) -> float:
    return float(np.sqrt(np.mean(signal**2))) if len(signal) else 0.0


def _asked(term: Term, motion: Motion) -> Float:
    """A term's torque for a motion that nobody made; nonsense, if the term needs the past, is found out later."""
    with np.errstate(all="ignore"):
        return term.torque(motion)


def _speed_form(term: Term, motion: Motion) -> Tables:
    """Torque over speed at one place, and the inertia that the term adds."""
    empty = _empty(motion)
    speeds = np.asarray(empty.speed_step * np.arange(len(motion.t)), np.float64)
    speeds[0] = min(CRAWL_RAD_S, 0.5 * empty.speed_step)
    still = replace(motion, q=np.full(len(speeds), float(np.median(motion.q))), ddq=np.zeros(len(speeds)))
    table = np.stack([_asked(term, replace(still, dq=sign * speeds)) for sign in (1.0, -1.0)])
    return empty._replace(inertia_kg_m2=_inertia(term, motion), speed=table)


def _place_form(term: Term, motion: Motion) -> Tables:
    """Torque over place, with a share in proportion to the speed."""
    empty = _empty(motion)
    places = np.asarray(empty.place_start + empty.place_step * np.arange(len(motion.t)), np.float64)
    level, slope = _affine(term, replace(motion, q=places), empty)
    return empty._replace(inertia_kg_m2=_inertia(term, motion), place=level, place_per_speed=slope)


def _time_form(term: Term, motion: Motion) -> Tables:
    """Torque over time with all else as recorded, with a share in proportion to the speed."""
    empty = _empty(motion)
    level, slope = _affine(term, motion, empty)
    return empty._replace(inertia_kg_m2=_inertia(term, motion), time=level, time_per_speed=slope)


def _dahl_form(term: Term, motion: Motion) -> Tables:
    """Bristles in Dahl's picture, and the dry friction whose place they take."""
    dry, dahl, _ = bristles_of(term)
    return _with_bristles(dry, dahl, motion)


def _spring_form(term: Term, motion: Motion) -> Tables:
    """Bristles as springs, and the dry friction whose place they take."""
    dry, _, springs = bristles_of(term)
    return _with_bristles(dry, springs, motion)


def _with_bristles(dry: float, found: Bristles, motion: Motion) -> Tables:
    return _empty(motion)._replace(
        speed=np.repeat(np.array([[dry], [-dry]]), len(motion.t), axis=1),
        bristle_path=found.path,
        bristle_torque=found.torque,
        spring_stiffness=found.stiffness,
        spring_reach=found.reach,
        bristle_damping_s=found.damping_s,
    )


FORMS: tuple[Callable[[Term, Motion], Tables], ...] = (_speed_form, _place_form, _time_form)
"""In the order in which they are tried: the fewer a recorded quantity is needed for, the better."""

BRISTLE_FORMS = (_dahl_form, _spring_form)


def _affine(term: Term, motion: Motion, empty: Tables) -> tuple[Float, Float]:
    """Torque in the limit at rest, and its slope in the speed, by direction, shape (2, n) each."""
    n = len(motion.t)
    fast = 0.5 * empty.speed_step * (n - 1)
    still = np.zeros(n)
    ways = (1.0, -1.0)
    level = np.stack([_asked(term, replace(motion, dq=np.full(n, w * CRAWL_RAD_S), ddq=still)) for w in ways])
    moving = np.stack([_asked(term, replace(motion, dq=np.full(n, w * fast), ddq=still)) for w in ways])
    return level, (moving - level) / fast


def _inertia(term: Term, motion: Motion) -> float:
    """Inertia that a term adds: what it takes for one more rad/s^2, on average."""
    return float(np.mean(_asked(term, replace(motion, ddq=motion.ddq + 1.0)) - term.torque(motion)))
