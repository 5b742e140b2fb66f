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
from friction_audit.reporting.words import NEWTON_METRES, count_of, enumerate_words, format_slope, in_unit

MOST_NAMED = 8  # sessions that a line names; more are counted
# Of what is not kept: the element, and what it counts as. A limit that cannot be tested is an error and not skipped,
# for servers count what is skipped as passed, and the command exits with 7.
OUTCOMES = {"exceeded": ("failure", "failures"), "untestable": ("error", "errors")}


def batch_lines(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    """Return per arm a table and its verdict in words, and the files that failed; with ``verbose`` also the reasons."""
    sessions, arms = count_of(len(summary.sessions), "session"), count_of(len(summary.report.arms), "arm")
    done = f"{summary.computed} computed, {summary.known} known from the ledger, {len(summary.failed)} of these failed"
    last = [f"limit exceeded: {sentence}" for sentence in summary.exceeded]
    last += [f"cannot test: {sentence}" for sentence in summary.cannot_tell]
    last += [f"failed: {path}: {message}" for path, message in summary.failed]
    by_arm = (line for arm in summary.report.arms for line in ("", *_arm_lines(arm, verbose=verbose)))
    advice = ["", drift_words.TO_DO] if any(arm.drift for arm in summary.report.arms) else []
    return [f"{sessions} of {arms}: {done}", *by_arm, *advice, *([""] if last else []), *last]


def _arm_lines(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    yield f"{arm.robot}: {drift_words.sessions_text(arm)}; {drift_words.arm_sentence(arm)}"
    yield "changes are from the reference to the last sessions; intervals are 95 %"
    yield from COEFFICIENT.people(coefficient_rows(arm), "t").lines()
    stated = next((joint for joint in arm.joints if joint.drift), None)  # by the sentence on the arm
    for joint in arm.joints:
        if verbose or (joint.drift and joint is not stated):
            yield f"joint {joint.joint}: {drift_words.joint_sentence(arm, joint)}"
        for found in joint.coefficients if verbose else ():
            yield from (f"joint {joint.joint}, {NAMES[found.coefficient]}: {line}" for line in _details(arm, found))
    alike: dict[tuple[str, int | None], list[int]] = {}  # those alike in one line, or each with its file
    for session, reason in arm.left_out:
        alike.setdefault((reason, session if verbose else None), []).append(session)
    for (reason, alone), sessions in alike.items():
        which = f"session{'s' if len(sessions) > 1 else ''} {enumerate_words(one + 1 for one in sessions)}"
        which = which if len(sessions) <= MOST_NAMED else count_of(len(sessions), "session")
        yield f"not compared: {which if alone is None else arm.sessions[alone].path}: {reason}"
    yield from (f"note: {warning}" for warning in arm.warnings)


def _details(arm: ArmDrift, found: CoefficientDrift) -> Iterator[str]:
    """Yield the steps of a coefficient, or its slope if it drifts without one."""
    yield from (f"step at {drift_words.change_text(arm, change)}" for change in found.change_points)
    if found.drift and not found.change_points:
        unit = UNITS[found.coefficient]
        session, day = format_slope(found.trend_per_session), format_slope(found.trend_per_day)
        yield f"{session} {unit} per session, {day} {unit} per day"


def limit_sentences(report: DriftReport, limits: Iterable[Limit]) -> tuple[tuple[str, ...], ...]:
    """Return one sentence for each coefficient beyond a limit, and for each that cannot be tested by one."""
    judged = list(judge(report, tuple(limits)))
    return tuple(tuple(_limit_sentence(one) for one in judged if one.verdict == kind) for kind in OUTCOMES)


def _limit_sentence(one: Judged) -> str:
    """Return what a limit that is not kept is exceeded by, or why it cannot be tested."""
    found, limit = one.found, one.limit
    if found is None:
        return f"the limit {limit.text}: no session has an estimate that it is meant for"
    change = found.total if limit.relative else found.change
    name = f"{one.robot}, joint {one.joint}: {NAMES[found.coefficient]} friction"
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
    for limit in limits:
        suite = ET.SubElement(root, "testsuite", name=limit.text)
        for one in judge(report, [limit]):
            words = () if one.found is None else (f"joint {one.joint}", f"{NAMES[one.found.coefficient]} friction, ")
            place = (printable(part).replace(".", "_") for part in ("friction-audit", command, one.robot or "no arm"))
            name = f"{': '.join(words)}limit {limit.text}"
            case = ET.SubElement(suite, "testcase", classname=".".join(place), name=name)
            if one.verdict in OUTCOMES:
                sentence = printable(in_unit(_limit_sentence(one), unit))
                ET.SubElement(case, OUTCOMES[one.verdict][0], message=sentence, type=one.verdict).text = sentence
            elif one.found is not None:
                ET.SubElement(case, "system-out").text = f"change {in_unit(total_text(one.found), unit)}"
    for whole in (root, *root):
        for element, counted in (("testcase", "tests"), *OUTCOMES.values()):
            whole.set(counted, str(len(whole.findall(f".//{element}"))))
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True) + "\n"
