"""Drift over the sessions of a batch: its document and its text on the terminal."""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import PurePath
from statistics import median
from typing import NamedTuple

from friction_audit import __version__
from friction_audit.batch.identity import FailedLog
from friction_audit.drift.report import SHAPES, ArmDrift, ChangePoint, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting import drift_words as phrases, words
from friction_audit.reporting.drift_sessions import SESSION, SessionRow
from friction_audit.reporting.notices import ODD_TORQUE, sentence_of, sentences, text_of
from friction_audit.reporting.table import INTERVAL, Column, Document, Record, joint_column

RARE = 0.25  # share of the sessions
WIDE = 10.0  # usual intervals, from which on one does not fit
MOST_NAMED = 8  # sessions that a line names; more are counted


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSummary:
    """A batch of recordings and how the friction in them drifts."""

    arms: tuple[ArmDrift, ...]  # drift, arm by arm
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
    def sessions(self) -> tuple[Session, ...]:
        """The sessions of all arms, in order."""
        return tuple(session for arm in self.arms for session in arm.sessions)


class CoefficientRow(NamedTuple):
    """A coefficient of a joint of an arm, its place among those of the joint, and one of its steps or none."""

    arm: ArmDrift
    joint: JointDrift
    found: CoefficientDrift
    place: int
    change: ChangePoint | None = None


def coefficient_rows(arm: ArmDrift, *joints: JointDrift) -> list[CoefficientRow]:
    """Return the coefficients of some joints of an arm, or of all."""
    every = joints or arm.joints
    return [CoefficientRow(arm, joint, one, k) for joint in every for k, one in enumerate(joint.coefficients)]


CHANGE_POINT = Record(
    Column("session", int, "first session after the step", lambda change: change.session + 1),
    Column("ci95", INTERVAL, "sessions that may be it", lambda change: (change.low + 1, change.high + 1)),
    Column("before", Coefficient, "level before"),
    Column("after", Coefficient, "level after"),
    Column("relative_change", Coefficient, "change over the level before", "relative"),
    Column("p_value", float, "family-wise"),
)
CONTROL = Record(
    Column("session", int, "number of the session", lambda point: point.session + 1),
    Column("deviation", float, "from the level of the reference", "deviation.value"),
    Column("limits", INTERVAL, "where a session without drift lies", "deviation"),
    Column("relative_deviation", float, "over the level of the reference", "relative.value"),
    Column("outside", bool, "whether it is outside the limits"),
)
PLACE = Column("session", int, "number of the session", lambda row: row[0] + 1)
VALUE = Record(
    PLACE,
    Column("value", float, "as compared", "1.value"),
    Column("ci95", INTERVAL, "95 % interval", "1"),
)


def _trend_column(title: str, name: str, on: str, short: str = "") -> Column:
    """Return the column of a trend, sorted by its share of the level."""
    slope = attrgetter(name)
    share = lambda row: slope(row.found).value / (row.found.level.value or math.nan)  # noqa: E731
    text = lambda row: phrases.slope_text(row.found, slope(row.found))  # noqa: E731
    return Column(title, get="", form=text, sort=share, short=short, on=on)


def _within(row: CoefficientRow) -> tuple[int, int]:
    """Return in how many sessions a change within the session is significant, and of how many it is known."""
    own = (one for session in row.arm.sessions for one in session.joints if one.joint == row.joint.joint)
    every = (one.within.get(row.found.coefficient, UNDETERMINED) for one in own)
    known = [one for one in every if not math.isnan(one.low + one.high)]
    return sum(one.low > 0.0 or one.high < 0.0 for one in known), len(known)


# The page has three tables of it: the answer, levels and trends in numbers (n), and what is within a session (w).
FRICTION = Column("friction", str, get="found.coefficient", form=phrases.NAMES, on="tpnw")
HEAD = (joint_column("joint", on="pnw"), FRICTION)
COEFFICIENT = Record(
    Column("joint", str, get=lambda row: " " * row.place or words.joint_label(row.joint.joint, row.joint.name), on="t"),
    *HEAD,
    Column("drift", bool, "whether it drifts", "found.drift", on="j"),
    Column("verdict", phrases.VERDICTS, "word", lambda r: phrases.drift_verdict(r.found), tone=phrases.TONES, on="jtp"),
    Column("change", float, get="found", form=phrases.total_text, sort="found.total.value", on="tp"),
    Column(
        "step", str, get="found.change_points", form=lambda found: ", ".join(str(one.session + 1) for one in found),
        words=True, on="t",
    ),
    _trend_column("trend", "trend_per_session", "t", "trend\n/session"),
    Column(
        "smallest", get="found", form=phrases.smallest_text, sort="found.smallest_drift",
        title="minimum detectable", short="minimum\ndetect.", on="tp",
    ),
    Column("message", str, "one sentence", lambda row: phrases.describe(row.found, row.arm.sessions), on="jp"),
    Column("shape", SHAPES, "what describes it", "found.shape", form=phrases.SHAPES, title="described by", on="jw"),
    Column("p_value", float, "that nothing changes, family-wise", "found.p_value"),
    Column("level", Coefficient, "level in the reference", "found.level"),
    Column("change", Coefficient, "from the reference to the last sessions", "found.change"),
    Column("relative_change", Coefficient, "the same over the level", "found.total"),
    Column("trend_per_session", Coefficient, "robust slope", "found.trend_per_session"),
    Column("trend_per_day", Coefficient, "robust slope", "found.trend_per_day"),
    Column("trend_p_value", float, "that there is no straight trend", "found.trend_p_value"),
    Column("change_points", [CHANGE_POINT], "steps", "found.change_points"),
    Column("smallest_change", float, "minimum detectable change (90 % power)", "found.smallest_change"),
    Column("smallest_relative_change", float, "the same over the level", "found.smallest_drift"),
    Column(
        "relative_change_within_session", Coefficient, "warm-up, no part of the drift", "found.within",
        form=words.format_percent, title="in a session", on="jw",
    ),
    Column(
        "seen", get=_within, form=lambda seen: f"{seen[0]} of {seen[1]}" if seen[1] else "",
        sort=lambda row: _within(row)[0], title="seen in", on="w",
    ),
    Column(
        "relative_change_per_k", Coefficient, "change with temperature, taken out", "found.temperature_slope",
        form=words.format_percent, title="per K", on="jw",
    ),
    Column(
        "compared_at_temperature", float, "temperature of the comparison", "found.temperature_c", unit="°C", form=".1f",
        title="at", on="jw",
    ),
    Column(
        "relative_scatter", float, "standard deviation between sessions over the level", "found.scatter",
        form=words.format_share, title="scatter", on="jw",
    ),
    Column("control", [CONTROL], "every session against the reference", "found.control"),
    Column(
        "level in the reference", get="found", sort="found.level.value", on="n",
        form=lambda found: words.with_unit(found.level, phrases.UNITS[found.coefficient]),
    ),
    _trend_column("trend per session", "trend_per_session", "n"),
    _trend_column("per day", "trend_per_day", "n"),
    Column(
        "outside", get=lambda row: [point.outside for point in row.found.control],
        sort=lambda row: sum(point.outside for point in row.found.control), on="n",
        form=lambda outside: f"{sum(outside)} of {len(outside)}" if outside else "",
    ),
    Column("p", get=lambda row: row.found.p_value if row.found.values else None, form=words.format_p, on="n"),
    Column(
        "isolated", [int], "sessions that none of their neighbours comes near",
        lambda row: [index + 1 for index in row.found.isolated], on="j",
    ),
    Column("values", [VALUE], "as compared", lambda r: zip(r.found.sessions, r.found.values, strict=True), on="j"),
)  # fmt: skip

# A joint, and of its sessions that were diagnosed the verdicts and effects, with how often each was given.
DIAGNOSED = Record(joint_column("0"), Column("verdicts", str, get="1", on="p"), Column("effects", str, get="2", on="p"))


def _side(side: str) -> Column:
    level = attrgetter(f"change.{side}")
    text = lambda row: words.with_unit(level(row), phrases.UNITS[row.found.coefficient])  # noqa: E731
    return Column(side, get="", form=text, sort=f"change.{side}.value", on="p")


STEPS = Record(
    *HEAD,
    Column("session", get="change", form=phrases.first_after, sort="change.session", on="p"),
    Column(
        "start", get=lambda row: row.arm.sessions[row.change.session].start_s, form=words.format_start,
        title="started (UTC)", on="p",
    ),
    Column("change", get="change", form=phrases.format_change, sort="change.relative.value", on="p"),
    _side("before"),
    _side("after"),
)  # fmt: skip
ARM = Record(
    Column("robot", str, "which arm", title="arm", code=True, on="jp"),
    Column("drift", bool, "whether a joint drifts"),
    Column(
        "verdict", phrases.VERDICTS, "the strongest of its joints", tone=phrases.TONES, on="jp",
        get=lambda arm: phrases.drift_verdict(*(one for joint in arm.joints for one in joint.coefficients)),
    ),
    Column("sentence", str, get=phrases.arm_sentence, title="answer", words=True, on="p"),
    Column("message", str, "one sentence", lambda arm: f"{arm.robot}: {phrases.arm_sentence(arm)}"),
    Column("sessions", int, "number of sessions", lambda arm: len(arm.sessions)),
    Column("compared", [int], "sessions compared", lambda arm: [index + 1 for index in arm.compared]),
    Column("reference", [int], "sessions of the reference", lambda arm: [index + 1 for index in arm.reference]),
    Column(
        "left_out", [Record(PLACE, Column("reason", str, "why", lambda row: text_of(row[1])))],
        "sessions not compared, with the reason",
    ),
    Column("ordered_by", str, "`start` or `name`"),
    Column("autocorrelation", float, "of one session's scatter with the next one's"),
    Column("warnings", [str], "what limits the comparison", lambda arm: [*map(sentence_of, arm.warnings)]),
)  # fmt: skip

# An arm and a joint of it.
JOINT_DRIFT = Record(
    Column("robot", str, "which arm", "0.robot"),
    Column("joint", int, "number, from 1", "1.joint"),
    Column("name", str, "name in the log", "1.name"),
    Column("drift", bool, "whether a coefficient drifts", "1.drift"),
    Column(
        "verdict", phrases.VERDICTS, "the strongest of its coefficients",
        lambda row: phrases.drift_verdict(*row[1].coefficients),
    ),
    Column("message", str, "one sentence", lambda row: f"joint {row[1].joint}: {phrases.joint_sentence(*row)}"),
    Column("coulomb_trend_nm_per_session", Coefficient, "robust slope", "1.coefficients.0.trend_per_session"),
    Column("viscous_trend_nms_per_rad_per_session", Coefficient, "robust slope", "1.coefficients.1.trend_per_session"),
    Column(
        "change_points", [int], "first sessions after a step",
        lambda row: sorted({step.session + 1 for one in row[1].coefficients for step in one.change_points}),
    ),
    Column(
        "coefficients", {"*": COEFFICIENT}, "by name of the coefficient",
        lambda row: {one.found.coefficient: one for one in coefficient_rows(*row)},
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
    Column("drift", bool, "whether an arm drifts", lambda one: any(arm.drift for arm in one.arms)),
    Column("exceeded", [str], "limits that were exceeded, a sentence each"),
    Column("cannot_tell", [str], "limits that the sessions cannot test"),
    Column("warnings", [str], "what was noticed about the logs as a whole"),
    Column("failed", [FAILED], "files that gave no session"),
    Column("robots", [ARM], "per arm", "arms"),
    Column(
        "joints", [JOINT_DRIFT], "per joint of every arm",
        lambda one: ((arm, joint) for arm in one.arms for joint in arm.joints),
    ),
    Column(
        "sessions", [SESSION], "per session of every arm",
        lambda batch: (SessionRow(k, one) for arm in batch.arms for k, one in enumerate(arm.sessions)),
    ),
)  # fmt: skip


def write_batch_document(summary: BatchSummary) -> Iterator[str]:
    """Yield the document as text, a line per key, arm, joint and session: as a whole it may take tens of megabytes."""
    yield f'{{\n  "schema": "{BATCH.name}",\n  "version": {json.dumps(__version__)}'
    for column in BATCH.columns:
        yield f',\n  "{column.key()}": '
        if column.key() not in ("robots", "joints", "sessions"):
            yield json.dumps(column.json(summary), allow_nan=False)
            continue
        (record,) = column.kind
        rows = ",\n    ".join(json.dumps(record.json(row), allow_nan=False) for row in column.value(summary))
        yield f"[\n    {rows}\n  ]" if rows else "[]"
    yield "\n}\n"


def batch_lines(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    """Return per arm a table and its verdict in words, and the files that failed; with ``verbose`` also the reasons."""
    sessions, arms = words.count_of(len(summary.sessions), "session"), words.count_of(len(summary.arms), "arm")
    done = f"{summary.computed} computed, {summary.known} known from the ledger, {len(summary.failed)} of these failed"
    last = phrases.limit_lines(summary.exceeded, summary.cannot_tell)
    last += [f"failed: {path}: {message}" for path, message in summary.failed]
    by_arm = (line for arm in summary.arms for line in ("", *_arm_lines(arm, verbose=verbose)))
    advice = ["", sentences()["lines"]["drifts"]] if any(arm.drift for arm in summary.arms) else []
    several = ["", phrases.batch_sentence(summary.arms)] if len(summary.arms) > 1 else []
    return [f"{sessions} of {arms}: {done}", *several, *by_arm, *advice, *([""] if last else []), *last]


def _details(arm: ArmDrift, joint: JointDrift) -> Iterator[str]:
    """Yield the steps of each coefficient of a joint, or its slope if it drifts without one."""
    for found in joint.coefficients:
        name = f"joint {joint.joint}, {phrases.NAMES[found.coefficient]}"
        for one in found.change_points:
            day = f", {words.format_date(arm.sessions[one.session].start_s)}".removesuffix(f", {words.NOTHING}")
            yield f"{name}: step at session {phrases.first_after(one)}{day}: {phrases.format_change(one)}"
        if found.drift and not found.change_points:
            slopes, unit = (found.trend_per_session, found.trend_per_day), phrases.UNITS[found.coefficient]
            session, day = (f"{words.format_slope(slope)} {unit}" for slope in slopes)
            yield f"{name}: {session} per session, {day} per day"


def _arm_lines(arm: ArmDrift, *, verbose: bool) -> Iterator[str]:
    yield f"{arm.robot}: {phrases.sessions_text(arm)}; {phrases.arm_sentence(arm)}"
    yield "changes are from the reference to the last sessions; intervals are 95 %"
    yield from COEFFICIENT.people(coefficient_rows(arm), "t").lines()
    stated = [joint for joint in arm.joints if joint.drift][: phrases.MOST_STATED]  # by the sentence on the arm
    for joint in arm.joints:
        if verbose or (joint.drift and joint not in stated):
            yield f"joint {joint.joint}: {phrases.joint_sentence(arm, joint)}"
        yield from _details(arm, joint) if verbose else ()
    alike: dict[tuple[str, int | None], list[int]] = {}  # those alike in one line, or each with its file
    for session, reason in arm.left_out:
        alike.setdefault((text_of(reason), session if verbose else None), []).append(session)
    for (why, alone), sessions in alike.items():
        which = words.count_of(len(sessions), "session") if alone is None else arm.sessions[alone].path
        if alone is None and len(sessions) <= MOST_NAMED:
            named = (f"{one + 1} ({PurePath(arm.sessions[one].path).name})" for one in sessions)
            which = f"session{'s' if sessions[1:] else ''} {words.enumerate_words(named)}"
        yield f"not compared: {which}: {why}"
    yield from _odd_lines(arm)
    yield from (f"note: {sentence_of(warning)}" for warning in arm.warnings)


def _odd_lines(arm: ArmDrift) -> Iterator[str]:
    """Name each session with joints that do not fit, or with a torque whose fault few others have, and what it is.

    The torque of another joint is noise to a joint: its coefficient may be near the others, but its interval is wide.
    """
    odd = {(k, joint.joint) for joint in arm.joints for one in joint.coefficients for k in one.isolated}
    for joint, first in ((joint, joint.coefficients[0]) for joint in arm.joints if joint.coefficients):
        widths = [value.high - value.low for value in first.values]
        usual = median(widths or [0.0])
        odd |= {(k, joint.joint) for k, own in zip(first.sessions, widths, strict=True) if own > WIDE * usual}
    often = Counter(code for index in arm.compared for code in set(arm.sessions[index].codes))
    rare = {code for code in ODD_TORQUE if often[code] <= RARE * len(arm.compared)}
    for index in arm.compared:
        session, which = arm.sessions[index], words.format_date(arm.sessions[index].start_s)
        name = f"session {index + 1} ({PurePath(session.path).name if session.start_s is None else which})"
        if apart := sorted(joint for place, joint in odd if place == index):
            columns = ": exchanged columns, another sign or unit?" if apart[1:] else ""
            which = f"joint{'s' * (len(apart) > 1)} {words.enumerate_words(apart)}"
            yield f"does not fit: {name}: {which}{columns}"
        found = (one for one in session.warnings if one.code in rare and one.joint is not None)
        yield from (f"only in {name}: joint {one.joint}: {sentence_of(one)}" for one in found)
