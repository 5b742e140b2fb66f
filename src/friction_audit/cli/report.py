"""``friction-audit report``."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from friction_audit.cli import chain, choices
from friction_audit.cli.command_line import command_line
from friction_audit.cli.config import dump_config
from friction_audit.cli.console import Voice
from friction_audit.cli.options import OUTPUT, AuditOptions, CycleOptions, LogPath
from friction_audit.cli.replay_settings import ReplayOptions, replay_settings
from friction_audit.cli.settings import audit_settings, read_options
from friction_audit.errors import AnalysisError

if TYPE_CHECKING:
    from friction_audit.audit import Diagnosis, Estimate, LogReplay
    from friction_audit.report.log_report import LogReport, Unanswered

EXAMPLES = """Examples:
  friction-audit report run.mcap
  friction-audit report run.csv --drive robot -o results
  friction-audit report run.parquet --joints 1,3-5 --format html,markdown
  friction-audit report run.bag --json | jq '.joints[] | {joint, verdict}'"""

T = TypeVar("T")

FORMATS = {"html": "html", "json": "json", "markdown": "md"}
"""Formats and the endings of their files."""
DEFAULT = "html"
NOT_PART_OF_IT = ("json", "quiet", "verbose", "overwrite", "config")
"""Parameters that change nothing in the report; what a file of values held is written out."""


def command(
    context: typer.Context,
    log: LogPath,
    shared: AuditOptions,
    formats: Annotated[
        list[str],
        typer.Option(
            "--format",
            metavar=choices.metavar(tuple(FORMATS)),
            callback=choices.some_of(tuple(FORMATS)),
            help="Formats of the report; repeatable, or separated by commas. Default: html.",
            rich_help_panel=OUTPUT,
        ),
    ] = [],  # noqa: B006 - Typer copies it
    folder: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="DIR",
            help="Folder of the report, whose file is called as the log is, e.g. run.report.html. Default: where you "
            "are; with --json alone no file is written.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
) -> None:
    """Write all that a log says on one HTML page: friction, compensator, what the model misses, how sure we are."""
    if shared.general.dump_config:
        typer.echo(dump_config(context), nl=False)
        return
    voice = Voice(quiet=shared.general.quiet, verbose=shared.general.verbose)
    settings, options, output = audit_settings(shared), read_options(shared.reading), shared.output
    files = _files(log, folder, formats, printed=output.json)
    chain.check_outputs(tuple(files.values()), overwrite=output.overwrite)
    with chain.loading("friction_audit.friction.estimate", "friction_audit.discrepancy.diagnose"):
        recorded = chain.read(log, options, voice)
    estimate = chain.estimate(recorded, settings, voice)
    if not output.json:
        chain.warn_about(estimate, voice)
    chain.require_an_estimate(estimate)
    report = _report(
        estimate,
        shared.cycles,
        chain.reading_settings(options),
        command_line(context, leave_out=NOT_PART_OF_IT),
        voice,
    )
    _write(report, files, voice, overwrite=output.overwrite)
    _print(report, tuple(files.values()), json=output.json)
    chain.exit_if_damaged(recorded)


def _files(log: Path, folder: Path | None, formats: Sequence[str], *, printed: bool) -> dict[str, Path]:
    """Return the file of each format; none where the document is printed and nothing else was asked for."""
    wanted = formats or ([] if printed and folder is None else [DEFAULT])
    return {name: (folder or Path()) / f"{_stem(log)}.report.{FORMATS[name]}" for name in wanted}


def _stem(log: Path) -> str:
    """Return what the files of a report begin with: the name of the log without its ending."""
    from friction_audit.report.log_report import name_of_log

    name = name_of_log(log)
    return name if log.is_dir() else Path(name).stem


def _report(
    estimate: "Estimate", cycles: CycleOptions, reading: dict[str, object], command: str, voice: Voice
) -> "LogReport":
    """Run what follows the estimate; a part without an answer leaves the others as they are."""
    from friction_audit.audit import diagnose_estimate, replay_estimate
    from friction_audit.discrepancy.settings import DiagnosisSettings
    from friction_audit.report.log_report import LogReport

    unanswered: list[Unanswered] = []
    with voice.step("replay"):
        replay: LogReplay | None = _answer(
            "replay", lambda: replay_estimate(estimate, replay_settings(ReplayOptions(), cycles)), unanswered
        )
    with voice.step("diagnose"):
        diagnosis: Diagnosis | None = _answer(
            "diagnose", lambda: diagnose_estimate(estimate, DiagnosisSettings()), unanswered
        )
    return LogReport(
        estimate=estimate,
        diagnosis=diagnosis,
        replay=replay,
        unanswered=tuple(unanswered),
        reading=reading,
        command=command,
    )


def _answer(part: str, compute: Callable[[], T], unanswered: "list[Unanswered]") -> T | None:
    """Return a part of the report, or None and why: the page says it in the part's place."""
    from friction_audit.report.log_report import Unanswered

    try:
        return compute()
    except AnalysisError as error:
        unanswered.append(Unanswered(part=part, message=str(error)))
        return None


def _write(report: "LogReport", files: dict[str, Path], voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.report.html.log_page import log_page, write_log_page
    from friction_audit.report.markdown import write_markdown
    from friction_audit.whole_file import whole_file

    writers: dict[str, Callable[[], str]] = {
        "html": lambda: write_log_page(report),
        "json": lambda: _document(report),
        "markdown": lambda: write_markdown(log_page(report, figures=False)),
    }
    for name, path in files.items():
        with voice.step(f"write {path}"), whole_file(path, overwrite=overwrite) as draft:
            draft.write_text(writers[name](), encoding="utf-8")


def _document(report: "LogReport") -> str:
    from friction_audit.report.document import write_document
    from friction_audit.report.log_document import log_document

    return write_document(log_document(report))


def _print(report: "LogReport", paths: Sequence[Path], *, json: bool) -> None:
    """Print the document, or what the report says and where it is."""
    if json:
        typer.echo(_document(report), nl=False)
        return
    from friction_audit.report.log_words import lead_sentence

    typer.echo(lead_sentence(report))
    for path in paths:
        typer.echo(str(path))
