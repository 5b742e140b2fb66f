"""Limits that the user sets on drift, for machines that run every night: ``--fail-on coulomb=15%``."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Literal, NamedTuple

from friction_audit.drift.report import CoefficientDrift, DriftReport
from friction_audit.errors import UsageError

Verdict = Literal["kept", "exceeded", "untestable"]
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


class Judged(NamedTuple):
    """A coefficient that a limit is meant for; without arm, joint and coefficient where no session has an estimate."""

    limit: Limit
    verdict: Verdict
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


def _verdict(found: CoefficientDrift, limit: Limit) -> Verdict:
    change = (found.total if limit.relative else found.change).value
    least = found.smallest_drift if limit.relative else found.smallest_change
    if found.drift and abs(change) >= limit.size:
        return "exceeded"
    proved = found.drift and isfinite(change)
    tested = proved or limit.size == 0.0 or (least <= limit.size and found.shape != "temperature")
    return "kept" if tested else "untestable"
