"""``friction-audit report``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit.cli import chain, choices
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.choices import option
from friction_audit.cli.config import command_line
from friction_audit.cli.console import Voice, say
from friction_audit.cli.diagnose import joint_bugs
from friction_audit.cli.export_files import ExportPlan, write_exports
from friction_audit.cli.options import NO_EXPORT, OUTPUT, AuditOptions, CycleOptions, Exports, LogPath
from friction_audit.cli.replay_settings import ReplayOptions, replay_settings

if TYPE_CHECKING:
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import Estimate
    from friction_audit.reporting.report import LogReport

EXAMPLES = """Examples:
  friction-audit report run.mcap
  friction-audit report run.csv --drive robot -o results
  friction-audit report run.parquet --joints 1,3-5 --format html,pdf
  friction-audit report run.bag --json | jq '.joints[] | {joint, verdict}'"""

DEFAULT = "html"
FORMATS = tuple(choices.REPORT_FORMATS)
PARTS = 4
"""Stages before anything is written: read, estimate, replay, diagnose."""
NOT_PART_OF_IT = ("json", "quiet", "verbose", "overwrite", "config")
"""Parameters that change nothing in the report; what a file of values held is written out."""


def command(
    context: typer.Context,
    log: LogPath,
    shared: AuditOptions,
    formats: Annotated[
        list[str],
        option(
            OUTPUT,
            "Formats of the report; repeatable, or separated by commas. Default: html.",
            "--format",
            some_of=FORMATS,
        ),
    ] = [],  # noqa: B006 - Typer copies it
    folder: Annotated[
        Path | None,
        option(
            OUTPUT,
            "Folder of the report, whose file is called as the log is, e.g. run.report.html. Default: where you "
            "are; with --json alone no file is written.",
            "--output",
            "-o",
            metavar="DIR",
        ),
    ] = None,
    export: Exports = NO_EXPORT,
) -> None:
    """Write all that a log says on one HTML page: friction, compensator, what the model misses, how sure we are."""
    voice = shared.general.voice
    settings, options, output = audit_settings(shared), read_options(shared.reading, shared.selection), shared.output
    files = _files(log, folder, formats, printed=output.json)
    plan = _plan(log, folder, export)
    outputs = *files.values(), *plan.files(choices.REPORT_TABLES)
    chain.check_outputs(outputs, overwrite=output.overwrite, log=log)
    with voice.stages(PARTS + len(files) + len(plan.kinds)) as told:
        with chain.loading("friction_audit.friction.estimate", "friction_audit.diagnosis.diagnose"):
            recorded = chain.read(log, options, told)
        estimate = chain.estimate(recorded, settings, told)
        if not output.json:
            chain.warn_about(estimate, told)
        again = command_line(context, leave_out=NOT_PART_OF_IT)
        report = _report(estimate, shared.cycles, chain.reading_settings(options), again, told)
        _write(report, files, told, overwrite=output.overwrite)
        exported = _export(report, plan, recorded, told, overwrite=output.overwrite)
    _print(report, (*files.values(), *exported), json=output.json)
    bugs = [] if report.diagnosis is None else joint_bugs(report.diagnosis)
    chain.exit_for_bugs([*((one.message, one.traceback) for one in report.unanswered if one.traceback), *bugs], voice)
    chain.require_an_estimate(estimate)
    chain.exit_if_damaged(recorded)


def _report(
    estimate: "Estimate", cycles: CycleOptions, reading: dict[str, object], command: str, voice: Voice
) -> "LogReport":
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.reporting.report import report_estimate

    settings = replay_settings(ReplayOptions(), cycles)
    return report_estimate(estimate, settings, DiagnosisSettings(), reading=reading, command=command, step=voice.step)


def _export(
    report: "LogReport", plan: ExportPlan, recorded: "JointLog", voice: Voice, *, overwrite: bool
) -> list[Path]:
    from friction_audit.reporting.report import report_tables

    return write_exports(plan, report_tables(report), recorded, voice, overwrite=overwrite)


def _plan(log: Path, folder: Path | None, kinds: Sequence[str]) -> ExportPlan:
    """Return what is written beside the report, called as it is."""
    name = f"{_stem(log)}.report"
    return ExportPlan(folder=folder or Path(), name=name, prefix=f"{name}.", kinds=kinds)


def _files(log: Path, folder: Path | None, formats: Sequence[str], *, printed: bool) -> dict[str, Path]:
    """Return the file of each format; none where the document is printed and nothing else was asked for."""
    wanted = formats or ([] if printed and folder is None else [DEFAULT])
    return {name: (folder or Path()) / f"{_stem(log)}.report{choices.REPORT_FORMATS[name]}" for name in wanted}


def _stem(log: Path) -> str:
    """Return what the files of a report begin with: the name of the log without its ending."""
    from friction_audit.reporting.report import name_of_log

    name = name_of_log(log)
    return name if log.is_dir() else Path(name).stem


def _write(report: "LogReport", files: dict[str, Path], voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.io.files import whole_file
    from friction_audit.reporting.report_files import REPORT_FORMATS

    for name, path in files.items():
        _, write = REPORT_FORMATS[name]
        with voice.step(f"write {path}"), whole_file(path, overwrite=overwrite) as draft:
            draft.write_bytes(write(report))


def _document(report: "LogReport") -> str:
    from friction_audit.reporting.documents import write_document
    from friction_audit.reporting.report import report_document

    return write_document(report_document(report))


def _print(report: "LogReport", paths: Sequence[Path], *, json: bool) -> None:
    """Print the document, or what the report says and where it is."""
    if json:
        say(_document(report), nl=False)
        return
    from friction_audit.reporting.report import lead_sentence

    say(lead_sentence(report))
    for path in paths:
        say(str(path))
