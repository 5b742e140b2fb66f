"""Drift over the sessions of a batch as text: on the terminal, limits as sentences, and as JUnit."""

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite, nan
from xml.etree import ElementTree as ET

from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftReport, Judged, Limit, judge
from friction_audit.errors import printable
from friction_audit.friction.history import UNDETERMINED
from friction_audit.reporting import drift_words
from friction_audit.reporting.drift import COEFFICIENT, BatchSummary, coefficient_rows
from friction_audit.reporting.drift_words import NAMES, UNITS, amount, how_much, total_text, verb_of
from friction_audit.reporting.terminal_table import table_lines
from friction_audit.reporting.words import NEWTON_METRES, count_of, enumerate_words, format_slope, in_unit

MOST_NAMED = 8  # sessions that a line names; more are counted
# Of what is not kept: the element, and what it counts as. A limit that cannot be tested is an error and not skipped,
# for servers count what is skipped as passed, and the command exits with 7.
OUTCOMES = {"exceeded": ("failure", "failures"), "untestable": ("error", "errors")}


def batch_lines(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    """Return per arm a table and its verdict in words, and the files that failed; with ``verbose`` also the reasons."""
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
    yield f"{arm.robot}: {drift_words.sessions_text(arm)}; {drift_words.arm_sentence(arm)}"
    yield "changes are from the reference to the last sessions; intervals are 95 %"
    yield from table_lines(COEFFICIENT.people(coefficient_rows(arm), "t"))
    stated = next((joint for joint in arm.joints if joint.drift), None)  # by the sentence on the arm
    for joint in arm.joints:
        if verbose or (joint.drift and joint is not stated):
            yield f"joint {joint.joint}: {drift_words.joint_sentence(arm, joint)}"
        details = (line for found in joint.coefficients for line in _details(arm, found)) if verbose else ()
        yield from (f"joint {joint.joint}, {line}" for line in details)
    yield from _left_out(arm, verbose=verbose)
    yield from (f"note: {warning}" for warning in arm.warnings)


def _details(arm: ArmDrift, found: CoefficientDrift) -> Iterator[str]:
    """Yield the steps of a coefficient, or its slope if it drifts without one."""
    name, unit = drift_words.NAMES[found.coefficient], drift_words.UNITS[found.coefficient]
    yield from (f"{name}: step at {drift_words.change_text(arm, change)}" for change in found.change_points)
    if found.drift and not found.change_points:
        slopes = f"{format_slope(found.trend_per_session)} {unit} per session, {format_slope(found.trend_per_day)}"
        yield f"{name}: {slopes} {unit} per day"


def _left_out(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    """Yield which sessions were not compared, and why: those alike in one line, or each with its file."""
    if verbose:
        yield from (f"not compared: {arm.sessions[k].path}: {reason}" for k, reason in arm.left_out)
        return
    alike: dict[str, list[int]] = {}
    for session, reason in arm.left_out:
        alike.setdefault(reason, []).append(session + 1)
    for reason, numbers in alike.items():
        which = f"session{'s' if len(numbers) > 1 else ''} {enumerate_words(numbers)}"
        yield f"not compared: {which if len(numbers) <= MOST_NAMED else count_of(len(numbers), 'session')}: {reason}"


def limit_sentences(report: DriftReport, limits: Iterable[Limit]) -> tuple[tuple[str, ...], ...]:
    """Return one sentence for each coefficient beyond a limit, and for each that cannot be tested by one."""
    judged = list(judge(report, tuple(limits)))
    return tuple(tuple(_limit_sentence(one) for one in judged if one.verdict == kind) for kind in OUTCOMES)


def _limit_sentence(one: Judged) -> str:
    """Return what a limit that is not kept is exceeded by, or why it cannot be tested."""
    found, limit = one.found, one.limit
    if found is None:
        return f"the limit {limit.text}: no session has an estimate that it is meant for"
    name, change = f"{one.where}: {NAMES[found.coefficient]} friction", found.total if limit.relative else found.change
    if one.verdict == "exceeded":
        size = how_much(found.total if limit.relative else UNDETERMINED, found.change, UNITS[found.coefficient])
        sure = min(abs(change.low), abs(change.high)) >= limit.size and change.low * change.high > 0
        went = f"{verb_of(change)} by {size} since the reference"
        return f"{name} {went}, {'surely' if sure else 'probably'} beyond the limit {limit.text}"
    least = found.smallest_drift if limit.relative else found.smallest_change
    why = f"only a change of {amount(least if limit.relative else nan, least, found.coefficient)} or more is detectable"
    why += "; record more or longer sessions"
    if found.shape == "temperature":
        why = "drift and temperature cannot be separated; record sessions at like temperature"
    elif found.drift:
        why = "the reference is near zero, so there is no relative change; give a limit without %"
    elif found.shape == "too_few" or not isfinite(least):
        sessions = count_of(len(found.sessions) - len(found.isolated), "comparable session")
        return f"{name}: the limit {limit.text} cannot be tested with {sessions}; record more"
    return f"{name}: the limit {limit.text} cannot be tested: {why}"


def junit_text(command: str, report: DriftReport, limits: Sequence[Limit], unit: str = NEWTON_METRES) -> str:
    """Return the XML of the limits of a command, a suite per limit; torques are in a unit."""
    root = ET.Element("testsuites", name=f"friction-audit {command}")
    judged = list(judge(report, limits))
    for limit in limits:
        suite = ET.SubElement(root, "testsuite", name=limit.text)
        for one in judged:
            if one.limit is limit:
                _add_case(suite, command, one, unit)
    for whole in (root, *root):
        for element, counted in (("testcase", "tests"), *OUTCOMES.values()):
            whole.set(counted, str(len(whole.findall(f".//{element}"))))
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True) + "\n"


def _add_case(suite: ET.Element, command: str, one: Judged, unit: str) -> None:
    name = f"limit {one.limit.text}"
    if one.found is not None:
        name = f"joint {one.joint}: {NAMES[one.found.coefficient]} friction, {name}"
    classname = ".".join(
        printable(part).replace(".", "_") for part in ("friction-audit", command, one.robot or "no arm")
    )
    case = ET.SubElement(suite, "testcase", classname=classname, name=name)
    if one.verdict in OUTCOMES:
        sentence = printable(in_unit(_limit_sentence(one), unit))
        outcome = ET.SubElement(case, OUTCOMES[one.verdict][0], message=sentence, type=one.verdict)
        outcome.text = sentence
    elif one.found is not None:
        ET.SubElement(case, "system-out").text = f"change {in_unit(total_text(one.found), unit)}"
