"""Tables of the page of a batch, a specification each."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from friction_audit.drift.report import ChangePoint, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.errors import shortened
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting import drift_words
from friction_audit.reporting.drift import CoefficientRow
from friction_audit.reporting.sentences import session_sentences
from friction_audit.reporting.table import Column, Get, Record, joint_column
from friction_audit.reporting.words import (
    SHORTEST_NAME,
    format_p,
    format_percent,
    format_share,
    format_start,
    joint_label,
    with_unit,
)


def _level(row: CoefficientRow) -> str:
    return with_unit(row.found.level, drift_words.UNITS[row.found.coefficient])


def _shown(title: str, text: Callable[[Any], str], sort: Get) -> Column:
    """Return a column of the page whose text is made of the whole row."""
    return Column(title, get=lambda row: row, form=text, sort=sort, title=title, on="p")


def _trend(title: str, name: str) -> Column:
    """Return the column of a trend, sorted by its share of the level."""

    def share(row: CoefficientRow) -> float:
        level = row.found.level.value
        return float(getattr(row.found, name).value / level) if level else math.nan

    return _shown(title, lambda row: drift_words.slope_text(row.found, getattr(row.found, name)), share)


def _outside(row: CoefficientRow) -> str:
    outside = sum(point.outside for point in row.found.control)
    return f"{outside} of {len(row.found.control)}" if row.found.control else ""


HEAD = (
    joint_column("joint"),
    Column("friction", str, get="found.coefficient", form=drift_words.NAMES.__getitem__, title="friction", on="p"),
)
NUMBERS = Record(
    (
        *HEAD,
        _shown("level in the reference", _level, "found.level.value"),
        _trend("trend per session", "trend_per_session"),
        _trend("per day", "trend_per_day"),
        _shown("outside", _outside, lambda row: sum(point.outside for point in row.found.control)),
        Column("p", get=lambda row: row.found.p_value if row.found.values else None, form=format_p, title="p", on="p"),
    )
)


ARM = Record(
    (
        Column("arm", str, get="robot", title="arm", code=True, on="p"),
        Column(
            "verdict", str, get=drift_words.arm_verdict, title="verdict", tone=drift_words.TONES.__getitem__, on="p"
        ),
        Column("sentence", str, get=drift_words.arm_sentence, title="answer", words=True, on="p"),
    )
)


class StepRow(NamedTuple):
    """A step of a coefficient."""

    joint: JointDrift
    found: CoefficientDrift
    change: ChangePoint
    start_s: float | None


def _side(side: str) -> Column:
    def text(row: StepRow) -> str:
        return with_unit(getattr(row.change, side), drift_words.UNITS[row.found.coefficient])

    return _shown(side, text, f"change.{side}.value")


STEPS = Record(
    (
        *HEAD,
        _shown("session", lambda row: drift_words.first_after(row.change), "change.session"),
        Column("start", get="start_s", form=format_start, title="started (UTC)", on="p"),
        _shown("change", lambda row: drift_words.format_change(row.change), "change.relative.value"),
        _side("before"),
        _side("after"),
    )
)


def _within(row: CoefficientRow) -> tuple[int, int]:
    """Return in how many sessions a change within the session is significant, and of how many it is known."""
    every = (
        one.within.get(row.found.coefficient, UNDETERMINED)
        for session in row.arm.sessions
        for one in session.joints
        if one.joint == row.joint.joint
    )
    known = [one for one in every if not math.isnan(one.low + one.high)]
    return sum(one.low > 0.0 or one.high < 0.0 for one in known), len(known)


WITHIN = Record(
    (
        *HEAD,
        Column("shape", str, get="found.shape", form=drift_words.SHAPES.__getitem__, title="described by", on="p"),
        Column("within", Coefficient, get="found.within", form=format_percent, title="in a session", on="p"),
        Column(
            "seen", get=_within, form=lambda seen: f"{seen[0]} of {seen[1]}" if seen[1] else "",
            sort=lambda row: _within(row)[0], title="seen in", on="p",
        ),
        Column("slope", Coefficient, get="found.temperature_slope", form=format_percent, title="per K", on="p"),
        Column("temperature", get="found.temperature_c", form=".1f", unit="°C", title="at", on="p"),
        Column("scatter", get="found.scatter", form=format_share, title="scatter", on="p"),
    )
)  # fmt: skip


def _counts(names: Sequence[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in Counter(names).most_common())


class DiagnosisRow(NamedTuple):
    """Verdicts and effects that the diagnosis gave for a joint, session by session."""

    joint: JointDrift
    verdicts: Sequence[str]
    effects: Sequence[str]


DIAGNOSED = Record(
    (
        joint_column("joint"),
        Column("verdicts", str, get="verdicts", form=_counts, title="verdicts", on="p"),
        Column("effects", str, get="effects", form=_counts, title="effects", on="p"),
    )
)


class SessionRow(NamedTuple):
    """A session, its place among those of its arm, and why it was not compared or what part it has in it."""

    place: int
    session: Session
    note: str


SESSION_NUMBER = Column("session", str, get=lambda row: str(row.place + 1), sort="place", title="session", on="p")
LEFT_OUT = Record(
    (
        SESSION_NUMBER,
        Column("file", str, get="session.path", title="file", code=True, on="p"),
        Column("reason", str, get="note", title="reason", on="p"),
    )
)


def _read_as(session: Session) -> str:
    read_as = session.conditions
    return f"{read_as.drive}, {read_as.torque}, gravity {read_as.gravity}, inertia {read_as.inertia}"


def _notes(session: Session) -> str:
    damaged = ("damaged, part of it left out",) if session.damaged else ()
    return "; ".join(text for text in (session.note, *damaged, *session_sentences(session.warnings)) if text)


def session_temperature(session: Session) -> float:
    """Return the temperature of a session, from the manifest or the mean of its joints; NaN if unknown. [degC]"""
    if session.temperature_c is not None:
        return session.temperature_c
    logged = [joint.temperature_c for joint in session.joints if joint.temperature_c is not None]
    return math.fsum(logged) / len(logged) if logged else math.nan


SESSIONS = Record(
    (
        SESSION_NUMBER,
        Column("start", get="session.start_s", form=format_start, title="started (UTC)", on="p"),
        Column("start_from", str, get="session.start_from", title="start from", on="p"),
        Column("duration", get="session.duration_s", form=".0f", unit="s", title="length", on="p"),
        Column("part", str, get="note", title="part", on="p"),
        Column(
            "temperature", get=lambda row: session_temperature(row.session), form=".1f", unit="°C",
            title="temperature", on="p",
        ),
        Column("read_as", str, get="session", form=_read_as, title="recorded and read as", on="p"),
        Column("payload", str, get="session.conditions.payload", title="payload", on="p"),
        Column("file", str, get="session.path", title="file", code=True, on="p"),
        Column("notes", str, get="session", form=_notes, title="notes", on="p"),
    )
)  # fmt: skip


def coefficient_column(joint: JointDrift, name: str) -> Column:
    """Return the column of a coefficient of a joint in the table of sessions."""

    def value(row: SessionRow) -> Coefficient:
        summary = next((one for one in row.session.joints if one.joint == joint.joint), None)
        return UNDETERMINED if summary is None else summary.coefficients.get(name, UNDETERMINED)

    title = shortened(joint_label(joint.joint, joint.name), SHORTEST_NAME)
    return Column(f"joint_{joint.joint}", Coefficient, get=value, title=title, on="p")
