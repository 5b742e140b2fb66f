"""Sessions (what one recording says of the friction of one arm), their order, and series of a coefficient over them."""

import re
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.interaction import Caution, Reason

COEFFICIENTS = ("coulomb_nm", "viscous_nms_per_rad")
NORMAL_95 = 1.959964  # half of a 95 % interval, in standard errors
LARGEST_RELATIVE_ERROR = 0.25  # less certain estimates are too skewed for a logarithm
SECONDS_A_DAY = 86400.0
LOST_JOINT = "empty_joint"  # code of a log that has a joint less than its arm: a channel of the joint holds no number
# A change of method from session to session would look like drift.
BY_REGRESSION: Reason = (Caution("by_regression"),)


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedCurve:
    """Torque against speed, the mean in bins of speed; kept as arrays, for a batch holds thousands of curves."""

    speed_rad_s: Sequence[float] = ()  # mean speed in each bin, rising, both directions [rad/s]
    torque_nm: Sequence[float] = ()  # mean interaction torque in it [N m]
    spread_nm: Sequence[float] = ()  # standard deviation of the torque in it [N m]

    def __post_init__(self) -> None:
        """Keep eight bytes a number."""
        for name in ("speed_rad_s", "torque_nm", "spread_nm"):
            object.__setattr__(self, name, array("d", getattr(self, name)))


@dataclass(frozen=True, kw_only=True, slots=True)
class JointSummary:
    """One joint in one session."""

    joint: int  # number for people, 1..n
    name: str  # name in the log
    coefficients: Mapping[str, Coefficient]  # estimates by ``COEFFICIENTS``; NaN where the log cannot give one
    cycles: int  # energy cycles that count
    moving_s: float  # time in motion [s]
    speed_rad_s: tuple[float, float, float]  # lower quartile, median and upper quartile of the speed in motion [rad/s]
    temperature_c: float | None = None  # mean of the logged temperature, or None [degC]
    # relative change of each from the first to the last third: warm-up, no drift; NaN where the session is too short
    within: Mapping[str, Coefficient] = field(default_factory=dict)
    curve: SpeedCurve = field(default_factory=SpeedCurve)  # torque against speed
    reason: Reason = ()  # why there is no estimate; empty if there is one
    verdict: str | None = None  # what ``diagnose`` says, or None if it was not asked
    effects: tuple[str, ...] = ()  # names of the effects that it found
    correlation: float | None = None  # between the errors of both coefficients, or None where it is not known


@dataclass(frozen=True, kw_only=True, slots=True)
class Conditions:
    """Under what a session was recorded and read; sessions that differ here are not compared silently."""

    drive: str  # ``"hand"`` or ``"robot"``
    torque: str  # channel that the interaction torque came from
    gravity: str  # where gravity came from
    inertia: str  # where the inertial torque came from
    payload: str = ""  # what the manifest says of the payload; empty if nothing
    rate_hz: float = 1000.0  # rate of the samples [Hz]


@dataclass(frozen=True, kw_only=True, slots=True)
class Session:
    """One recording of one arm."""

    path: str  # as found
    sha256: str  # content hash
    robot: str  # which arm, as distinguished by serial, namespace, manifest or folder; empty where nothing names it
    start_s: float | None  # Unix time of the start, or None where it is not known [s]
    duration_s: float  # length [s]
    conditions: Conditions  # under what it was recorded
    joints: tuple[JointSummary, ...]  # one summary per joint
    start_from: str = "nothing"  # ``"manifest"``, ``"log"``, ``"name"`` or ``"nothing"``, decided among all logs
    temperature_c: float | None = None  # from the manifest, or None [degC]
    note: str = ""  # from the manifest
    warnings: tuple[Caution, ...] = ()  # findings of the reader, quoted, and what was noticed of the torque
    codes: tuple[str, ...] = ()  # their codes, and those of what was noticed while the friction was estimated
    damaged: bool = False  # whether part of the file was left out
    topic: str = ""  # what ``--topic`` would have to say to read this arm of several; empty where the log holds one
    kind: str = "unknown"  # name of a preset, or ``"unknown"``
    named_by_serial: bool = False  # whether the log's name for the arm is a serial number, which no other arm has
    log_joints: int = 0  # number of joints of its log, also those that were not estimated
    torque_unit: str = "N m"  # or, of a motor current, ``"A"`` or ``"mA"``
    method: str = ""  # friction model and estimator


@dataclass(frozen=True, kw_only=True, slots=True)
class Order:
    """Sessions in order."""

    sessions: tuple[Session, ...]  # all of them
    by: str  # ``"start"`` or ``"name"``
    left_out: tuple[tuple[int, Reason], ...] = ()  # index and reason of each one that has no place among the others


def put_in_order(sessions: Sequence[Session]) -> Order:
    """Order the sessions of one arm; most have a start or their names have to tell."""
    named = sorted(sessions, key=lambda session: (natural(session.path), session.sha256))
    known = [session for session in named if session.start_s is not None]
    if 2 * len(known) <= len(named):
        return Order(sessions=tuple(named), by="name")
    known.sort(key=lambda session: session.start_s or 0.0)
    unknown = [session for session in named if session.start_s is None]
    left_out = tuple((len(known) + i, (Caution("no_start"),)) for i in range(len(unknown)))
    return Order(sessions=(*known, *unknown), by="start", left_out=left_out)


def restore_joints(sessions: Sequence[Session]) -> tuple[Session, ...]:
    """Return sessions; where a log lost joints, the others have their numbers in the whole logs of the same arm.

    A log has no joint whose channel holds no number. The names say which are left, if logs of one arm alone have them.
    """
    whole = {
        (one.log_joints, tuple((joint.name, joint.joint) for joint in one.joints))
        for one in sessions
        if LOST_JOINT not in one.codes
    }

    def restored(session: Session) -> Session:
        arms = [(count, dict(own)) for count, own in whole if {one.name for one in session.joints} <= dict(own).keys()]
        if LOST_JOINT not in session.codes or len(arms) != 1:
            return session
        ((count, numbers),) = arms
        number: dict[int | None, int] = {joint.joint: numbers[joint.name] for joint in session.joints}
        joints = tuple(replace(joint, joint=number[joint.joint]) for joint in session.joints)
        warnings = tuple(replace(one, joint=number.get(one.joint, one.joint)) for one in session.warnings)
        return replace(session, joints=joints, warnings=warnings, log_joints=count)

    return tuple(map(restored, sessions))


def natural(path: str) -> tuple[tuple[int, int, str], ...]:
    """Return what sorts ``run2`` before ``run10``."""
    parts = re.split(r"(\d+)", path)
    return tuple((1, int(part), "") if part.isdecimal() else (0, 0, part.casefold()) for part in parts if part)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Series:
    """One coefficient of one joint over the n sessions that have an estimate.

    Drift is looked for in y: the logarithm of the coefficient where it is positive and certain enough, so that changes
    are relative and temperature, which acts on viscous friction exponentially, is linear; else the coefficient itself.
    """

    joint: int  # number for people
    coefficient: str  # which one
    session: Int  # indices into all sessions of the arm, shape (n,)
    place: Float  # places among those compared, from 0, shape (n,)
    day: Float | None  # days since the first session, shape (n,), or None where starts are not known [d]
    y: Float  # what drift is looked for in, shape (n,)
    y_error: Float  # its standard errors, shape (n,)
    temperature: Float | None  # of the joint, shape (n,), or None where it cannot be used [degC]
    speed: Float  # median speed in motion, shape (n,) [rad/s]
    logarithmic: bool  # whether y is the logarithm
    kept: Bool  # which sessions count: False for an isolated one, shape (n,)

    def take(self, which: Bool) -> "Series":
        """Return the series of some of its sessions."""
        columns = {name: getattr(self, name) for name in self.__slots__}
        taken: dict[str, Any] = {name: one[which] for name, one in columns.items() if isinstance(one, np.ndarray)}
        return replace(self, **taken)


def make_series(
    sessions: Sequence[Session], compared: Sequence[int], joint: int, coefficient: str, *, by_start: bool
) -> Series:
    """Collect one coefficient of one joint (by number) over the sessions that are compared."""
    rows = []
    for place_among, i in enumerate(compared):
        session = sessions[i]
        for summary in session.joints:
            found = summary.coefficients.get(coefficient, UNDETERMINED)
            if summary.joint == joint and np.isfinite(found.value):
                warmth = session.temperature_c if summary.temperature_c is None else summary.temperature_c
                own = found.value, (found.high - found.low) / (2 * NORMAL_95)
                rows.append((i, place_among, session.start_s, *own, warmth, summary.speed_rad_s[1]))
    index, place, start, value, error, temperature, speed = np.array(rows, dtype=float).reshape(-1, 7).T
    # Estimates without an interval take the largest error of the others; a relative error of 1e-9 keeps it off 0.
    error = np.where(np.isfinite(error), error, np.max(error[np.isfinite(error)], initial=0.0))
    error = np.maximum(error, 1e-9 * max(float(np.max(np.abs(value), initial=0.0)), 1e-9))
    positive = len(value) > 0 and np.min(value) > 0.0
    logarithmic = bool(positive and np.median(error / value) <= LARGEST_RELATIVE_ERROR)
    return Series(
        joint=joint,
        coefficient=coefficient,
        session=index.astype(np.int64),
        place=place,
        day=(start - np.min(start, initial=np.inf)) / SECONDS_A_DAY if by_start else None,
        y=np.log(value) if logarithmic else value,
        y_error=error / value if logarithmic else error,
        temperature=temperature,
        speed=speed,
        logarithmic=logarithmic,
        kept=np.ones(len(value), dtype=np.bool_),
    )
