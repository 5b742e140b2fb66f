"""Drift over the sessions of a batch: its document and its text on the terminal."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from friction_audit import __version__
from friction_audit.drift.report import SHAPES, ArmDrift, CoefficientDrift, DriftReport, JointDrift
from friction_audit.drift.session import Session
from friction_audit.friction.history import Coefficient
from friction_audit.reporting import drift_words
from friction_audit.reporting.drift_sessions import SESSION, SessionRow
from friction_audit.reporting.table import INTERVAL, Column, Document, Get, Record, joint_column
from friction_audit.reporting.terminal_table import table_lines
from friction_audit.reporting.words import count_of, enumerate_words, format_slope, joint_label

MOST_NAMED = 8  # sessions that a line names; more are counted


@dataclass(frozen=True, kw_only=True, slots=True)
class FailedLog:
    """A file that gave no session."""

    path: str  # as found
    message: str  # what was wrong with it, and what to do


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSummary:
    """A batch of recordings and how the friction in them drifts."""

    report: DriftReport  # drift, arm by arm
    failed: tuple[FailedLog, ...] = ()  # files that gave no session
    exceeded: tuple[str, ...] = ()  # limits that were exceeded, a sentence each
    cannot_tell: tuple[str, ...] = ()  # limits that the sessions cannot test, a sentence each
    warnings: tuple[str, ...] = ()  # what was noticed about the logs as a whole, one sentence each
    # all settings by name, defaults included; values are numbers, words, lists or mappings of them
    settings: Mapping[str, object] = field(default_factory=dict)
    command: str = ""  # the command that makes all of it again
    computed: int = 0  # sessions computed in this run
    known: int = 0  # sessions that the ledger already held

    @property
    def arms(self) -> tuple[ArmDrift, ...]:
        """The arms, in order."""
        return self.report.arms

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The sessions of all arms, in order."""
        return tuple(session for arm in self.arms for session in arm.sessions)


class CoefficientRow(NamedTuple):
    """A coefficient of a joint of an arm, and its place among those of the joint."""

    arm: ArmDrift
    joint: JointDrift
    found: CoefficientDrift
    place: int


def coefficient_rows(arm: ArmDrift) -> list[CoefficientRow]:
    """Return the coefficients of all joints of an arm."""
    return [CoefficientRow(arm, joint, one, k) for joint in arm.joints for k, one in enumerate(joint.coefficients)]


def _numbers(name: str, meaning: str, get: Get) -> Column:
    """Return a column of sessions, which people count from 1."""
    return Column(name, [int], meaning, lambda row: [index + 1 for index in Column(name, get=get).value(row)], on="j")


def _session(row: Any) -> int:  # noqa: ANN401 - any row with a session
    return int(row.session) + 1


CHANGE_POINT = Record(
    Column("session", int, "first session after the step", _session),
    Column("ci95", INTERVAL, "sessions that may be it", lambda change: (change.low + 1, change.high + 1)),
    Column("before", Coefficient, "level before"),
    Column("after", Coefficient, "level after"),
    Column("relative_change", Coefficient, "change over the level before", "relative"),
    Column("p_value", float, "family-wise"),
)
CONTROL = Record(
    Column("session", int, "number of the session", _session),
    Column("deviation", float, "from the level of the reference", "deviation.value"),
    Column("limits", INTERVAL, "where a session without drift lies", lambda p: (p.deviation.low, p.deviation.high)),
    Column("relative_deviation", float, "over the level of the reference", "relative.value"),
    Column("outside", bool, "whether it is outside the limits"),
)
PLACE = Column("session", int, "number of the session", lambda row: row[0] + 1)
VALUE = Record(
    PLACE,
    Column("value", float, "as compared", "1.value"),
    Column("ci95", INTERVAL, "95 % interval", lambda row: (row[1].low, row[1].high)),
)


def _of_found(*columns: Column) -> tuple[Column, ...]:
    """Return columns of a document, each read from what was found of a coefficient."""
    return tuple(replace(one, get=f"found.{one.get or one.name}", on="j") for one in columns)


COEFFICIENT = Record(
    Column(
        "joint", str, get=lambda row: " " if row.place else joint_label(row.joint.joint, row.joint.name),
        title="joint", on="t",
    ),
    joint_column("joint", on="p"),
    Column("friction", str, get="found.coefficient", form=drift_words.NAMES.__getitem__, title="friction", on="tp"),
    Column("drift", bool, "whether it drifts", "found.drift", on="j"),
    Column(
        "verdict", drift_words.VERDICTS, "in a word", lambda row: drift_words.drift_verdict(row.found),
        title="verdict", tone=drift_words.TONES.__getitem__, on="jtp",
    ),
    Column(
        "change", float, get="found", form=drift_words.total_text, sort="found.total.value", title="change", on="tp"
    ),
    Column(
        "step", str, get="found.change_points", form=lambda found: ", ".join(str(_session(one)) for one in found),
        title="step", words=True, on="t",
    ),
    Column(
        "trend", get="found", form=lambda found: drift_words.slope_text(found, found.trend_per_session), title="trend",
        short="trend\n/session", on="t",
    ),
    Column(
        "smallest", get="found", form=drift_words.smallest_text, sort="found.smallest_drift",
        title="minimum detectable", short="minimum\ndetect.", on="tp",
    ),
    Column(
        "message", str, "one sentence", lambda row: drift_words.describe(row.found, row.arm.sessions),
        title="message", on="jp",
    ),
    *_of_found(
        Column("shape", SHAPES, "what describes it"),
        Column("p_value", float, "that nothing changes, family-wise"),
        Column("level", Coefficient, "level in the reference"),
        Column("change", Coefficient, "from the reference to the last sessions"),
        Column("relative_change", Coefficient, "the same over the level", "total"),
        Column("trend_per_session", Coefficient, "robust slope"),
        Column("trend_per_day", Coefficient, "robust slope"),
        Column("trend_p_value", float, "that there is no straight trend"),
        Column("change_points", [CHANGE_POINT], "steps"),
        Column("smallest_change", float, "minimum detectable change (90 % power)"),
        Column("smallest_relative_change", float, "the same over the level", "smallest_drift"),
        Column("relative_scatter", float, "standard deviation between sessions over the level", "scatter"),
        Column("relative_change_within_session", Coefficient, "warm-up, no part of the drift", "within"),
        Column("relative_change_per_k", Coefficient, "change with temperature, taken out", "temperature_slope"),
        Column("compared_at_temperature_c", float, "temperature of the comparison", "temperature_c"),
        Column("control", [CONTROL], "every session against the reference"),
    ),
    _numbers("isolated", "sessions that none of their neighbours comes near", "found.isolated"),
    Column(
        "values", [VALUE], "each session as compared",
        lambda row: zip(row.found.sessions, row.found.values, strict=True), on="j",
    ),
)  # fmt: skip
ARM = Record(
    Column("robot", str, "which arm"),
    Column("drift", bool, "whether a joint drifts"),
    Column("verdict", drift_words.VERDICTS, "the strongest of its joints", drift_words.arm_verdict),
    Column("message", str, "one sentence", lambda arm: f"{arm.robot}: {drift_words.arm_sentence(arm)}"),
    Column("sessions", int, "number of sessions", lambda arm: len(arm.sessions)),
    _numbers("compared", "sessions compared", "compared"),
    _numbers("reference", "sessions of the reference", "reference"),
    Column("left_out", [Record(PLACE, Column("reason", str, "why", "1"))], "sessions not compared, with the reason"),
    Column("ordered_by", str, "`start` or `name`"),
    Column("autocorrelation", float, "of one session's scatter with the next one's"),
    Column("warnings", [str], "what limits the comparison"),
)  # fmt: skip


class JointRow(NamedTuple):
    """A joint of an arm."""

    arm: ArmDrift
    joint: JointDrift


def _trend(name: str) -> Callable[[JointRow], Coefficient | None]:
    return lambda row: next((one.trend_per_session for one in row.joint.coefficients if one.coefficient == name), None)


JOINT_DRIFT = Record(
    Column("robot", str, "which arm", "arm.robot"),
    Column("joint", int, "number, from 1", "joint.joint"),
    Column("name", str, "name in the log", "joint.name"),
    Column("drift", bool, "whether a coefficient drifts", "joint.drift"),
    Column(
        "verdict", drift_words.VERDICTS, "the strongest of its coefficients",
        lambda row: drift_words.joint_verdict(row.joint),
    ),
    Column("message", str, "one sentence", lambda row: f"joint {row.joint.joint}: {drift_words.joint_sentence(*row)}"),
    Column("coulomb_trend_nm_per_session", Coefficient, "robust slope", _trend("coulomb_nm")),
    Column("viscous_trend_nms_per_rad_per_session", Coefficient, "robust slope", _trend("viscous_nms_per_rad")),
    Column(
        "change_points", [int], "first sessions after a step",
        lambda row: sorted({_session(step) for one in row.joint.coefficients for step in one.change_points}),
    ),
    Column(
        "coefficients", {"*": COEFFICIENT}, "by name of the coefficient",
        lambda row: {
            one.coefficient: CoefficientRow(row.arm, row.joint, one, k) for k, one in enumerate(row.joint.coefficients)
        },
    ),
)  # fmt: skip


FAILED = Record(
    Column("path", str, "as found", title="file", code=True, on="jp"),
    Column("message", str, "what was wrong", title="what was wrong", on="jp"),
)
BATCH = Document(
    "batch/2",
    "How the friction of each arm changes between recordings; sessions count from 1 within their arm",
    Column("command", str, "the command that makes all of it again", null=True),
    Column("settings", dict, "every setting, defaults included"),
    Column("computed", int, "sessions computed in this run"),
    Column("known", int, "sessions that the ledger held"),
    Column("drift", bool, "whether an arm drifts", "report.drift"),
    Column("exceeded", [str], "limits that were exceeded, a sentence each"),
    Column("cannot_tell", [str], "limits that the sessions cannot test"),
    Column("warnings", [str], "what was noticed about the logs as a whole"),
    Column("failed", [FAILED], "files that gave no session"),
    Column("robots", [ARM], "per arm", "arms"),
    Column(
        "joints",
        [JOINT_DRIFT],
        "per joint of every arm",
        lambda one: (JointRow(arm, joint) for arm in one.arms for joint in arm.joints),
    ),
    Column(
        "sessions",
        [SESSION],
        "per session of every arm",
        lambda one: (SessionRow(k, session) for arm in one.arms for k, session in enumerate(arm.sessions)),
    ),
)


def write_batch_document(summary: BatchSummary) -> Iterator[str]:
    """Yield the document as text in ASCII, a line for each key, arm, joint and session.

    It is never held as a whole: that of a thousand sessions takes tens of megabytes.
    """
    yield f'{{\n  "schema": "{BATCH.name}",\n  "version": {json.dumps(__version__)}'
    for column in BATCH.columns:
        yield f',\n  "{column.key}": '
        if column.key not in ("robots", "joints", "sessions"):
            yield json.dumps(column.json(summary), allow_nan=False)
            continue
        (record,) = column.kind
        lines = (json.dumps(record.json(row), allow_nan=False) for row in column.value(summary))
        first = next(lines, None)
        yield "[]" if first is None else f"[\n    {first}"
        yield from (f",\n    {line}" for line in lines)
        yield "" if first is None else "\n  ]"
    yield "\n}\n"


def batch_lines(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    """Return how many sessions there were, per arm a table and its verdict in words, and the files that failed.

    With ``verbose`` also joints without drift, steps and slopes in numbers, and why each session was left out.
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
    stated = next((joint for joint in arm.joints if joint.drift), None)  # by the sentence on the arm
    for joint in arm.joints:
        if verbose or (joint.drift and joint is not stated):
            yield f"joint {joint.joint}: {drift_words.joint_sentence(arm, joint)}"
        details = (line for found in joint.coefficients for line in _details(arm, found)) if verbose else ()
        yield from (f"joint {joint.joint}, {line}" for line in details)
    yield from _left_out(arm, verbose=verbose)
    yield from (f"note: {warning}" for warning in arm.warnings)


def sessions_text(arm: ArmDrift) -> str:
    """Return how many sessions an arm has, when they were recorded, and how many were compared."""
    span = drift_words.span_of(arm.sessions)
    return f"{count_of(len(arm.sessions), 'session')}{f', {span}' if span else ''}, {len(arm.compared)} compared"


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
