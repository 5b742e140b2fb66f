"""ArmDrift: what changed between sessions, when, and how sure we are; and what a user asks: settings and limits."""

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf, isnan, nan
from typing import Literal, NamedTuple

from friction_audit.drift.session import Session
from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_numbers import parse_joint_numbers
from friction_audit.preprocessing.interaction import Caution, Reason

# What describes a coefficient over the sessions. "step_or_ramp": drift is proven, but the two describe it equally well.
# "temperature": it changes together with the temperature, so that drift and temperature are confounded.
SHAPES = ("none", "step", "steps", "ramp", "step_or_ramp", "temperature", "too_few")

LimitVerdict = Literal["kept", "exceeded", "untestable"]
COEFFICIENT_OF = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad", "any": None}
PATTERN = re.compile(r"(?:joint(?P<joint>[1-9]\d*)\.)?(?P<name>[a-z]+)=(?P<size>[^%]+?)\s*(?P<percent>%)?")
FEWEST_SESSIONS = 4  # two before and two after a step; fewer cannot tell a change from one odd session


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftSettings:
    """How drift is looked for."""

    baseline: int | tuple[int, ...] = 5  # the reference: so many first sessions, or their indices in order, from 0
    alpha: float = 0.05  # probability that an arm on which nothing changes is said to drift
    power: float = 0.9  # probability with which the smallest drift is found
    permutations: int = 1999  # orders of the sessions that the tests are judged by
    seed: int = 0  # of the permutations: the same sessions give the same answer


def parse_baseline(text: str) -> int | tuple[int, ...]:
    """Return the reference of ``"5"`` (the first five sessions) or ``"3-8,10"`` (those, counted from 1)."""
    word = text.strip()
    if word.isdecimal() and int(word) > 0:
        return int(word)
    try:
        return tuple(number - 1 for number in parse_joint_numbers(word, "--baseline"))
    except UsageError as error:
        raise UsageError(
            f"--baseline {text}: expected how many first sessions are the reference, e.g. 5, or which ones, e.g. 3-8,10"
        ) from error


@dataclass(frozen=True, kw_only=True, slots=True)
class ChangePoint:
    """A step between two sessions."""

    session: int  # index into ``ArmDrift.sessions`` of the first one after the step
    low: int  # first session that may be the first one after the step, same index, 95 % interval
    high: int  # last one
    before: Coefficient  # level before it, with interval
    after: Coefficient  # level after it
    change: Coefficient  # from the level before it to that after it
    relative: Coefficient  # the same over the level before it; NaN where that level is near zero
    p_value: float  # family-wise over joints and coefficients of the arm


@dataclass(frozen=True, kw_only=True, slots=True)
class ControlPoint:
    """One session against the reference."""

    session: int  # index into ``ArmDrift.sessions``
    # from the reference's level; the interval is where a session without drift lies, family-wise over the sessions
    deviation: Coefficient
    relative: Coefficient  # the same over the reference's level; NaN where that is near zero
    outside: bool  # whether the deviation lies outside of the limits


@dataclass(frozen=True, kw_only=True, slots=True)
class CoefficientDrift:
    """One coefficient of one joint over the sessions; every interval is of 95 %."""

    coefficient: str  # one of ``COEFFICIENTS``
    sessions: tuple[int, ...]  # indices into ``ArmDrift.sessions`` of those that were compared
    values: tuple[Coefficient, ...]  # of each of them, as compared (at like temperature), with its own interval
    isolated: tuple[int, ...] = ()  # those of ``sessions`` that no neighbour comes near: shown, not counted as drift
    level: Coefficient = UNDETERMINED  # level in the reference. Unit of the coefficient.
    shape: str = "none"  # what describes it: one of ``SHAPES``
    p_value: float = 1.0  # that nothing changes, family-wise over joints and coefficients of the arm
    temperature_slope: Coefficient = UNDETERMINED  # change per degree that was taken out, NaN where none could be [1/K]
    temperature_c: float = float("nan")  # temperature that the values are compared at, NaN where none could be [degC]
    trend_per_session: Coefficient = UNDETERMINED  # robust slope, unit of the coefficient per session
    trend_per_day: Coefficient = UNDETERMINED  # the same per day; NaN where starts are not known
    trend_p_value: float = 1.0  # that there is no straight trend, family-wise
    change_points: tuple[ChangePoint, ...] = ()  # steps, in order; empty where a ramp describes it
    control: tuple[ControlPoint, ...] = ()  # every session against the reference
    change: Coefficient = UNDETERMINED  # from the reference to the last sessions, unit of the coefficient
    total: Coefficient = UNDETERMINED  # the same over the reference's level; NaN where that is near zero
    scatter: float = float("nan")  # between sessions beyond their intervals, over the level where that is not near zero
    smallest_change: float = float("nan")  # straight change that would have been found with 90 % power, start to end
    smallest_drift: float = float("nan")  # the same over the level; NaN where that is near zero
    within: Coefficient = UNDETERMINED  # relative change within a session (warm-up), over all; no part of the drift
    drift: bool  # whether there is any
    warmer_k: float = float("nan")  # rise of the temperature, first to last sessions, NaN where it is not known [K]
    by_temperature: bool = False  # whether there is a change that the temperature explains
    speed_ratio: float = float("nan")  # speed at the end of a change over its start, where it went with it, else NaN
    reasons: tuple[Reason, ...] = ()  # why sessions have no estimate, where there are too few


@dataclass(frozen=True, kw_only=True, slots=True)
class JointDrift:
    """One joint over the sessions."""

    joint: int  # number for people
    name: str  # its name
    coefficients: tuple[CoefficientDrift, ...]  # what became of each coefficient

    @property
    def drift(self) -> bool:
        """Whether one of them drifts."""
        return any(one.drift for one in self.coefficients)


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmDrift:
    """One arm."""

    robot: str  # which arm
    joints: tuple[JointDrift, ...]  # what became of each joint
    sessions: tuple[Session, ...] = ()  # all of it in order
    compared: tuple[int, ...] = ()  # indices of those that were compared
    reference: tuple[int, ...] = ()  # indices of the sessions of the reference
    left_out: tuple[tuple[int, Reason], ...] = ()  # index of each session that was not compared, with the reason
    ordered_by: str = "name"  # ``"start"`` or ``"name"``
    autocorrelation: float = nan  # of one session's scatter with the next one's, over all joints
    warnings: tuple[Caution, ...] = ()  # what limits the comparison

    @property
    def drift(self) -> bool:
        """Whether a joint drifts."""
        return any(joint.drift for joint in self.joints)


@dataclass(frozen=True, kw_only=True, slots=True)
class Limit:
    """How far a coefficient may go from the reference."""

    joint: int | None  # number for people, or None for all joints
    coefficient: str | None  # which one, or None for each
    size: float  # largest change, either way: relative to the reference's level, or in the unit of the coefficient
    relative: bool  # which of the two
    text: str  # as the user wrote it


def parse_limit(text: str) -> Limit:
    """Return the limit of ``"coulomb=15%"``, ``"viscous=0.05"``, ``"joint3.coulomb=10%"`` or ``"any=20%"``."""
    where = f"--fail-on {text}"
    found = PATTERN.fullmatch(text.strip().lower())
    size = nan
    with suppress(ValueError):
        size = float(found["size"] if found else nan)
    if found is None or found["name"] not in COEFFICIENT_OF or not 0.0 <= size < inf:
        expected = "coulomb=15%, viscous=0.05 (N m s/rad), joint3.coulomb=10% or any=20%"
        raise UsageError(f"{where}: not a limit; expected e.g. {expected}")
    relative = found["percent"] is not None
    if found["name"] == "any" and not relative:
        raise UsageError(f"{where}: the coefficients have different units; expected a limit in per cent, e.g. any=20%")
    return Limit(
        joint=int(found["joint"]) if found["joint"] else None,
        coefficient=COEFFICIENT_OF[found["name"]],
        size=size / 100 if relative else size,
        relative=relative,
        text=text.strip(),
    )


class Judged(NamedTuple):
    """A coefficient that a limit is meant for; without arm, joint and coefficient where no session has an estimate."""

    limit: Limit
    verdict: LimitVerdict
    robot: str = ""
    joint: int | None = None
    found: CoefficientDrift | None = None


def judge(arms: Sequence[ArmDrift], limits: Sequence[Limit]) -> Iterator[Judged]:
    """Judge each coefficient of some arms by each limit that is meant for it.

    A limit is exceeded if drift is proven and the estimated change at least as large; it is untestable where the
    sessions cannot show a change as small. A limit of 0 asks for any drift that is proven, which every test answers.
    """
    for limit in limits:
        meant = [
            Judged(limit, _verdict(found, limit), arm.robot, joint.joint, found)
            for arm in arms
            for joint in arm.joints
            for found in joint.coefficients
            if limit.joint in {None, joint.joint} and limit.coefficient in {None, found.coefficient}
        ]
        yield from meant or [Judged(limit, "untestable")]


def _verdict(found: CoefficientDrift, limit: Limit) -> LimitVerdict:
    change = (found.total if limit.relative else found.change).value
    least = found.smallest_drift if limit.relative else found.smallest_change
    if found.drift and not isnan(change):
        return "exceeded" if abs(change) >= limit.size else "kept"
    return "kept" if limit.size == 0.0 or (least <= limit.size and found.shape != "temperature") else "untestable"
