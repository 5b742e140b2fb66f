"""What is in a log: its summary, document and text."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from friction_audit.io.checks.clock import DROPPED_STEPS
from friction_audit.io.readers.reader import Topic
from friction_audit.joint_log import JointLog
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction, TorqueChoice
from friction_audit.presets import PRESETS, candidates
from friction_audit.reporting.documents import WARNING, log_columns, torque_choice
from friction_audit.reporting.estimate import SIGN
from friction_audit.reporting.notices import Notice, log_notices, notice, notices
from friction_audit.reporting.table import ALL, JOINTS, Column, Document, Record
from friction_audit.reporting.words import NEWTON_METRES, count_of

SHOWN = ("first_part", "joints_left_out")  # codes of findings that have a line of their own
STALE = "stale_samples"  # code of the finding that counts repeated rows
GAP_PERIODS = 5.0  # sampling periods; a longer step of time is a gap
# Steps that scatter by less are even: stamps hold no smaller times, and their differences are rounded.
ROUNDING_S = 1e-9


class LogSummary(NamedTuple):
    """What is in a log."""

    log: JointLog  # the log
    jitter_s: float  # standard deviation of the time steps in which no sample was dropped [s]
    gaps: int  # number of steps longer than GAP_PERIODS sampling periods
    longest_gap_s: float  # the longest of them, 0 without any [s]
    stale_samples: int  # rows that only repeated the one before and were left out when the log was read
    torque: TorqueChoice | None  # how the interaction torque would be made, or None if it cannot
    joints: tuple[SimpleNamespace, ...]  # how the joints moved, as MOTION has it
    notices: tuple[Notice, ...]  # what the user must know


def summarize_log(
    log: JointLog, interaction: Interaction | None, cycles: Sequence[EnergyCycles], obstacle: str = ""
) -> LogSummary:
    """Return the summary of a log, with its interaction torque and cycles, or the obstacle to having them."""
    steps = np.diff(log.t)
    gap = steps > GAP_PERIODS * np.median(steps)
    found = (*log_notices(log), *(notices(interaction.warnings) if interaction else ()))
    if obstacle:
        found = (*found, notice("no_interaction_torque", why=obstacle))
    jitter_s = float(np.std(steps[steps <= DROPPED_STEPS * np.median(steps)]))
    stale = int(sum(one.amount or 0.0 for one in log.source.findings if one.code == STALE))
    return LogSummary(
        log=log, jitter_s=jitter_s, gaps=int(gap.sum()), longest_gap_s=float(steps[gap].max(initial=0.0)),
        stale_samples=stale, torque=interaction.choice if interaction else None, notices=found,
        joints=tuple(_motions(log, interaction, cycles)),
    )  # fmt: skip


def _motions(log: JointLog, seen: Interaction | None, cycles: Sequence[EnergyCycles]) -> Iterator[SimpleNamespace]:
    """Yield how each joint moved; None of what takes cycles, where none were looked for."""
    logged = enumerate(log.joint_names, start=1)
    named = zip(seen.joint_numbers, seen.joint_names, strict=True) if seen is not None else logged
    motion = log if seen is None else seen
    for k, (joint, name) in enumerate(named):
        own = cycles[k] if cycles else None
        yield SimpleNamespace(
            joint=joint, name=name, peak_speed_rad_s=float(np.abs(motion.dq[:, k]).max()),
            range_rad=float(np.ptp(motion.q[:, k])), moving_s=own and own.moving_s,
            cycles=own and len(own.start), open_cycles=own and int(own.open.sum()),
            rejected_cycles=own and int((own.reason != 0).sum()),
        )  # fmt: skip


class InfoEntry(NamedTuple):
    """One file asked about: its topics, and its summary or the message of why there is none."""

    path: str
    topics: Sequence[Topic] = ()
    summary: LogSummary | None = None
    message: str = ""


MOTION = Record(
    *JOINTS,
    Column("peak_speed", float, "largest speed", unit="rad/s", on=ALL),
    Column("range", float, "largest less smallest position", unit="rad", on=ALL),
    Column("moving", float, "time above the initiation threshold", unit="s", on=ALL),
    Column("cycles", int, "energy cycles", on=ALL, null=True),
    Column("open_cycles", int, "those that do not return to their start", title="not returned", on=ALL, null=True),
    Column("rejected_cycles", int, "those that an estimate rejects", title="rejected", on=ALL, null=True),
)
TOPIC = Record(
    Column("name", str, "its name"),
    Column("type", str, "its type"),
    Column("messages", int, "number of messages, null where not counted", null=True),
    Column("readable", bool, "whether it can be read as a joint log"),
)
PATH, TOPICS = Column("path", str, "path as given"), Column("topics", [TOPIC], "topics or tables of the file")
LOG = Record(
    PATH,
    TOPICS,
    # A part of a log has no hash.
    *(one.at("summary.log", null=one.null or one.name == "sha256") for one in log_columns("joint_count")[1:]),
    Column("jitter", float, "standard deviation of the time steps, drops left out", "summary.jitter_s", unit="s"),
    Column("gaps", int, "steps longer than five median ones", "summary.gaps"),
    Column("longest_gap", float, "the longest of them", "summary.longest_gap_s", unit="s"),
    Column("stale_samples", int, "repeated samples left out", "summary.stale_samples"),
    Column("clock_windows", int, "windows on which the clock was checked", "summary.log.source.clock_windows"),
    Column("torque", dict, "how the interaction torque is made, or null", torque_choice, null=True).at(
        "summary.torque"
    ),
    Column("joints", [MOTION], "per joint", "summary.joints"),
    Column("warnings", [WARNING], "what the user must know", "summary.notices"),
)
FAILED = Record(PATH, TOPICS, Column("message", str, "why it could not be read"))
INFO = Document(
    "info/1",
    "What is in some logs",
    Column("logs", [LOG], "logs that were read", lambda entries: [one for one in entries if one.summary]),
    Column("failed", [FAILED], "files that were not", lambda entries: [one for one in entries if not one.summary]),
)


def info_lines(entry: InfoEntry) -> list[str]:
    """Return what is in one file."""
    lines, summary = [entry.path], entry.summary
    if len(entry.topics) > 1 or summary is None:
        for one in entry.topics:
            messages = "" if one.messages is None else f", {count_of(one.messages, 'message')}"
            lines.append(f"  topic {one.name} ({one.type}{messages}{'' if one.readable else '; no joint log'})")
    if summary is None:
        return [*lines, "  not read"]
    facts = (f"  {name:<9}{text}" for name, text in facts_of(summary))
    return [*lines, *facts, *MOTION.people(summary.joints, "t").lines()]


def facts_of(summary: LogSummary) -> Iterator[tuple[str, str]]:
    """Yield what is in a log, each with its name."""
    log, source, torque = summary.log, summary.log.source, summary.torque
    topic = f", topic {source.topic}" if source.topic else ""
    alike = candidates(log.joint_names) if source.robot not in PRESETS else ()
    robot = source.robot + (f" (joints of {', '.join(alike)}: name it with --robot)" if alike else "")
    yield "format", f"{source.format}{topic}, robot {robot}, {count_of(len(log.joint_names), 'joint')}"
    yield from (("read", found.message) for found in source.findings if found.code in SHOWN)
    samples = f"{log.duration_s:.6g} s, {count_of(len(log.t), 'sample')}, {log.rate_hz:.6g} Hz"
    checked = f"checked on {count_of(source.clock_windows, 'window')}" if source.clock_windows else "not checked"
    yield "clock", f"{source.clock}, {samples}, {checked}"
    jitter = f"jitter {1e3 * summary.jitter_s:.3g} ms" if summary.jitter_s >= ROUNDING_S else "no jitter"
    gaps = f"{count_of(summary.gaps, 'gap')}, the longest {summary.longest_gap_s:.3g} s" if summary.gaps else "no gaps"
    yield "steps", f"{jitter}, {gaps}, {count_of(summary.stale_samples, 'repeated sample')} left out"
    yield from (("channel", f"{channel} = {name}") for channel, name in source.channels.items())
    if source.torque_unit != NEWTON_METRES:
        yield "unit", f"the torque is a motor current and is read in {source.torque_unit}"
    if torque is not None:
        yield "torque", f"{torque.formula}; drive {torque.drive}, gravity {torque.gravity}, {SIGN[torque.sign_proved]}"
