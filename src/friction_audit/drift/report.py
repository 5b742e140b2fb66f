"""DriftReport: what changed between sessions, when, and how sure we are; and the limits that a user sets on it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Literal, NamedTuple

from friction_audit.drift.session import Session
from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED, Coefficient

# What describes a coefficient over the sessions. "step_or_ramp": drift is proven, but the two describe it equally well.
# "temperature": it changes together with the temperature, so that drift and temperature are confounded.
SHAPES = ("none", "step", "steps", "ramp", "step_or_ramp", "temperature", "too_few")

LimitVerdict = Literal["kept", "exceeded", "untestable"]
COEFFICIENT_OF = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad", "any": None}

PATTERN = re.compile(r"(?:joint(?P<joint>[1-9]\d*)\.)?(?P<name>[a-z]+)=(?P<size>[^%]+?)\s*(?P<percent>%)?")

EXPECTED = "expected e.g. coulomb=15%, viscous=0.05 (N m s/rad), joint3.coulomb=10% or any=20%"


@dataclass(frozen=True, kw_only=True, slots=True)
class ChangePoint:
    """A step between two sessions.

    Attributes:
        session: Index into ``ArmDrift.sessions`` of the first one after the step.
        low: First session that may be the first one after the step, same index, 95 % interval.
        high: Last one.
        before: Level before it, with interval.
        after: Level after it.
        relative: Change over the level before it, with interval; NaN where that level is near zero.
        p_value: Family-wise over joints and coefficients of the arm.
    """

    session: int
    low: int
    high: int
    before: Coefficient
    after: Coefficient
    relative: Coefficient
    p_value: float


@dataclass(frozen=True, kw_only=True, slots=True)
class ControlPoint:
    """One session against the reference.

    Attributes:
        session: Index into ``ArmDrift.sessions``.
        deviation: Deviation from the reference's level; its interval is where a session without drift would lie, 0 in
            its middle (family-wise over the sessions). Unit of the coefficient.
        relative: The same over the reference's level; NaN where that is near zero.
        outside: Whether the deviation lies outside of the limits.
    """

    session: int
    deviation: Coefficient
    relative: Coefficient
    outside: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class CoefficientDrift:
    """One coefficient of one joint over the sessions; every interval is of 95 %.

    Attributes:
        coefficient: ``"coulomb_nm"`` or ``"viscous_nms_per_rad"``.
        sessions: Indices into ``ArmDrift.sessions`` of those that were compared.
        values: The coefficient in each of them, as compared (at like temperature), with its own interval.
        isolated: Those of ``sessions`` that none of their neighbours comes near: shown, but not counted as drift.
        level: Level in the reference. Unit of the coefficient.
        shape: What describes it: one of ``SHAPES``.
        p_value: That nothing changes, family-wise over joints and coefficients of the arm.
        temperature_slope: Relative change per degree that was taken out, NaN where none could be. [1/K]
        temperature_c: Temperature that the values are compared at, NaN where none could be. [degC]
        trend_per_session: Robust slope, unit of the coefficient per session.
        trend_per_day: The same per day; NaN where starts are not known.
        trend_p_value: That there is no straight trend, family-wise.
        change_points: Steps, in order; empty where a ramp describes it.
        control: Every session against the reference.
        change: From the reference to the last sessions, unit of the coefficient.
        total: The same over the reference's level; NaN where that is near zero.
        scatter: Standard deviation between sessions beyond the intervals of the estimates, over the level (in the unit
            of the coefficient where the level is near zero).
        smallest_change: Straight change, start to end, that so many sessions would have shown with 90 % power, unit of
            the coefficient.
        smallest_drift: The same over the level; NaN where that is near zero.
        within: Relative change within a session (warm-up), over all sessions that have one; no part of the drift.
        drift: Whether there is any.
        warmer_k: Rise of the temperature from the first to the last sessions, NaN where it is not known. [K]
        by_temperature: Whether there is a change that the temperature explains.
        speed_ratio: Speed of motion at the end of a change over its start, where it went with it, else NaN.
        reasons: Why sessions have no estimate, where there are too few.
    """

    coefficient: str
    sessions: tuple[int, ...]
    values: tuple[Coefficient, ...]
    isolated: tuple[int, ...] = ()
    level: Coefficient = UNDETERMINED
    shape: str = "none"
    p_value: float = 1.0
    temperature_slope: Coefficient = UNDETERMINED
    temperature_c: float = float("nan")
    trend_per_session: Coefficient = UNDETERMINED
    trend_per_day: Coefficient = UNDETERMINED
    trend_p_value: float = 1.0
    change_points: tuple[ChangePoint, ...] = ()
    control: tuple[ControlPoint, ...] = ()
    change: Coefficient = UNDETERMINED
    total: Coefficient = UNDETERMINED
    scatter: float = float("nan")
    smallest_change: float = float("nan")
    smallest_drift: float = float("nan")
    within: Coefficient = UNDETERMINED
    drift: bool
    warmer_k: float = float("nan")
    by_temperature: bool = False
    speed_ratio: float = float("nan")
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class JointDrift:
    """One joint over the sessions.

    Attributes:
        joint: Number for people.
        name: Its name.
        coefficients: What became of each coefficient.
    """

    joint: int
    name: str
    coefficients: tuple[CoefficientDrift, ...]

    @property
    def drift(self) -> bool:
        """Whether one of them drifts."""
        return any(one.drift for one in self.coefficients)


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmDrift:
    """One arm.

    Attributes:
        robot: Which arm.
        sessions: All its sessions in the order of their starts (of their names where starts are not known).
        compared: Indices of those that were compared.
        reference: Indices of the sessions of the reference.
        left_out: Index of each session that was not compared, with the reason.
        joints: What became of each joint.
        ordered_by: ``"start"`` or ``"name"``.
        autocorrelation: Of one session's scatter with the next one's, over all joints.
        warnings: What limits the comparison, one sentence each.
    """

    robot: str
    sessions: tuple[Session, ...]
    compared: tuple[int, ...]
    reference: tuple[int, ...]
    left_out: tuple[tuple[int, str], ...]
    joints: tuple[JointDrift, ...]
    ordered_by: str
    autocorrelation: float
    warnings: tuple[str, ...] = ()

    @property
    def drift(self) -> bool:
        """Whether a joint drifts."""
        return any(joint.drift for joint in self.joints)


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftReport:
    """All arms of a batch."""

    arms: tuple[ArmDrift, ...]

    @property
    def drift(self) -> bool:
        """Whether an arm drifts."""
        return any(arm.drift for arm in self.arms)


@dataclass(frozen=True, kw_only=True, slots=True)
class Limit:
    """How far a coefficient may go from the reference.

    Attributes:
        joint: Number for people, or None for all joints.
        coefficient: Which one, or None for each.
        size: Largest change, either way: relative to the reference's level, or in the unit of the coefficient.
        relative: Which of the two.
        text: As the user wrote it.
    """

    joint: int | None
    coefficient: str | None
    size: float
    relative: bool
    text: str


def parse_limit(text: str) -> Limit:
    """Return the limit of ``"coulomb=15%"``, ``"viscous=0.05"``, ``"joint3.coulomb=10%"`` or ``"any=20%"``.

    Raises:
        UsageError: If the text is anything else.
    """
    where = f"--fail-on {text}"
    found = PATTERN.fullmatch(text.strip().lower())
    if found is None or found["name"] not in COEFFICIENT_OF:
        raise UsageError(f"{where}: not a limit; {EXPECTED}")
    size = _number(found["size"], where)
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


def _number(text: str, where: str) -> float:
    try:
        size = float(text)
    except ValueError as error:
        raise UsageError(f"{where}: {text!r} is no number; {EXPECTED}") from error
    if not (isfinite(size) and size >= 0.0):
        raise UsageError(f"{where}: {text} is no size of a change; {EXPECTED}")
    return size


class Judged(NamedTuple):
    """A coefficient that a limit is meant for; without arm, joint and coefficient where no session has an estimate."""

    limit: Limit
    verdict: LimitVerdict
    robot: str = ""
    joint: int | None = None
    found: CoefficientDrift | None = None

    @property
    def where(self) -> str:
        """Its arm and joint."""
        return f"{self.robot}, joint {self.joint}"


def judge(report: DriftReport, limits: Sequence[Limit]) -> Iterator[Judged]:
    """Judge each coefficient by each limit that is meant for it.

    A limit is exceeded if drift is proven and the change from the reference to the last sessions, as estimated, is at
    least as large as the limit. It is untestable where the sessions cannot show a change as small as that; a limit of 0
    asks for any drift that is proven, which every test answers.
    """
    for limit in limits:
        meant = [
            Judged(limit, _verdict(found, limit), arm.robot, joint.joint, found)
            for arm in report.arms
            for joint in arm.joints
            for found in joint.coefficients
            if limit.joint in {None, joint.joint} and limit.coefficient in {None, found.coefficient}
        ]
        yield from meant or [Judged(limit, "untestable")]


def _verdict(found: CoefficientDrift, limit: Limit) -> LimitVerdict:
    change = (found.total if limit.relative else found.change).value
    least = found.smallest_drift if limit.relative else found.smallest_change
    if found.drift and abs(change) >= limit.size:
        return "exceeded"
    proved = found.drift and isfinite(change)
    tested = proved or limit.size == 0.0 or (least <= limit.size and found.shape != "temperature")
    return "kept" if tested else "untestable"
