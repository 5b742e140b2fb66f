"""LogReport: what a log says, from one reading and one estimate, all parts of it."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from friction_audit.compensation.result import JointReplay
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.diagnosis.result import JointDiscrepancy
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.errors import AnalysisError, FrictionAuditError, bug_sentence, traced
from friction_audit.friction.history import JointFriction
from friction_audit.pipeline import Diagnosis, Estimate, LogReplay, diagnose_estimate, replay_estimate
from friction_audit.reporting.terminal.plain import Notice, diagnose_notices, estimate_notices, replay_notices

T = TypeVar("T")
Step = Callable[[str], AbstractContextManager[object]]
"""Takes the name of a step and returns what is entered while it is under way."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Unanswered:
    """A part of the report that has no answer: its name and why; the traceback if a bug ended it."""

    part: str
    message: str
    traceback: str = ""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogReport:
    """What a log says.

    Attributes:
        estimate: Friction.
        diagnosis: What the declared model misses, or None without an answer.
        replay: What a compensator would have done, or None without an answer.
        unanswered: Why there is no answer, of the parts that are None.
        reading: How the log was read: options of the reader by name.
        command: The command that makes the report again; empty if there was none.
    """

    estimate: Estimate
    diagnosis: Diagnosis | None = None
    replay: LogReplay | None = None
    unanswered: tuple[Unanswered, ...] = ()
    reading: Mapping[str, object] = field(default_factory=dict)
    command: str = ""

    @property
    def file_name(self) -> str:
        """What the log's file, or folder, is called."""
        return name_of_log(Path(self.estimate.log.source.path))

    @property
    def joints(self) -> tuple["JointReport", ...]:
        """What is said of each joint."""
        missing = {} if self.diagnosis is None else {one.joint: one for one in self.diagnosis.discrepancy.joints}
        replayed = {} if self.replay is None else {one.joint: one for one in self.replay.replay.joints}
        return tuple(
            JointReport(friction=one, discrepancy=missing.get(one.joint), replay=replayed.get(one.joint))
            for one in self.estimate.friction.joints
        )


def report_estimate(
    estimate: Estimate,
    replay_settings: ReplaySettings,
    diagnosis_settings: DiagnosisSettings,
    *,
    reading: Mapping[str, object] | None = None,
    command: str = "",
    step: Step = nullcontext,
) -> LogReport:
    """Run what follows an estimate; a part without an answer leaves the others as they are.

    Args:
        estimate: The estimate.
        replay_settings: Of the replay.
        diagnosis_settings: Of the diagnosis.
        reading: How the log was read: options of the reader by name.
        command: The command that makes the report again.
        step: Told which part is under way.
    """
    unanswered: list[Unanswered] = []
    with step("replay"):
        replay = _answer("replay", lambda: replay_estimate(estimate, replay_settings), unanswered)
    with step("diagnose"):
        diagnosis = _answer("diagnose", lambda: diagnose_estimate(estimate, diagnosis_settings), unanswered)
    return LogReport(
        estimate=estimate,
        diagnosis=diagnosis,
        replay=replay,
        unanswered=tuple(unanswered),
        reading=reading or {},
        command=command,
    )


def _answer(part: str, compute: Callable[[], T], unanswered: list[Unanswered]) -> T | None:
    """Return a part of the report, or None and why: the page says it in the part's place."""
    try:
        return compute()
    except AnalysisError as error:
        unanswered.append(Unanswered(part=part, message=str(error)))
    except (FrictionAuditError, MemoryError, Warning):  # warnings are errors where the tests run
        raise
    except Exception as error:  # noqa: BLE001 - reported as a bug: on the page, with traceback and exit code 1
        unanswered.append(Unanswered(part=part, message=bug_sentence(part, error), traceback=traced(error)))
    return None


def name_of_log(path: Path) -> str:
    """Return what a file or folder is called, also where it is given as ``.`` or ``..``."""
    return path.name if path.name not in ("", "..") else path.resolve().name


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointReport:
    """What is said of one joint, None where a part has no answer."""

    friction: JointFriction
    discrepancy: JointDiscrepancy | None
    replay: JointReplay | None


def report_notices(report: LogReport) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to all parts of the report, each once."""
    every = estimate_notices(report.estimate)
    every += () if report.diagnosis is None else diagnose_notices(report.diagnosis)
    every += () if report.replay is None else replay_notices(report.replay)
    return tuple(dict.fromkeys(every))
