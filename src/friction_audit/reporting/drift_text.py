"""Drift over the sessions of a batch: its text on the terminal."""

from collections.abc import Iterator

from friction_audit.drift.report import ArmDrift, CoefficientDrift
from friction_audit.reporting import drift_words
from friction_audit.reporting.drift import COEFFICIENT, BatchSummary, coefficient_rows
from friction_audit.reporting.terminal_table import table_lines
from friction_audit.reporting.words import count_of, enumerate_words, format_slope

MOST_NAMED = 8  # sessions that a line names; more are counted


def batch_lines(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    """Return how many sessions there were, per arm a table and its verdict in words, and the files that failed.

    Args:
        summary: The batch.
        verbose: If True, also the message of joints without drift, and why each session was left out.
    """
    sessions, arms = count_of(len(summary.sessions), "session"), count_of(len(summary.arms), "arm")
    done = f"{summary.computed} computed, {summary.known} known from the ledger, {len(summary.failed)} of these failed"
    lines = [f"{sessions} of {arms}: {done}"]
    for arm in summary.arms:
        lines += ["", *_arm_lines(arm, verbose=verbose)]
    lines += [""] * bool(summary.exceeded or summary.cannot_tell or summary.failed)
    lines += [f"limit exceeded: {sentence}" for sentence in summary.exceeded]
    lines += [f"cannot test: {sentence}" for sentence in summary.cannot_tell]
    return lines + [f"failed: {failed.path}: {failed.message}" for failed in summary.failed]


def _arm_lines(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    yield f"{arm.robot}: {sessions_text(arm)}; {drift_words.arm_sentence(arm)}"
    yield "changes are from the reference to the last sessions; intervals are 95 %"
    yield from table_lines(COEFFICIENT.people(coefficient_rows(arm), "t"))
    for joint in arm.joints:
        if joint.drift or verbose:
            yield f"joint {joint.joint}: {drift_words.joint_sentence(arm, joint)}"
            yield from (line for found in joint.coefficients for line in _details(arm, found))
    yield from _left_out(arm, verbose=verbose)
    yield from (f"note: {warning}" for warning in arm.warnings)


def sessions_text(arm: ArmDrift) -> str:
    """Return how many sessions an arm has, when they were recorded, and how many were compared."""
    span = drift_words.span_of(arm.sessions)
    return f"{count_of(len(arm.sessions), 'session')}{f', {span}' if span else ''}, {len(arm.compared)} compared"


def _details(arm: ArmDrift, found: CoefficientDrift) -> Iterator[str]:
    """Yield the steps of a coefficient, or its slope if it drifts without one."""
    name = drift_words.NAMES[found.coefficient]
    yield from (f"  {name}: step at {drift_words.change_text(arm, change)}" for change in found.change_points)
    if found.drift and not found.change_points:
        per_session = f"{format_slope(found.trend_per_session)} {drift_words.UNITS[found.coefficient]} per session"
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
