"""``friction-audit estimate``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from friction_audit.cli import chain, choices
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.choices import option
from friction_audit.cli.console import Voice, say
from friction_audit.cli.export_files import ExportPlan, plan_exports, write_exports
from friction_audit.cli.figure_files import possible_files, write_figures
from friction_audit.cli.options import (
    NO_EXPORT,
    OUTPUT,
    PNG,
    AuditOptions,
    Exports,
    FigureFormats,
    LogPath,
    figures_option,
)

if TYPE_CHECKING:
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import Estimate

EXAMPLES = """Examples:
  friction-audit estimate run.mcap
  friction-audit estimate run.csv --drive robot -o results --figure-format pdf,png
  friction-audit estimate run.bag --topic /left/joint_states --joints 1,3-5 --json
  friction-audit estimate slow.parquet --thresholds auto --estimator paper
  friction-audit estimate run.mcap -o results --export mcap,csv"""

DOCUMENT, HISTORY = "estimate.json", "history.csv"


def command(
    log: LogPath,
    shared: AuditOptions,
    folder: Annotated[
        Path | None,
        option(OUTPUT, f"Also write {DOCUMENT}, {HISTORY} and the figures there.", "--output", "-o", metavar="DIR"),
    ] = None,
    figures: Annotated[list[str], figures_option(choices.FIGURES)] = [choices.ALL],  # noqa: B006 - Typer copies it
    formats: FigureFormats = PNG,
    export: Exports = NO_EXPORT,
) -> None:
    """Estimate friction coefficients per joint over time, with their uncertainty."""
    voice = shared.general.voice
    settings, options, output = audit_settings(shared), read_options(shared.reading, shared.selection), shared.output
    plan, kinds = plan_exports(folder, export, "estimate"), choices.some_figures(figures, choices.FIGURES)
    if folder is not None:
        files = [folder / DOCUMENT, folder / HISTORY, *possible_files(folder, kinds, formats)]
        files += [] if plan is None else plan.files(choices.ESTIMATE_TABLES)
        chain.check_outputs(files, overwrite=output.overwrite, log=log)
    reading_settings = chain.reading_settings(options)
    with voice.stages(2 + (len(kinds) if folder else 0) + len(export)) as told:
        with chain.loading("friction_audit.friction.estimate"):
            recorded = chain.read(log, options, told)
        result = chain.estimate(recorded, settings, told)
        if not output.json:
            chain.warn_about(result, told)
        chain.require_an_estimate(result)
        if folder is not None:
            _write_texts(result, reading_settings, folder, overwrite=output.overwrite)
            numbers, unit = result.interaction.joint_numbers, result.log.source.torque_unit
            results, again = {"estimate": result}, output.overwrite
            write_figures(results, kinds, numbers, folder, formats, overwrite=again, voice=told, unit=unit)
        if plan is not None:
            _export(result, plan, recorded, told, overwrite=output.overwrite)
    _print(result, reading_settings, json=output.json)
    chain.exit_if_damaged(result.log)


def _document(result: "Estimate", reading: dict[str, object]) -> str:
    from friction_audit.reporting.documents import write_document
    from friction_audit.reporting.estimate import estimate_document

    return write_document(estimate_document(result, reading))


def _write_texts(result: "Estimate", reading: dict[str, object], folder: Path, *, overwrite: bool) -> None:
    from friction_audit.io.files import whole_file
    from friction_audit.io.writers.tables import write_table
    from friction_audit.reporting.estimate import history_table

    with whole_file(folder / DOCUMENT, overwrite=overwrite) as draft:
        draft.write_text(_document(result, reading), encoding="utf-8")
    with whole_file(folder / HISTORY, overwrite=overwrite) as draft:
        write_table(history_table(result), draft, "csv")


def _export(result: "Estimate", plan: ExportPlan, recorded: "JointLog", voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.reporting.estimate import estimate_tables

    write_exports(plan, estimate_tables(result), recorded, voice, overwrite=overwrite)


def _print(result: "Estimate", reading: dict[str, object], *, json: bool) -> None:
    if json:
        say(_document(result, reading), nl=False)
    else:
        from friction_audit.reporting.estimate import estimate_lines

        say("\n".join(estimate_lines(result)))
