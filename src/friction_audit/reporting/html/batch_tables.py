"""BatchSummary -> the tables of its page."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import JointSummary, Session
from friction_audit.errors import shortened
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.batch_summary import FailedLog
from friction_audit.reporting.drift_words import (
    DRIFT,
    SHAPES,
    STEADY,
    TEMPERATURE,
    UNITS,
    UNTESTED,
    coefficient_name,
    coefficient_unit,
    daily_text,
    drift_verdict,
    format_change,
    format_p,
    format_percent,
    format_share,
    format_start,
    smallest_text,
    total_text,
    trend_text,
)
from friction_audit.reporting.figures.batch_look import LONGEST_NAME
from friction_audit.reporting.html.page import Cell, Table, Tone
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient, joint_label

TONES: Mapping[str, Tone] = {DRIFT: "alert", STEADY: "fine", TEMPERATURE: "unsure", UNTESTED: "off"}
WITHIN = ("joint", "friction", "described by", "in a session", "seen in", "per K", "at [°C]", "scatter")
SESSIONS = (
    "session", "started (UTC)", "start from", "length [s]", "part", "temperature [°C]", "recorded and read as",
    "payload", "file", "notes",
)  # fmt: skip
ACROSS = 7
"""Joints side by side in a table of coefficients; more make another table."""
MOST_CELLS = 12_000
"""Coefficients that a page lists; all of them are in the tidy table beside it."""


def rows_for(arms: Sequence[ArmDrift]) -> int:
    """Return how many sessions of each arm a page has room for."""
    cells = sum(len(UNITS) * max(len(arm.joints), 1) for arm in arms)
    return max(1, MOST_CELLS // max(cells, 1))


def joint_tables(arm: ArmDrift) -> tuple[Table, Table]:
    """Return what became of each coefficient of each joint, and the numbers behind it."""
    every = [(joint, found) for joint in arm.joints for found in joint.coefficients]
    verdicts = Table(
        caption="Change of each coefficient from the reference to the last sessions; intervals are 95 %",
        titles=("joint", "friction", "verdict", "change", "would show", "what is said of it"),
        rows=[_verdict_row(joint, found) for joint, found in every],
        numbers=frozenset({3, 4}),
    )
    numbers = Table(
        caption="Levels, trends and control charts in numbers",
        titles=("joint", "friction", "level in the reference", "trend per session", "per day", "outside", "p"),
        rows=[_number_row(joint, found) for joint, found in every],
        numbers=frozenset(range(2, 7)),
        folded=True,
    )
    return verdicts, numbers


def _verdict_row(joint: JointDrift, found: CoefficientDrift) -> tuple[Cell, ...]:
    verdict = drift_verdict(found)
    return (
        _joint_cell(joint.joint, joint.name),
        Cell(text=coefficient_name(found.coefficient)),
        Cell(text=verdict, tone=TONES[verdict]),
        Cell(text=total_text(found), key=found.total.value),
        Cell(text=smallest_text(found), key=found.smallest_drift),
        Cell(text=found.message),
    )


def _number_row(joint: JointDrift, found: CoefficientDrift) -> tuple[Cell, ...]:
    outside = sum(point.outside for point in found.control)
    return (
        _joint_cell(joint.joint, joint.name),
        Cell(text=coefficient_name(found.coefficient)),
        Cell(text=_with_unit(found.level, found.coefficient), key=found.level.value),
        Cell(text=trend_text(found), key=_over_level(found.trend_per_session, found)),
        Cell(text=daily_text(found), key=_over_level(found.trend_per_day, found)),
        Cell(text=f"{outside} of {len(found.control)}" if found.control else NOTHING, key=outside),
        Cell(text=format_p(found.p_value) if found.values else NOTHING, key=found.p_value),
    )


def _over_level(slope: Coefficient, found: CoefficientDrift) -> float:
    return slope.value / found.level.value if found.level.value else math.nan


def _joint_cell(joint: int, name: str) -> Cell:
    return Cell(text=joint_label(joint, name), key=joint)


def _with_unit(value: Coefficient, coefficient: str) -> str:
    text = format_coefficient(value)
    return text if text == NOTHING else f"{text} {coefficient_unit(coefficient)}"


def step_table(arm: ArmDrift) -> tuple[Table, ...]:
    """Return the steps that were found, if there are any."""
    rows = list(_steps(arm))
    titles = ("joint", "friction", "session", "started (UTC)", "change", "before", "after")
    caption = "Steps: the first session after each (with the range that holds it with 95 % confidence), and the levels"
    return (Table(caption=caption, titles=titles, rows=rows, numbers=frozenset(range(2, 7))),) if rows else ()


def _steps(arm: ArmDrift) -> Iterator[tuple[Cell, ...]]:
    for joint in arm.joints:
        for found in joint.coefficients:
            for change in found.change_points:
                start_s = arm.sessions[change.session].start_s
                low, high = change.low + 1, change.high + 1
                span = "" if low == high else f" ({low} to {high})"
                yield (
                    _joint_cell(joint.joint, joint.name),
                    Cell(text=coefficient_name(found.coefficient)),
                    Cell(text=f"{change.session + 1}{span}", key=change.session),
                    Cell(text=format_start(start_s), key=_start_key(start_s)),
                    Cell(text=format_change(change.relative, change.after, change.before), key=change.relative.value),
                    Cell(text=_with_unit(change.before, found.coefficient), key=change.before.value),
                    Cell(text=_with_unit(change.after, found.coefficient), key=change.after.value),
                )


def _start_key(start_s: float | None) -> float:
    return math.nan if start_s is None else start_s


def within_table(arm: ArmDrift) -> Table:
    """Return the change within a session, over all sessions, and what was done about temperature."""
    rows = [_within_row(arm, joint, found) for joint in arm.joints for found in joint.coefficients]
    return Table(
        caption="Kept apart from drift: the change from the first to the last third of a session, and in how many "
        "sessions it is seen; the change with temperature that was taken out, and the temperature of the comparison; "
        "the scatter between sessions",
        titles=WITHIN,
        rows=rows,
        numbers=frozenset(range(3, 8)),
    )


def _within_row(arm: ArmDrift, joint: JointDrift, found: CoefficientDrift) -> tuple[Cell, ...]:
    told = [one for one in _within(arm, joint.joint, found.coefficient) if not math.isnan(one.low + one.high)]
    shown = sum(one.low > 0.0 or one.high < 0.0 for one in told)
    warm = found.temperature_c
    return (
        _joint_cell(joint.joint, joint.name),
        Cell(text=coefficient_name(found.coefficient)),
        Cell(text=SHAPES[found.shape]),
        Cell(text=format_percent(found.within), key=found.within.value),
        Cell(text=f"{shown} of {len(told)}" if told else NOTHING, key=shown),
        Cell(text=format_percent(found.temperature_slope), key=found.temperature_slope.value),
        Cell(text=NOTHING if math.isnan(warm) else f"{warm:.1f}", key=warm),
        Cell(text=format_share(found.scatter), key=found.scatter),
    )


def _within(arm: ArmDrift, joint: int, coefficient: str) -> list[Coefficient]:
    return [
        one.within.get(coefficient, UNDETERMINED)
        for session in arm.sessions
        for one in session.joints
        if one.joint == joint
    ]


def diagnosis_table(arm: ArmDrift) -> Table | None:
    """Return how often each effect was found on each joint, or None if nobody asked."""
    rows = [row for joint in arm.joints if (row := _diagnosis_row(arm, joint)) is not None]
    if not rows:
        return None
    return Table(
        caption="Verdicts and effects of the diagnosis, with the number of sessions",
        titles=("joint", "verdicts", "effects"),
        rows=rows,
    )


def _diagnosis_row(arm: ArmDrift, joint: JointDrift) -> tuple[Cell, ...] | None:
    own = [one for session in arm.sessions for one in session.joints if one.joint == joint.joint]
    verdicts = Counter(one.verdict.replace("_", " ") for one in own if one.verdict is not None)
    effects = Counter(effect for one in own for effect in one.effects)
    if not verdicts:
        return None
    cells = (Cell(text=_counts(verdicts)), Cell(text=_counts(effects)))
    return _joint_cell(joint.joint, joint.name), *cells


def _counts(counter: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counter.most_common()) or NOTHING


def left_out_table(arm: ArmDrift) -> tuple[Table, ...]:
    """Return which sessions were not compared, and why, if there are any."""
    rows = [
        (Cell(text=str(k + 1), key=k), Cell(text=arm.sessions[k].path, code=True), Cell(text=reason))
        for k, reason in arm.left_out
    ]
    table = Table(caption="Sessions that were not compared, and why", titles=("session", "file", "reason"), rows=rows)
    return (table,) if rows else ()


def session_table(arm: ArmDrift, most: int) -> Table:
    """Return the last ``most`` sessions, the files they are from, and under what they were recorded."""
    return Table(
        caption=f"Sessions, in the order of their {arm.ordered_by}s{_cut(arm, most)}",
        titles=SESSIONS,
        rows=[_session_row(arm, k, arm.sessions[k]) for k in _last(arm, most)],
        numbers=frozenset({1, 3, 5}),
        folded=len(arm.sessions) > ACROSS,
    )


def _last(arm: ArmDrift, most: int) -> range:
    return range(max(0, len(arm.sessions) - most), len(arm.sessions))


def _cut(arm: ArmDrift, most: int) -> str:
    cut = len(arm.sessions) > most
    return f"; the last {most} of {len(arm.sessions)}, all of them are in the tidy table" if cut else ""


def _session_row(arm: ArmDrift, index: int, session: Session) -> tuple[Cell, ...]:
    part = "reference" if index in arm.reference else "compared" if index in arm.compared else "left out"
    warm = session_temperature(session)
    read_as = session.conditions
    damaged = ("damaged, part of it left out",) if session.damaged else ()
    notes = [text for text in (session.note, *damaged, *session.warnings) if text]
    return (
        Cell(text=str(index + 1), key=index),
        Cell(text=format_start(session.start_s), key=_start_key(session.start_s)),
        Cell(text=session.start_from),
        Cell(text=f"{session.duration_s:.0f}", key=session.duration_s),
        Cell(text=part),
        Cell(text=NOTHING if math.isnan(warm) else f"{warm:.1f}", key=warm),
        Cell(text=f"{read_as.drive}, {read_as.torque}, gravity {read_as.gravity}, inertia {read_as.inertia}"),
        Cell(text=read_as.payload or NOTHING),
        Cell(text=session.path, code=True),
        Cell(text="; ".join(notes) or NOTHING),
    )


def session_temperature(session: Session) -> float:
    """Return the temperature of a session, from the manifest or the mean of its joints; NaN if nothing tells. [degC]"""
    if session.temperature_c is not None:
        return session.temperature_c
    logged = [joint.temperature_c for joint in session.joints if joint.temperature_c is not None]
    return math.fsum(logged) / len(logged) if logged else math.nan


def coefficient_tables(arm: ArmDrift, most: int) -> Iterator[Table]:
    """Yield the coefficients of the last ``most`` sessions: a table per coefficient and ACROSS joints."""
    for coefficient in UNITS:
        for first in range(0, len(arm.joints), ACROSS):
            yield _coefficient_table(arm, coefficient, arm.joints[first : first + ACROSS], most)


def _coefficient_table(arm: ArmDrift, coefficient: str, joints: Sequence[JointDrift], most: int) -> Table:
    kind = f"{coefficient_name(coefficient)} coefficient"
    which = f"{kind[:1].upper()}{kind[1:]} of each session, joints {joints[0].joint} to {joints[-1].joint}"
    return Table(
        caption=f"{which}, with its 95 % interval [{UNITS[coefficient]}]{_cut(arm, most)}",
        titles=("session", *(shortened(joint_label(joint.joint, joint.name), LONGEST_NAME) for joint in joints)),
        rows=[
            (
                Cell(text=str(k + 1), key=k),
                *(_coefficient_cell(arm.sessions[k], joint.joint, coefficient) for joint in joints),
            )
            for k in _last(arm, most)
        ],
        numbers=frozenset(range(1, len(joints) + 1)),
        folded=True,
    )


def _coefficient_cell(session: Session, joint: int, coefficient: str) -> Cell:
    summary: JointSummary | None = next((one for one in session.joints if one.joint == joint), None)
    value = UNDETERMINED if summary is None else summary.coefficients.get(coefficient, UNDETERMINED)
    return Cell(text=format_coefficient(value), key=value.value)


def failed_table(failed: Sequence[FailedLog]) -> Table:
    """Return the files that gave no session, with what was wrong."""
    rows = [(Cell(text=one.path, code=True), Cell(text=one.message)) for one in failed]
    return Table(caption="Files that gave no session", titles=("file", "what was wrong"), rows=rows)
