"""``friction-audit info``."""

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import DAMAGED, Voice, remark, say
from friction_audit.cli.parameters import READING, flag
from friction_audit.errors import FrictionAuditError
from friction_audit.io.files import stamp_of
from friction_audit.preprocessing.settings import GIVEN

if TYPE_CHECKING:
    from friction_audit.io.readers import ReadOptions
    from friction_audit.io.readers.reader import Topic
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import AuditSettings
    from friction_audit.reporting.info import InfoEntry, LogSummary

LARGE_BYTES = 64 << 20  # of a larger file the beginning is read; a smaller one takes less than a second
FIRST_S = 120.0  # of the beginning: the cycles and the clock of so many seconds say what the log is [s]
EXAMPLES = """Examples:
  friction-audit info run.mcap
  friction-audit info logs/*.bag --json
  friction-audit info hours.mcap --full
  friction-audit info export.csv --map dq=velocity_{i} --map tau_J=effort_{i}"""


def command(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="Log files, or directories of ROS 2 bags.")],
    selection: opt.SelectionOptions,
    reading: opt.ReadingOptions,
    torque: opt.TorqueOptions,
    cycles: opt.CycleOptions,
    general: opt.GeneralOptions,
    full: bool = flag(
        f"Read the whole of files above {LARGE_BYTES >> 20} MB, not {FIRST_S:g} s.", "--full", panel=READING
    ),
) -> None:
    """Summarise logs: format, channels, clock, joints, cycles."""
    shared = opt.LogOptions(selection=selection, reading=reading, torque=torque, cycles=cycles, general=general)
    voice = general.voice
    if len(logs) > 1:
        chain.refuse_join(reading, "these are")
    options, settings = chain.read_options(reading, selection), chain.audit_settings(shared)
    from friction_audit.io.readers import list_topics
    from friction_audit.reporting.info import InfoEntry

    entries, codes = [], []
    given, every = shlex.split(GIVEN.get()), set(map(str, logs))
    for path in logs:  # one that cannot be read becomes an entry with its message
        topics: tuple[Topic, ...] = ()
        GIVEN.set(shlex.join(word for word in given if word == str(path) or word not in every))  # what to do about it
        try:
            topics = tuple(list_topics(path)[1])
            log = chain.read(path, options, voice) if full else _read(path, options, topics, voice)
            entries.append(InfoEntry(path=str(path), topics=topics, summary=_summary(log, settings)))
        except FrictionAuditError as error:
            codes.append(error.exit_code)
            entries.append(InfoEntry(path=str(path), topics=topics, message=str(error)))
    _print(entries, voice)
    if codes:
        raise typer.Exit(max(codes) if len(codes) == len(entries) else DAMAGED)
    for entry in entries:
        if entry.summary is not None:
            chain.conclude(entry.summary.log)


def _read(path: Path, options: "ReadOptions", topics: "tuple[Topic, ...]", voice: Voice) -> "JointLog":
    """Read a log, or the part asked for or the beginning of a large one."""
    from friction_audit.joint_log import Finding

    if stamp_of(path).size <= LARGE_BYTES:
        return chain.read(path, options, voice)
    options = replace(options, hashed=False, largest_whole=-1.0)  # the part alone, of a log of any size
    part = chain.read(path, options if options.has_window else replace(options, t_end_s=FIRST_S), voice)
    rows = {topic.name: topic.messages for topic in topics}.get(part.source.topic or path.name)
    if options.has_window or (part.t[-1] < FIRST_S - 1.0 and (rows is None or len(part.t) > rows // 2)):
        return part  # as asked for, or the log is no longer
    held = "" if rows is None else f"; the file has {rows} {'messages' if part.source.topic else 'rows'}"
    message = f"the first {FIRST_S:g} s, {len(part.t)} samples{held}; --full reads the whole log"
    finding = Finding(code="first_part", message=message, amount=FIRST_S)
    return replace(part, source=replace(part.source, findings=(*part.source.findings, finding)))


def _summary(log: "JointLog", settings: "AuditSettings") -> "LogSummary":
    """Go as far along the chain as the log allows."""
    from friction_audit.pipeline import estimate_log
    from friction_audit.reporting.info import summarize_log

    try:
        found = estimate_log(log, replace(settings, friction=replace(settings.friction, compare=False)))
    except FrictionAuditError as error:
        return summarize_log(log, None, (), obstacle=str(error))
    return summarize_log(log, found.interaction, found.cycles)


def _print(entries: "list[InfoEntry]", voice: Voice) -> None:
    from friction_audit.reporting.documents import write_document
    from friction_audit.reporting.info import INFO, SHOWN, info_lines
    from friction_audit.reporting.notices import notice_lines

    if voice.json:
        say(write_document(INFO.json(entries)), nl=False)
    for entry in entries:
        if not voice.json and (entry.summary is not None or entry.topics):
            say("\n".join(info_lines(entry)))
        if entry.summary is not None:
            shown = notice_lines(notice for notice in entry.summary.notices if notice.code not in SHOWN)
            voice.warn(shown if len(entries) == 1 else [f"{entry.path}: {line}" for line in shown], held=True)
        if entry.summary is None:
            remark(f"error: {entry.message}")
