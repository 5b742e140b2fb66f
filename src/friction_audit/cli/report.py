"""``friction-audit report``."""

import shlex
from pathlib import Path

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import OUTPUT, command_line, group, option
from friction_audit.cli.replay import ReplayOptions, replay_settings
from friction_audit.reporting import ENDINGS, SECTIONS

EXAMPLES = """Examples:
  friction-audit report run.mcap
  friction-audit report run.csv --drive robot -o results
  friction-audit report run.parquet --joints 1,3-5 --format html,pdf
  friction-audit report run.csv --sections friction,recording
  friction-audit report run.bag --json | jq '.joints[] | {joint, verdict}'"""

DEFAULT = "html"
LENGTHS = {"read": 2.0, "friction": 2.0, "compensator": 1.0, "diagnosis": 15.0}  # as on a log of 21 s, seven joints
DRAWING, WRITING = 15.0, 2.0  # likewise: the first file has to wait for the figures
# Parameters that change nothing in the report; the values of a --config file are written out.
NOT_PART_OF_IT = ("json", "quiet", "verbose", "overwrite", "config", "strict")


@group(OUTPUT)
class ReportOptions:
    """What the report holds."""

    formats: list[str] = option("Formats of the report. Default: html.", "--format", default=(), some_of=[*ENDINGS])
    sections: list[str] = option(
        "Sections of the report; repeatable, or separated by commas. Without diagnosis it takes seconds. Default: all.",
        "--sections", default=(), some_of=SECTIONS,
    )  # fmt: skip
    min_effect: opt.MinEffect = 0.0
    strict: opt.Strict = False


def command(
    context: typer.Context,
    log: opt.LogPath,
    wanted: ReportOptions,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    folder: Path | None = opt.folder_option(
        "Folder of the report, a file named after the log, e.g. run.report.html; or the file. Default: the current "
        "folder; with --json alone no file is written."
    ),
    export: opt.Exports = [],
) -> None:
    """Write a report: friction, missing effects, compensator."""
    voice = shared.general.voice
    settings, options = chain.audit_settings(shared, friction), chain.read_options(shared.reading, shared.selection)
    sections = wanted.sections or SECTIONS
    again = shared.overwrite
    from friction_audit.reporting import report as reports

    name = f"{reports.name_of_log(log) if log.is_dir() else Path(reports.name_of_log(log)).stem}.report"
    # Where the document is printed and nothing else was asked for, there is no file.
    kinds = wanted.formats or ([] if voice.json and folder is None else [DEFAULT])
    by_ending = {ending: kind for kind, ending in ENDINGS.items()}
    if folder is not None and folder.suffix in by_ending and not folder.is_dir():
        kinds, name, folder = wanted.formats or [by_ending[folder.suffix]], folder.stem, folder.parent
    files = {kind: (folder or Path()) / f"{name}{ENDINGS[kind]}" for kind in kinds}
    out = ResultFolder(folder=folder or Path(), name=name, prefix=f"{name}.", exports=export, overwrite=again)
    out.check(log, [path.name for path in files.values()], "estimate:ESTIMATE", "replay:REPLAY", "diagnosis:DIAGNOSE")
    lengths = [*(length for part, length in LENGTHS.items() if part in {"read", "friction", *sections}), DRAWING]
    with voice.stages([*lengths, *[WRITING] * (len(files) + out.stages)]) as stages:
        recorded = chain.read(log, options, stages)
        estimate = chain.estimate(recorded, settings, stages)
        from friction_audit.reporting.notices import estimate_notices

        chain.warn_about(recorded, estimate_notices(estimate), stages)
        given = command_line(context, leave_out=NOT_PART_OF_IT)
        from friction_audit.diagnosis.settings import DiagnosisSettings
        from friction_audit.io.files import whole_file
        from friction_audit.reporting.html.log_page import WRITERS

        steps = replay_settings(ReplayOptions(), shared.cycles), DiagnosisSettings(min_effect_nm=wanted.min_effect)
        typed = given.replace(shlex.quote(str(log)), shlex.quote(reports.name_of_log(log)))
        how = chain.reading_settings(options)
        report = reports.report_estimate(
            estimate, *steps, sections=sections, reading=how, command=typed, step=stages.step
        )
        for kind, path in files.items():
            with stages.step(f"write {path}"), whole_file(path, overwrite=again) as draft:
                draft.write_bytes(WRITERS[kind](report))
        exported = out.write_exports(reports.report_tables(report), recorded, stages)
    lines = [reports.lead_sentence(report), *map(str, (*files.values(), *exported))]
    show(lambda: reports.REPORT.json(report, report.unit), lambda: lines, voice)
    joints = () if report.diagnosis is None else report.diagnosis.joints
    chain.exit_for_bugs(joints, voice, report.unanswered)
    chain.require_one(estimate.log, estimate.friction.joints)
    chain.conclude(recorded, reports.report_notices(report), strict=wanted.strict)
