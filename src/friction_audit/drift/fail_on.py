"""Limits that the user sets on drift, for machines that run every night: ``--fail-on coulomb=15%``."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite

from friction_audit.drift.report import CoefficientDrift, DriftReport
from friction_audit.drift.words import NAMES, UNITS, how_much, percent
from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED

COEFFICIENT_OF = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad", "any": None}

PATTERN = re.compile(r"(?:joint(?P<joint>[1-9]\d*)\.)?(?P<name>[a-z]+)=(?P<size>[^%]+?)\s*(?P<percent>%)?")

EXPECTED = "expected e.g. coulomb=15%, viscous=0.05 (N m s/rad), joint3.coulomb=10% or any=20%"


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


def exceeded(report: DriftReport, limits: Sequence[Limit]) -> tuple[str, ...]:
    """Return one sentence for each coefficient that went beyond a limit; none if all is well.

    A limit is exceeded if drift is proven and the change from the reference to the last sessions, as estimated, is at
    least as large as the limit.
    """
    return tuple(
        f"{where}: {_sentence(drift, limit)}"
        for limit in limits
        for where, drift in _meant(report, limit)
        if is_exceeded(drift, limit)
    )


def untestable(report: DriftReport, limits: Sequence[Limit]) -> tuple[str, ...]:
    """Return one sentence for each coefficient whose sessions cannot show a change as small as a limit.

    A limit of 0 asks for any drift that is proven, which every test answers.
    """
    sentences = []
    for limit in limits:
        meant = list(_meant(report, limit))
        if not meant:
            sentences.append(f"the limit {limit.text}: no session has an estimate that it is meant for")
        for where, drift in meant:
            least = drift.smallest_drift if limit.relative else drift.smallest_change
            proved = drift.drift and isfinite((drift.total if limit.relative else drift.change).value)
            testable = proved or limit.size == 0.0 or (least <= limit.size and drift.shape != "temperature")
            if not testable:
                sentences.append(f"{where}: {NAMES[drift.coefficient]}: {_why(drift, least, limit)}")
    return tuple(sentences)


def _meant(report: DriftReport, limit: Limit) -> Iterator[tuple[str, CoefficientDrift]]:
    """Yield the coefficients that a limit is meant for, each with its arm and joint."""
    for arm in report.arms:
        for joint in arm.joints:
            for drift in joint.coefficients:
                if limit.joint in {None, joint.joint} and limit.coefficient in {None, drift.coefficient}:
                    yield f"{arm.robot}, joint {joint.joint}", drift


def _why(drift: CoefficientDrift, least: float, limit: Limit) -> str:
    where = f"the limit {limit.text} cannot be tested"
    if drift.shape == "temperature":
        return f"{where}: drift and temperature cannot be separated; record sessions at like temperature"
    if drift.drift:
        return f"{where}: the reference is near zero, so there is no relative change; give a limit without %"
    if drift.shape == "too_few" or not isfinite(least):
        count = len(drift.sessions) - len(drift.isolated)
        return f"{where} with {count} comparable session{'' if count == 1 else 's'}; record more"
    size = f"{percent(least)} %" if limit.relative else f"{least:.2g} {UNITS[drift.coefficient]}"
    return f"{where}: only a change of {size} or more is detectable; record more or longer sessions"


def is_exceeded(drift: CoefficientDrift, limit: Limit) -> bool:
    """Return whether a coefficient went beyond a limit that is meant for it."""
    change = drift.total if limit.relative else drift.change
    return drift.drift and abs(change.value) >= limit.size


def _sentence(drift: CoefficientDrift, limit: Limit) -> str:
    change = drift.total if limit.relative else drift.change
    went = "rose" if change.value >= 0 else "fell"
    size = how_much(drift.total if limit.relative else UNDETERMINED, drift.change, UNITS[drift.coefficient])
    sure = min(abs(change.low), abs(change.high)) >= limit.size and change.low * change.high > 0
    return (
        f"{NAMES[drift.coefficient]} {went} by {size} since the reference, {'surely' if sure else 'probably'} beyond "
        f"the limit {limit.text}"
    )
