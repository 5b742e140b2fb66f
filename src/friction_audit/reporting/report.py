"""LogReport: what a log says, from one reading and one estimate, all parts of it; its document and tables for files."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from friction_audit.compensation.result import JointReplay
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.errors import AnalysisError, FrictionAuditError, bug
from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.io.writers.tables import TidyTable
from friction_audit.pipeline import Diagnosis, Estimate, LogReplay, diagnose_estimate, replay_estimate
from friction_audit.reporting import SECTIONS
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.reporting.diagnosis_tables import TONES, WORDS, effect_rows
from friction_audit.reporting.diagnosis_words import joint_message, plain_names
from friction_audit.reporting.documents import SETTINGS, SOURCE, WARNINGS, settings_document
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.notices import Notice, diagnose_notices, estimate_notices, replay_notices, text_of
from friction_audit.reporting.replay import REPLAY
from friction_audit.reporting.table import JOINTS, Column, Document, Record, Tone
from friction_audit.reporting.words import count_of, enumerate_words, with_unit

T = TypeVar("T")
Step = Callable[[str], AbstractContextManager[Callable[[float], None] | None]]
"""Takes the name of a step and returns what is entered while it is under way: what takes the share done, or None."""


class Unanswered(NamedTuple):
    """A part of the report that has no answer: its name and why; the traceback if a bug ended it."""

    part: str
    message: str
    traceback: str = ""


class JointReport(NamedTuple):
    """What is reported of one joint, None where a part has no answer."""

    joint: int
    name: str
    friction: JointFriction
    diagnosis: JointDiagnosis | None
    replay: JointReplay | None

    @property
    def answer(self) -> str:
        """What the nominal model misses, its size and what to do; empty where that was not tested."""
        found = self.diagnosis
        # That a joint did not move needs to be reported once.
        once = found is None or (found.verdict == "not_testable" and self.friction.reason)
        text = "" if found is None or once else plain_names(joint_message(found))
        return text.replace("(model.toml)", "(model.toml of diagnose -o)")  # which the report does not write


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogReport:
    """What a log says."""

    estimate: Estimate  # friction
    diagnosis: Diagnosis | None = None  # what the nominal model misses, or None without an answer
    replay: LogReplay | None = None  # what a compensator would have done, or None without an answer
    unanswered: tuple[Unanswered, ...] = ()  # why there is no answer, of the parts that are None
    sections: tuple[str, ...] = SECTIONS  # which sections were asked for, of SECTIONS
    reading: Mapping[str, object] = field(default_factory=dict)  # how the log was read: options of the reader by name
    command: str = ""  # the command that makes the report again; empty if there was none

    @property
    def unit(self) -> str:
        """Unit of the torque."""
        return self.estimate.log.source.torque_unit

    @property
    def joints(self) -> tuple[JointReport, ...]:
        """What is reported of each joint."""
        missing = {} if self.diagnosis is None else {one.joint: one for one in self.diagnosis.joints}
        replayed = {} if self.replay is None else {one.joint: one for one in self.replay.replay.joints}
        return tuple(
            JointReport(one.joint, one.name, one, missing.get(one.joint), replayed.get(one.joint))
            for one in self.estimate.friction.joints
        )


def report_estimate(
    estimate: Estimate,
    replay_settings: ReplaySettings,
    diagnosis_settings: DiagnosisSettings,
    *,
    sections: Sequence[str] = SECTIONS,
    reading: Mapping[str, object] | None = None,
    command: str = "",
    step: Step = lambda _: nullcontext(),
) -> LogReport:
    """Run what follows an estimate, for the sections asked for; a part without an answer leaves the others."""
    unanswered: list[Unanswered] = []
    log, seen = estimate.log, estimate.interaction
    path, name = log.source.path, name_of_log(Path(log.source.path))  # a page is sent to others: without the folder
    renamed = replace(seen, warnings=tuple(one.renamed(path, name) for one in seen.warnings))
    estimate = replace(estimate, log=replace(log, source=replace(log.source, path=name)), interaction=renamed)
    known = any(not joint.reason for joint in estimate.friction.joints)
    replay = diagnosis = None
    if "compensator" in sections and known:
        with step("replay"):
            replay = _answer("replay", lambda: replay_estimate(estimate, replay_settings), unanswered)
    if "diagnosis" in sections and known:
        with step("diagnose") as share:
            diagnosis = _answer("diagnose", lambda: diagnose_estimate(estimate, diagnosis_settings, share), unanswered)
    return LogReport(
        estimate=estimate, diagnosis=diagnosis, replay=replay, unanswered=tuple(unanswered), reading=reading or {},
        sections=tuple(name for name in SECTIONS if name in sections), command=command,
    )  # fmt: skip


def _answer(part: str, compute: Callable[[], T], unanswered: list[Unanswered]) -> T | None:
    """Return a part of the report, or None and why: the page shows it in the part's place."""
    try:
        return compute()
    except AnalysisError as error:
        unanswered.append(Unanswered(part, str(error)))
    except (FrictionAuditError, MemoryError, Warning):  # warnings are errors where the tests run
        raise
    except Exception as error:  # noqa: BLE001 - reported as a bug: on the page, with traceback and exit code 1
        unanswered.append(Unanswered(part, *bug(part, error)))
    return None


def name_of_log(path: Path) -> str:
    """Return what a file or folder is called, also where it is given as ``.`` or ``..``."""
    return path.name if path.name not in ("", "..") else path.resolve().name


def report_notices(report: LogReport) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to all parts of the report, each once."""
    every = estimate_notices(report.estimate)
    every += () if report.diagnosis is None else diagnose_notices(report.diagnosis)
    every += () if report.replay is None else replay_notices(report.replay)
    return tuple(dict.fromkeys(every))


ESTIMATED, NO_ESTIMATE = "estimated", "no estimate"
VERDICT_TONES: Mapping[str, Tone] = {**TONES, NO_ESTIMATE: "off", ESTIMATED: "fine"}
# Answers that a lead gives for joints one by one, joints that it lists, characters of such answers; more are counted.
MOST_GROUPS, MOST_LISTED, LONGEST = 4, 8, 160


def verdict_word(joint: JointReport) -> str:
    """Return the verdict of a joint in a word or two."""
    if joint.diagnosis is not None and joint.diagnosis.verdict != "not_testable":
        return WORDS[joint.diagnosis.verdict]
    if joint.friction.reason:
        return NO_ESTIMATE
    return ESTIMATED if joint.diagnosis is None else WORDS["not_testable"]


def friction_words(friction: JointFriction) -> str:
    """Return the coefficients with their intervals, or why there are none."""
    if friction.reason:
        return f"{NO_ESTIMATE}: {text_of(friction.reason)}"
    found = (("Coulomb", friction.coulomb, "N m"), ("viscous", friction.viscous, "N m s/rad"))
    return ", ".join(f"{name} {with_unit(value, unit)}" for name, value, unit in found if not math.isnan(value.value))


def joint_words(one: JointReport) -> str:
    """Return coefficients and verdict of a joint; why there is no estimate stands elsewhere."""
    return verdict_word(one) if one.friction.reason else f"{friction_words(one.friction)}; {verdict_word(one)}"


def lead_sentence(report: LogReport) -> str:
    """Return the answer for the whole log, in two sentences."""
    joints = report.joints
    known = [one for one in joints if not one.friction.reason]
    if not known:
        return "Friction is estimated on no joint."
    alone, where = len(joints) == 1, _joints(known, len(joints))
    if len(known) < len(joints):
        where = f"{len(known)} of {len(joints)} joints{f': {where}' if len(known) <= MOST_LISTED else ''}"
    estimated = f"Friction is estimated{f': {friction_words(known[0].friction)}' if alone else f' on {where}'}."
    groups: dict[str, list[JointReport]] = {}
    judged = [one for one in joints if verdict_word(one) != NO_ESTIMATE]  # the diagnosis needs no estimate
    for one in judged:
        if one.diagnosis is not None:
            groups.setdefault(_missing(one.diagnosis), []).append(one)
    parts = "; ".join(words if alone else f"{words} on {_joints(own, len(joints))}" for words, own in groups.items())
    if len(groups) > MOST_GROUPS or len(parts) > LONGEST:
        words = [verdict_word(one) for one in judged]
        counts = "; ".join(f"{word}: {count_of(words.count(word), 'joint')}" for word in dict.fromkeys(words))
        return f"{estimated} {counts[:1].upper()}{counts[1:]}."
    return plain_names(f"{estimated} {parts[:1].upper()}{parts[1:]}.") if parts else estimated


def _missing(found: JointDiagnosis) -> str:
    names = enumerate_words(row.names for row in effect_rows([found]))
    if found.verdict == "unexplained":
        return f"an unexplained effect is missing{f' in addition to {names}' if names else ''}"
    return {
        "adequate": "the model is adequate",
        "not_testable": "the model cannot be tested",
        "data_fault": "the data are inconsistent",
        "failed": "the diagnosis failed",
    }.get(found.verdict, f"the model misses {names}")


def _joints(joints: Sequence[JointReport], every: int) -> str:
    if MOST_LISTED < len(joints) < every:
        return count_of(len(joints), "joint")
    numbers = enumerate_words(one.joint for one in joints)
    return f"all {every} joints" if len(joints) == every else f"joint{'s' if len(joints) > 1 else ''} {numbers}"


def report_settings(report: LogReport) -> dict[str, Any]:
    """Return every setting of every part, defaults included."""
    settings = settings_document(report.estimate, report.reading)
    settings |= {} if report.diagnosis is None else DIAGNOSE.settings(report.diagnosis)
    return settings | ({} if report.replay is None else REPLAY.settings(report.replay))


def report_tables(report: LogReport) -> tuple[TidyTable, ...]:
    """Return the tables of all parts for files; a part without an answer has none."""
    parts = ((ESTIMATE, report.estimate), (REPLAY, report.replay), (DIAGNOSE, report.diagnosis))
    return tuple(table for document, found in parts if found is not None for table in document.tables(found))


UNANSWERED = Record(Column("part", str, "the command"), Column("message", str, "why it has no answer"))
VERDICT = Record(
    *JOINTS,
    Column("coulomb", Coefficient, get="friction.coulomb", unit="N m", title="Coulomb", on="p"),
    Column("viscous", Coefficient, get="friction.viscous", unit="N m s/rad", on="p"),
    Column("verdict", str, "the verdict of the page", verdict_word, tone=VERDICT_TONES, on="jfp"),
    Column("message", str, "cause, size, what to do; or why not", lambda j: j.answer or friction_words(j.friction)),
    Column("answer", str, title="cause, size, what to do", words=True, on="p"),
)  # fmt: skip

REPORT = Document(
    "report/4",
    "All parts of a report, as on its page",
    Column("command", str, "the command that makes the report again", null=True),
    SOURCE._replace(get="estimate.log"),
    SETTINGS._replace(get=report_settings),
    WARNINGS._replace(get=report_notices),
    Column("message", str, "the lead of the page", lead_sentence),
    Column("sections", [str], "sections that were asked for"),
    Column("unanswered", [UNANSWERED], "parts without an answer; each is null"),
    Column("joints", [VERDICT], "per joint"),
    # The keys of each part, without those that the whole document has once.
    Column("estimate", ESTIMATE.own, "document of `estimate` without the shared keys"),
    Column("diagnose", DIAGNOSE.own, "document of `diagnose` likewise", "diagnosis", null=True),
    Column("replay", REPLAY.own, "document of `replay` likewise", null=True),
)
