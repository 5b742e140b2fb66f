"""``friction-audit replay``."""

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
    Exports,
    FigureFormats,
    LogOptions,
    LogPath,
    figures_option,
)
from friction_audit.cli.replay_settings import ReplayOptions, replay_settings
from friction_audit.errors import AnalysisError, UsageError

if TYPE_CHECKING:
    from friction_audit.compensation.settings import ModelFile, ReplaySettings
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import Estimate, LogReplay

EXAMPLES = """Examples:
  friction-audit replay run.mcap
  friction-audit replay run.csv --model coulomb --window 4 -o results
  friction-audit replay run.parquet --factor 1.5 --no-passivity
  friction-audit replay run.parquet --fixed coulomb=0.25,viscous=0.1 --joints 1 --json
  friction-audit replay next.parquet --compensator model --joint-model results/model.toml
  friction-audit replay run.mcap -o results --export mcap"""

DOCUMENT, HISTORY = "replay.json", "replay.csv"


def command(
    log: LogPath,
    options: ReplayOptions,
    shared: LogOptions,
    folder: Annotated[
        Path | None,
        option(OUTPUT, f"Also write {DOCUMENT}, {HISTORY} and the figures there.", "--output", "-o", metavar="DIR"),
    ] = None,
    figures: Annotated[list[str], figures_option(choices.REPLAY_FIGURES)] = [choices.ALL],  # noqa: B006 - copied
    formats: FigureFormats = PNG,
    export: Exports = NO_EXPORT,
) -> None:
    """Show what a friction compensator with a passivity controller would have done."""
    voice = shared.general.voice
    settings = replay_settings(options, shared.cycles)
    audit, reading, output = audit_settings(shared.audit), read_options(shared.reading, shared.selection), shared.output
    plan, kinds = plan_exports(folder, export, "replay"), choices.some_figures(figures, choices.REPLAY_FIGURES)
    if folder is not None:
        files = [folder / DOCUMENT, folder / HISTORY, *possible_files(folder, kinds, formats)]
        files += [] if plan is None else plan.files(choices.REPLAY_TABLES)
        chain.check_outputs(files, overwrite=output.overwrite, log=log)
    with voice.stages(3 + (len(kinds) if folder else 0) + len(export)) as told:
        with chain.loading("friction_audit.friction.estimate", "friction_audit.compensation.counterfactual"):
            recorded = chain.read(log, reading, told)
        _check_model(settings.joint_model, recorded)
        found = _replay(chain.estimate(recorded, audit, told), settings, told)
        if not output.json:
            _warn(found, told)
            _warn_of_moments(settings.joint_model, recorded, told)
        _require_a_joint(found)
        text = _document(found, chain.reading_settings(reading))
        if folder is not None:
            _write(found, text, folder, overwrite=output.overwrite)
            numbers, again = [joint.joint for joint in found.replay.joints], output.overwrite
            unit, results = recorded.source.torque_unit, {"replay": found}
            write_figures(results, kinds, numbers, folder, formats, overwrite=again, voice=told, unit=unit)
        if plan is not None:
            _export(found, plan, recorded, told, overwrite=output.overwrite)
    _print(found, text, json=output.json)
    chain.exit_if_damaged(recorded)


def _replay(estimate: "Estimate", settings: "ReplaySettings", voice: Voice) -> "LogReplay":
    from friction_audit.pipeline import replay_estimate

    with voice.step("replay"):
        return replay_estimate(estimate, settings)


def _export(found: "LogReplay", plan: ExportPlan, recorded: "JointLog", voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.reporting.replay import replay_tables

    write_exports(plan, replay_tables(found), recorded, voice, overwrite=overwrite)


def _check_model(given: "ModelFile | None", log: "JointLog") -> None:
    """Refuse a model of another arm, before anything long is done.

    Raises:
        UsageError: If there is not one joint for each of the log.
    """
    if given is not None and len(given.model.joints) != len(log.joint_names):
        raise UsageError(
            f"--joint-model {given.path}: {len(given.model.joints)} joints; {log.source.path} has "
            f"{len(log.joint_names)}; give a model with an entry for every joint of the log"
        )


def _warn(found: "LogReplay", voice: Voice) -> None:
    from friction_audit.reporting.notices import notice_lines, replay_notices

    voice.warn(notice_lines(notice for notice in replay_notices(found) if notice.code != TABLED))


MOMENTS = ("friction_step", "torque_drift")
"""Terms that tell of moments of the recording on which they were found."""


def _warn_of_moments(given: "ModelFile | None", log: "JointLog", voice: Voice) -> None:
    """Say which terms of a model tell of another recording than this one."""
    for number, joint in enumerate(() if given is None else given.model.joints, start=1):
        if joint is None or joint.provenance.sha256 in ("", log.source.sha256):
            continue
        names = ", ".join(term.name for term in joint.terms if term.name in MOMENTS)
        if names:
            voice.warn(
                [f"joint {number}: {names} of the model holds for moments of {joint.provenance.log}, not of this log"]
            )


TABLED = "not_replayed"
"""Code of the caution that the table shows as well."""


def _require_a_joint(found: "LogReplay") -> None:
    """Refuse a result without any joint.

    Raises:
        AnalysisError: With the reason of each joint.
    """
    from friction_audit.reporting.notices import reason_lines

    if all(joint.reason for joint in found.replay.joints):
        lines = "".join(f"\n  {line}" for line in reason_lines(found.replay.joints))
        raise AnalysisError(f"{found.estimate.log.source.path}: no joint can be replayed:{lines}")


def _document(found: "LogReplay", reading: dict[str, object]) -> str:
    from friction_audit.reporting.documents import write_document
    from friction_audit.reporting.replay import replay_document

    return write_document(replay_document(found, reading))


def _write(found: "LogReplay", document: str, folder: Path, *, overwrite: bool) -> None:
    from friction_audit.io.files import whole_file
    from friction_audit.io.writers.tables import write_table
    from friction_audit.reporting.replay import history_table

    with whole_file(folder / DOCUMENT, overwrite=overwrite) as draft:
        draft.write_text(document, encoding="utf-8")
    with whole_file(folder / HISTORY, overwrite=overwrite) as draft:
        write_table(history_table(found), draft, "csv")


def _print(found: "LogReplay", document: str, *, json: bool) -> None:
    if json:
        say(document, nl=False)
    else:
        from friction_audit.reporting.replay import replay_lines

        say("\n".join(replay_lines(found)))
