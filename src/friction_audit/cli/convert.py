"""``friction-audit convert``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit.cli import chain, choices
from friction_audit.cli.chain import read_options
from friction_audit.cli.choices import option, parse_joints
from friction_audit.cli.console import Voice, say
from friction_audit.cli.grouped_help import OUTPUT
from friction_audit.cli.options import GeneralOptions, LogPath, Overwrite, ReadingOptions, SelectionOptions
from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from friction_audit.io.writers.writer import Writer
    from friction_audit.joint_log import JointLog

EXAMPLES = """Examples:
  friction-audit convert run.bag run.parquet
  friction-audit convert run.mcap part.csv --t-start 10 --t-end 70 --joints 7
  friction-audit convert --list-dialects"""


DIRECTORY = "(folder)"


def _list_dialects(wanted: bool) -> None:
    """Print the dialects, as a table for people and for ``cut``."""
    if wanted:
        from friction_audit.io.writers.write_log import WRITERS

        width = max(len(writer.name) for writer in WRITERS)
        for writer in WRITERS:
            say(f"{writer.name:<{width}}  {writer.suffix or DIRECTORY:<9}  {writer.summary}")
        raise typer.Exit


def command(
    log: LogPath,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The new log; its suffix chooses the format.")],
    selection: SelectionOptions,
    reading: ReadingOptions,
    general: GeneralOptions,
    dialect: Annotated[
        str | None,
        option(
            OUTPUT,
            "One of --list-dialects. Default: the first one with OUT's suffix.",
            metavar="NAME",
            autocompletion=choices.completed_by(choices.dialects),
        ),
    ] = None,
    list_dialects: Annotated[  # noqa: ARG001 - its callback acts on it
        bool, option(OUTPUT, "List the dialects and stop.", "--list-dialects", callback=_list_dialects, is_eager=True)
    ] = False,
    overwrite: Overwrite = False,
) -> None:
    """Convert a log to Parquet, CSV, MCAP, NumPy or a ROS bag."""
    voice = general.voice
    options, joints = read_options(reading, selection), parse_joints(selection.joints)
    writer = _choose_writer(out, dialect)
    chain.check_outputs([out], overwrite=overwrite, log=log, folder=not writer.suffix)
    kept = _take(chain.read(log, options, voice), joints)
    _write(kept, out, writer, voice, overwrite=overwrite)
    _report(kept, out, writer, voice, json=general.json)
    chain.exit_if_damaged(kept)


def _take(log: "JointLog", joints: tuple[int, ...] | None) -> "JointLog":
    """Return the joints that were asked for."""
    count = len(log.joint_names)
    absent = [str(joint) for joint in joints or () if joint > count]
    if absent:
        raise UsageError(f"--joints {','.join(absent)}: not in {log.source.path}; its joints are 1 to {count}")
    return log if joints is None else log.take_joints([joint - 1 for joint in joints])


def _choose_writer(out: Path, dialect: str | None) -> "Writer":
    from friction_audit.io.writers.write_log import choose_writer

    return choose_writer(out, dialect)


def _write(log: "JointLog", out: Path, writer: "Writer", voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.io.writers.write_log import write_log

    with voice.step(f"write {out}"):
        write_log(log, out, dialect=writer.name, overwrite=overwrite)


def _report(log: "JointLog", out: Path, writer: "Writer", voice: Voice, *, json: bool) -> None:
    """Say what was written and what the format has no place for."""
    from friction_audit.reporting.documents import convert_document, write_document

    document = convert_document(log, str(out), writer.name, left_out=writer.left_out(log))
    if json:
        say(write_document(document), nl=False)
    else:
        voice.warn(warning["message"] for warning in document["warnings"])
        say(str(out))
