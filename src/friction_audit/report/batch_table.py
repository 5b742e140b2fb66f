"""BatchSummary -> the table and the sentences that people read."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.report.batch_summary import BatchSummary
from friction_audit.report.drift_words import (
    arm_sentence,
    change_text,
    coefficient_name,
    coefficient_unit,
    count_of,
    drift_verdict,
    enumerate_words,
    format_slope,
    joint_sentence,
    smallest_text,
    span_of,
    total_text,
    trend_text,
)
from friction_audit.report.estimate_table import NOTHING, joint_label
from friction_audit.report.plain_table import plain_lines

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
