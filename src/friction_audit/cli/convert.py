"""``friction-audit convert``."""

from pathlib import Path
from typing import Annotated

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import say_table
from friction_audit.cli.outputs import show
from friction_audit.cli.parameters import OUTPUT, flag, parse_joints
from friction_audit.joint_numbers import require_joints

EXAMPLES = """Examples:
  friction-audit convert run.bag run.parquet
  friction-audit convert run.mcap part.csv --t-start 10 --t-end 70 --joints 7
  friction-audit convert --list-dialects"""


def _list_dialects(wanted: bool) -> None:
    if wanted:
        from friction_audit.io.writers.write_log import WRITERS

        say_table([(writer.name, writer.suffix or "(folder)", writer.summary) for writer in WRITERS])
        raise typer.Exit


def command(
    log: opt.LogPath,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The new log; its suffix chooses the format.")],
    selection: opt.SelectionOptions,
    reading: opt.ReadingOptions,
    general: opt.GeneralOptions,
    dialect: opt.Dialect = None,
    list_dialects: bool = flag(  # noqa: ARG001 - its callback acts on it
        "List what --dialect takes and stop.", "--list-dialects", callback=_list_dialects, is_eager=True, panel=OUTPUT
    ),
    overwrite: opt.Overwrite = False,
) -> None:
    """Convert a log to Parquet, CSV, MCAP, NumPy or a ROS bag."""
    from friction_audit.io.writers.write_log import choose_writer, write_log
    from friction_audit.reporting.documents import CONVERT

    voice, joints = general.voice, parse_joints(selection.joints)
    options, writer = chain.read_options(reading, selection), choose_writer(out, dialect)
    for one in (log, *(reading.join or ())):
        chain.check_outputs([out], overwrite=overwrite, log=one, folder=not writer.suffix)
    kept = chain.read(log, options, voice)
    if joints is not None:
        require_joints(joints, len(kept.joint_names), f"--joints {selection.joints}: {kept.source.path}")
        kept = kept.take_joints([joint - 1 for joint in joints])
    with voice.step(f"write {out}"):
        write_log(kept, out, dialect=writer.name, overwrite=overwrite)
    document = CONVERT.json({"source": kept, "output": {"path": str(out), "writer": writer, "log": kept}})
    voice.warn((warning["message"] for warning in document["warnings"]), held=True)
    show(lambda: document, lambda: [str(out)], voice)
    chain.conclude(kept)
