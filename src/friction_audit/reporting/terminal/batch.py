"""BatchSummary -> the table and the sentences that people read."""

import csv
import math
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import TYPE_CHECKING, Any, TextIO

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import JointSummary, Session
from friction_audit.errors import encodable
from friction_audit.friction.history import UNDETERMINED
from friction_audit.reporting.batch_summary import BatchSummary
from friction_audit.reporting.drift_words import (
    UNITS,
    arm_sentence,
    change_text,
    coefficient_name,
    coefficient_unit,
    count_of,
    drift_verdict,
    enumerate_words,
    format_slope,
    iso_start,
    joint_sentence,
    smallest_text,
    span_of,
    total_text,
    trend_text,
)
from friction_audit.reporting.tables.of_estimate import csv_cell
from friction_audit.reporting.terminal.estimate import NOTHING, joint_label
from friction_audit.reporting.terminal.plain import plain_lines

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text


TITLES = ("joint", "friction", "verdict", "change", "step", "trend\n/session", "would\nshow")
WORDS = 3
"""Columns of words; the others hold numbers."""
MOST_NAMED = 8
"""Sessions that a line names; more are counted."""


def batch_table(summary: BatchSummary, *, verbose: bool = False) -> "list[Text]":
    """Return what there was, a table per arm, what is to be said of it, and the files that failed.

    Args:
        summary: The batch.
        verbose: If True, also what is to be said of joints without drift, and why each session was left out.
    """
    from rich.text import Text

    lines = [_head(summary)]
    for arm in summary.arms:
        lines += ["", *_arm_lines(arm, verbose=verbose)]
    lines += [""] * bool(summary.exceeded or summary.cannot_tell or summary.failed)
    lines += [f"limit exceeded: {sentence}" for sentence in summary.exceeded]
    lines += [f"cannot tell: {sentence}" for sentence in summary.cannot_tell]
    lines += [f"failed: {failed.path}: {failed.message}" for failed in summary.failed]
    return [Text(line) for line in lines]


def _head(summary: BatchSummary) -> str:
    sessions, arms = count_of(len(summary.sessions), "session"), count_of(len(summary.arms), "arm")
    done = f"{summary.computed} computed, {summary.known} known from the ledger, {len(summary.failed)} failed"
    return f"{sessions} of {arms}: {done}"


def _arm_lines(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    span = span_of(arm.sessions)
    sessions = f"{count_of(len(arm.sessions), 'session')}{f', {span}' if span else ''}"
    yield f"{arm.robot}: {sessions}, {len(arm.compared)} compared; {arm_sentence(arm)}"
    yield "changes are from the reference to the last sessions; intervals are 95 %"
    yield from plain_lines(_table(arm))
    for joint in arm.joints:
        yield from _joint_lines(arm, joint, verbose=verbose)
    yield from _left_out(arm, verbose=verbose)
    yield from (f"note: {warning}" for warning in arm.warnings)


def _table(arm: ArmDrift) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
    for column, title in enumerate(TITLES):
        table.add_column(
            Text(title), justify="left" if column < WORDS else "right", no_wrap=title != "step", min_width=4
        )
    for joint in arm.joints:
        for row, found in enumerate(joint.coefficients):
            label = joint_label(joint.joint, joint.name) if row == 0 else ""
            table.add_row(*map(Text, (label, *_row(found))))
    return table


def _row(found: CoefficientDrift) -> tuple[str, ...]:
    steps = ", ".join(str(change.session + 1) for change in found.change_points) or NOTHING
    return (
        coefficient_name(found.coefficient),
        drift_verdict(found),
        total_text(found),
        steps,
        trend_text(found),
        smallest_text(found),
    )


def _joint_lines(arm: ArmDrift, joint: JointDrift, *, verbose: bool) -> Iterator[str]:
    """Yield the message of a joint that drifts, or of every one, and its steps."""
    if not (joint.drift or verbose):
        return
    yield f"joint {joint.joint}: {joint_sentence(joint)}"
    for found in joint.coefficients:
        name = coefficient_name(found.coefficient)
        yield from (f"  {name}: step at {change_text(arm, change)}" for change in found.change_points)
        if found.drift and not found.change_points:
            per_session = f"{format_slope(found.trend_per_session)} {coefficient_unit(found.coefficient)} per session"
            yield f"  {name}: {per_session}, {format_slope(found.trend_per_day)} per day"


def _left_out(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    """Yield which sessions were not compared, and why: those alike in one line, or each with its file."""
    if verbose:
        yield from (f"not compared: {arm.sessions[k].path}: {reason}" for k, reason in arm.left_out)
        return
    alike: dict[str, list[int]] = {}
    for session, reason in arm.left_out:
        alike.setdefault(reason, []).append(session + 1)
    for reason, numbers in alike.items():
        word = "session" if len(numbers) == 1 else "sessions"
        which = enumerate_words(numbers) if len(numbers) <= MOST_NAMED else f"{len(numbers)} of them"
        yield f"not compared: {word} {which}: {reason}"


Row = dict[str, Any]
COLUMNS: Mapping[str, type] = {
    "robot": str,
    "session": int,
    "start": str,
    "start_s": float,
    "start_from": str,
    "path": str,
    "sha256": str,
    "duration_s": float,
    "rate_hz": float,
    "drive": str,
    "torque": str,
    "gravity": str,
    "inertia": str,
    "payload": str,
    "session_temperature_c": float,
    "note": str,
    "damaged": bool,
    "compared": bool,
    "reference": bool,
    "left_out": str,
    "joint": int,
    "name": str,
    "cycles": int,
    "moving_s": float,
    "speed_lower_quartile_rad_s": float,
    "speed_median_rad_s": float,
    "speed_upper_quartile_rad_s": float,
    "temperature_c": float,
    "reason": str,
    "verdict": str,
    "effects": str,
    "coefficient": str,
    "unit": str,
    "value": float,
    "ci95_low": float,
    "ci95_high": float,
    "relative_change_within_session": float,
    "relative_change_within_session_low": float,
    "relative_change_within_session_high": float,
    "compared_value": float,
    "compared_ci95_low": float,
    "compared_ci95_high": float,
    "relative_deviation": float,
    "outside": bool,
    "isolated": bool,
}
"""Columns and what is in them; text is empty where there is nothing to say, a number or a flag None."""


ROWS_AT_ONCE = 2000


def session_columns(summary: BatchSummary) -> Iterator[dict[str, list[Any]]]:
    """Yield the table by columns, those of COLUMNS, some rows after the other.

    A coefficient is given twice: as the session has it, and as it was compared, at like temperature.
    """
    rows = _rows(summary)
    while lot := list(islice(rows, ROWS_AT_ONCE)):
        yield {name: [_plain(row[name]) for row in lot] for name in COLUMNS}


def _plain(value: Any) -> Any:  # noqa: ANN401 - any cell
    return encodable(value) if isinstance(value, str) else value


def write_session_csv(summary: BatchSummary, file: TextIO) -> None:
    """Write the table as CSV; an empty cell where there is no number."""
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([csv_cell(row[name]) for name in COLUMNS] for row in _rows(summary))


def _rows(summary: BatchSummary) -> Iterator[Row]:
    for arm in summary.arms:
        compared = _compared_values(arm)
        used, reference, left_out = set(arm.compared), set(arm.reference), dict(arm.left_out)
        for index, session in enumerate(arm.sessions):
            parts = {
                "compared": index in used,
                "reference": index in reference,
                "left_out": left_out.get(index, ""),
            }
            head = _session_cells(index, session) | parts
            for joint in session.joints:
                for coefficient in UNITS:
                    own = compared.get((joint.joint, coefficient, index), {})
                    yield head | _joint_cells(joint) | _coefficient_cells(joint, coefficient) | _compared_cells(own)


def _session_cells(index: int, session: Session) -> Row:
    conditions = session.conditions
    return {
        "robot": session.robot,
        "session": index + 1,
        "start": iso_start(session.start_s) or "",
        "start_s": session.start_s,
        "start_from": session.start_from,
        "path": session.path,
        "sha256": session.sha256,
        "duration_s": session.duration_s,
        "rate_hz": conditions.rate_hz,
        "drive": conditions.drive,
        "torque": conditions.torque,
        "gravity": conditions.gravity,
        "inertia": conditions.inertia,
        "payload": conditions.payload,
        "session_temperature_c": session.temperature_c,
        "note": session.note,
        "damaged": session.damaged,
    }


def _joint_cells(joint: JointSummary) -> Row:
    lower, median, upper = (_number(value) for value in joint.speed_rad_s)
    return {
        "joint": joint.joint,
        "name": joint.name,
        "cycles": joint.cycles,
        "moving_s": _number(joint.moving_s),
        "speed_lower_quartile_rad_s": lower,
        "speed_median_rad_s": median,
        "speed_upper_quartile_rad_s": upper,
        "temperature_c": _number(joint.temperature_c),
        "reason": joint.reason,
        "verdict": joint.verdict or "",
        "effects": " ".join(joint.effects),
    }


def _coefficient_cells(joint: JointSummary, coefficient: str) -> Row:
    own = joint.coefficients.get(coefficient, UNDETERMINED)
    within = joint.within.get(coefficient, UNDETERMINED)
    return {
        "coefficient": coefficient,
        "unit": UNITS[coefficient],
        "value": _number(own.value),
        "ci95_low": _number(own.low),
        "ci95_high": _number(own.high),
        "relative_change_within_session": _number(within.value),
        "relative_change_within_session_low": _number(within.low),
        "relative_change_within_session_high": _number(within.high),
    }


def _compared_values(arm: ArmDrift) -> dict[tuple[int, str, int], Row]:
    """Return what each session was compared as, by joint, coefficient and session."""
    found: dict[tuple[int, str, int], Row] = {}
    for joint in arm.joints:
        for one in joint.coefficients:
            isolated = set(one.isolated)
            for index, value in zip(one.sessions, one.values, strict=True):
                key = (joint.joint, one.coefficient, index)
                found[key] = {"value": value, "isolated": index in isolated}
            for point in one.control:
                key = (joint.joint, one.coefficient, point.session)
                found.setdefault(key, {}).update(outside=point.outside, relative=point.relative.value)
    return found


def _compared_cells(own: Mapping[str, Any]) -> Row:
    value = own.get("value", UNDETERMINED)
    return {
        "compared_value": _number(value.value),
        "compared_ci95_low": _number(value.low),
        "compared_ci95_high": _number(value.high),
        "relative_deviation": _number(own.get("relative")),
        "outside": own.get("outside"),
        "isolated": own.get("isolated"),
    }


def _number(value: float | None) -> float | None:
    """Return a number, or None where there is none."""
    return None if value is None or not math.isfinite(value) else float(value)
