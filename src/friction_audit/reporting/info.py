"""What is in a log: its summary, document and text."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from friction_audit.io.checks.clock import DROPPED_STEPS
from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction, TorqueChoice
from friction_audit.presets import PRESETS, candidates
from friction_audit.reporting.documents import WARNING, log_columns
from friction_audit.reporting.estimate import sign_text
from friction_audit.reporting.notices import Notice, interaction_notices, log_notices
from friction_audit.reporting.table import ALL, JOINT, NAME, Column, Document, Record, joint_column
from friction_audit.reporting.terminal_table import table_lines
from friction_audit.reporting.words import NEWTON_METRES, count_of

# Codes of findings that have a line of their own.
SHOWN = ("first_part", "joints_left_out")
# Code of the finding that counts repeated rows.
STALE = "stale_samples"
# A step of time longer than this many sampling periods is a gap.
GAP_PERIODS = 5.0
# Steps that scatter by less are even: stamps hold no smaller times, and their differences are rounded.
ROUNDING_S = 1e-9


@dataclass(frozen=True, kw_only=True, slots=True)
class JointMotion:
    """How one joint moved.

    Attributes:
        joint: Number for people.
        name: Name in the log.
        peak_speed_rad_s: Largest speed, as logged. [rad/s]
        range_rad: Largest minus smallest position. [rad]
        moving_s: Time above the threshold at which a cycle begins, or None without cycles. [s]
        cycles: Energy cycles found, or None where none were looked for.
        open_cycles: Those that do not end where they began, or None.
        rejected_cycles: Those that an estimate would reject, or None.
    """

    joint: int
    name: str
    peak_speed_rad_s: float
    range_rad: float
    moving_s: float | None = None
    cycles: int | None = None
    open_cycles: int | None = None
    rejected_cycles: int | None = None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogSummary:
    """What is in a log.

    Attributes:
        log: The log.
        jitter_s: Standard deviation of the time steps in which no sample was dropped. [s]
        gaps: Number of steps longer than GAP_PERIODS sampling periods.
        longest_gap_s: The longest of them, 0 without any. [s]
        stale_samples: Rows that only repeated the one before and were left out when the log was read.
        torque: How the interaction torque would be made, or None if it cannot.
        joints: How the joints moved.
        notices: What the user must know.
    """

    log: JointLog
    jitter_s: float
    gaps: int
    longest_gap_s: float
    stale_samples: int
    torque: TorqueChoice | None
    joints: tuple[JointMotion, ...]
    notices: tuple[Notice, ...]

    @property
    def clock_text(self) -> str:
        """Clock, and on how much of the log it was checked against the motion."""
        windows = self.log.source.clock_windows
        return f"checked on {count_of(windows, 'window')}" if windows else "not checked"

    @property
    def steps_text(self) -> str:
        """Jitter and gaps."""
        jitter = f"jitter {1e3 * self.jitter_s:.3g} ms" if self.jitter_s >= ROUNDING_S else "no jitter"
        gaps = f"{count_of(self.gaps, 'gap')}, the longest {self.longest_gap_s:.3g} s" if self.gaps else "no gaps"
        return f"{jitter}, {gaps}"


def summarize_log(
    log: JointLog, interaction: Interaction | None, cycles: EnergyCycles | None, obstacle: str = ""
) -> LogSummary:
    """Return the summary of a log.

    Args:
        log: The log.
        interaction: Its interaction torque, or None if it cannot be made.
        cycles: Its cycles, or None without an interaction torque.
        obstacle: Why there is no interaction torque.
    """
    steps = np.diff(log.t)
    gap = steps > GAP_PERIODS * np.median(steps)
    notices = log_notices(log) + (interaction_notices(interaction) if interaction else ())
    if obstacle:
        notices += (Notice("no_interaction_torque", None, obstacle),)
    return LogSummary(
        log=log,
        jitter_s=float(np.std(steps[steps <= DROPPED_STEPS * np.median(steps)])),
        gaps=int(gap.sum()),
        longest_gap_s=float(steps[gap].max(initial=0.0)),
        stale_samples=int(sum(found.amount or 0.0 for found in log.source.findings if found.code == STALE)),
        torque=interaction.choice if interaction else None,
        joints=tuple(_motions(log, interaction, cycles)),
        notices=notices,
    )


def _motions(log: JointLog, interaction: Interaction | None, cycles: EnergyCycles | None) -> Iterator[JointMotion]:
    if interaction is None or cycles is None:
        for k, name in enumerate(log.joint_names):
            yield JointMotion(joint=k + 1, name=name, **_extent(log.q[:, k], log.dq[:, k]))
        return
    for k, (joint, name) in enumerate(zip(interaction.joint_numbers, interaction.joint_names, strict=True)):
        own = cycles.of_joint(k)
        yield JointMotion(
            joint=joint,
            name=name,
            **_extent(interaction.q[:, k], interaction.dq[:, k]),
            moving_s=float(cycles.moving_s[k]),
            cycles=len(own.joint),
            open_cycles=int(own.open.sum()),
            rejected_cycles=int((own.reason != 0).sum()),
        )


def _extent(q: Float, dq: Float) -> dict[str, Any]:
    return {"peak_speed_rad_s": float(np.abs(dq).max()), "range_rad": float(np.ptp(q))}


@dataclass(frozen=True, kw_only=True, slots=True)
class TopicSummary:
    """A topic (or table) found in a file; ``messages`` is None where counting would mean reading all of it."""

    name: str
    type: str
    messages: int | None
    readable: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class InfoEntry:
    """One file asked about: its topics, and its summary or the message of why there is none."""

    path: str
    topics: tuple[TopicSummary, ...] = ()
    summary: LogSummary | None = None
    message: str = ""


MOTION = Record(
    (
        JOINT,
        NAME,
        joint_column(),
        Column("peak_speed", float, "largest speed", unit="rad/s", title="peak speed", on=ALL),
        Column("range", float, "largest less smallest position", unit="rad", title="range", on=ALL),
        Column("moving", float, "time above the initiation threshold", unit="s", title="moving", on=ALL),
        Column("cycles", int, "energy cycles", title="cycles", on=ALL, null=True),
        Column("open_cycles", int, "those that do not return to their start", title="not returned", on=ALL, null=True),
        Column("rejected_cycles", int, "those that an estimate rejects", title="rejected", on=ALL, null=True),
    )
)
TOPIC = Record(
    (
        Column("name", str, "its name"),
        Column("type", str, "its type"),
        Column("messages", int, "number of messages, null where not counted", null=True),
        Column("readable", bool, "whether it can be read as a joint log"),
    )
)
PATH, TOPICS = Column("path", str, "path as given"), Column("topics", [TOPIC], "topics or tables of the file")


def _of_log(column: Column, entry: InfoEntry) -> object:
    if entry.summary is None or (column.name == "sha256" and not entry.summary.log.source.sha256):
        return None
    return column.value(entry.summary.log)


LOG = Record(
    (
        PATH,
        TOPICS,
        *(
            replace(one, get=partial(_of_log, one), null=one.null or one.name == "sha256")  # not of a part
            for one in log_columns("joint_count")[1:]
        ),
        Column("jitter", float, "standard deviation of the time steps, drops left out", "summary.jitter_s", unit="s"),
        Column("gaps", int, "steps longer than five median ones", "summary.gaps"),
        Column("longest_gap", float, "the longest of them", "summary.longest_gap_s", unit="s"),
        Column("stale_samples", int, "repeated samples left out", "summary.stale_samples"),
        Column("clock_windows", int, "windows on which the clock was checked", "summary.log.source.clock_windows"),
        Column("torque", dict, "how the interaction torque is made, or null", "summary.torque", null=True),
        Column("joints", [MOTION], "per joint", "summary.joints"),
        Column("warnings", [WARNING], "what the user must know", "summary.notices"),
    )
)
FAILED = Record((PATH, TOPICS, Column("message", str, "why it could not be read")))
INFO = Document(
    "info",
    1,
    "What is in some logs",
    Record((Column("logs", [LOG], "logs that were read"), Column("failed", [FAILED], "files that were not"))),
)


def info_document(entries: Iterable[InfoEntry]) -> dict[str, Any]:
    """Return the document on some logs; those that could not be read are listed apart, with their message."""
    every = list(entries)
    read = [entry for entry in every if entry.summary is not None]
    return INFO.json({"logs": read, "failed": [entry for entry in every if entry.summary is None]})


def info_lines(entry: InfoEntry) -> list[str]:
    """Return what is in one file."""
    lines = [entry.path]
    if len(entry.topics) > 1 or entry.summary is None:
        lines += [f"  topic {_topic(topic)}" for topic in entry.topics]
    if entry.summary is None:
        return [*lines, f"  not read: {entry.message}"]
    return [
        *lines,
        *(f"  {line}" for line in _lines(entry.summary)),
        *table_lines(MOTION.people(entry.summary.joints, "t")),
    ]


def _topic(topic: TopicSummary) -> str:
    messages = "" if topic.messages is None else f", {count_of(topic.messages, 'message')}"
    return f"{topic.name} ({topic.type}{messages}{'' if topic.readable else '; no joint log'})"


def _lines(summary: LogSummary) -> Iterator[str]:
    log, source, torque = summary.log, summary.log.source, summary.torque
    topic = f", topic {source.topic}" if source.topic else ""
    alike = candidates(log.joint_names) if source.robot not in PRESETS else ()
    robot = source.robot + (f" (joints of {', '.join(alike)}: name it with --robot)" if alike else "")
    yield f"format   {source.format}{topic}, robot {robot}, {count_of(len(log.joint_names), 'joint')}"
    yield from (f"read     {found.message}" for found in source.findings if found.code in SHOWN)
    samples = f"{log.duration_s:.6g} s, {count_of(len(log.t), 'sample')}, {log.rate_hz:.6g} Hz"
    yield f"clock    {source.clock}, {samples}, {summary.clock_text}"
    yield f"steps    {summary.steps_text}, {count_of(summary.stale_samples, 'repeated sample')} left out"
    for channel, name in source.channels.items():
        yield f"channel  {channel} = {name}"
    if source.torque_unit != NEWTON_METRES:
        yield f"unit     the torque is a motor current and is read in {source.torque_unit}"
    if torque is not None:
        yield f"torque   {torque.formula}; drive {torque.drive}, gravity {torque.gravity}, {sign_text(torque)}"
