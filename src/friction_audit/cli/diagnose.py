"""``friction-audit diagnose``."""

from dataclasses import dataclass
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
from friction_audit.errors import AnalysisError, UsageError

if TYPE_CHECKING:
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.effects.joint_model import ArmModel
    from friction_audit.joint_log import JointLog
    from friction_audit.pipeline import AuditSettings, Diagnosis

DIAGNOSIS = "Diagnosis"

EXAMPLES = """Examples:
  friction-audit diagnose run.mcap
  friction-audit diagnose run.csv --drive robot -o results
  friction-audit diagnose run.parquet --candidates stribeck,presliding --joints 1 --json
  friction-audit diagnose next.parquet --joint-model results/model.toml
  friction-audit diagnose run.mcap -o results --export mcap,parquet"""

DOCUMENT, MODEL = "diagnose.json", "model.toml"


@dataclass(frozen=True, kw_only=True, slots=True)
class DiagnosisOptions:
    """What is asked of a diagnosis."""

    candidates: Annotated[
        list[str],
        option(
            DIAGNOSIS,
            "Effects that may be named; repeatable, or separated by commas. Default: all.",
            some_of=choices.EFFECTS,
            metavar="NAME",
        ),
    ] = ()  # type: ignore[assignment] # a dataclass takes no list
    alpha: Annotated[
        float,
        option(DIAGNOSIS, "Probability of saying of a joint that something is missing where nothing is.", metavar="P"),
    ] = 0.05
    seed: Annotated[
        int,
        option(
            DIAGNOSIS,
            "Of the choice of held-out cycles and of the tests; same seed, same answer.",
            metavar="INT",
            min=0,
        ),
    ] = 0
    joint_model: Annotated[
        Path | None,
        option(
            DIAGNOSIS,
            "Nominal model of the joints, e.g. of an earlier diagnosis. "
            "Default: inertia, Coulomb and viscous friction.",
            metavar="FILE.toml",
            exists=True,
            dir_okay=False,
        ),
    ] = None


def command(
    log: LogPath,
    options: DiagnosisOptions,
    shared: LogOptions,
    folder: Annotated[
        Path | None,
        option(
            OUTPUT,
            f"Also write {DOCUMENT}, the augmented {MODEL} and the figures there.",
            "--output",
            "-o",
            metavar="DIR",
        ),
    ] = None,
    figures: Annotated[list[str], figures_option(choices.DIAGNOSIS_FIGURES)] = [choices.ALL],  # noqa: B006 - copied
    formats: FigureFormats = PNG,
    export: Exports = NO_EXPORT,
) -> None:
    """Find what the model of each joint misses, name it, and show how far the gap closes."""
    voice = shared.general.voice
    audit, reading, output = audit_settings(shared.audit), read_options(shared.reading, shared.selection), shared.output
    settings = _settings(options)
    plan, kinds = plan_exports(folder, export, "diagnose"), choices.some_figures(figures, choices.DIAGNOSIS_FIGURES)
    if folder is not None:
        files = [folder / DOCUMENT, folder / MODEL, *possible_files(folder, kinds, formats)]
        files += [] if plan is None else plan.files(choices.DIAGNOSE_TABLES)
        chain.check_outputs(files, overwrite=output.overwrite, log=log)
    with voice.stages(2 + (len(kinds) if folder else 0) + len(export)) as told:
        with chain.loading("friction_audit.friction.estimate", "friction_audit.diagnosis.diagnose"):
            recorded = chain.read(log, reading, told)
        _check_model(options.joint_model, settings.model, recorded)
        found = _diagnose(recorded, audit, settings, told)
        if not output.json:
            _warn(found, told)
        _require_an_answer(found)
        text = _document(found, chain.reading_settings(reading))
        if folder is not None:
            _write(found, text, folder, told, overwrite=output.overwrite)
            numbers, again = [joint.joint for joint in found.discrepancy.joints], output.overwrite
            unit, results = recorded.source.torque_unit, {"diagnosis": found}
            write_figures(results, kinds, numbers, folder, formats, overwrite=again, voice=told, unit=unit)
        if plan is not None:
            _export(found, plan, recorded, told, overwrite=output.overwrite)
    _print(found, text, json=output.json, verbose=voice.verbose)
    chain.exit_for_bugs(joint_bugs(found), voice)
    chain.exit_if_damaged(recorded)


def _diagnose(log: "JointLog", audit: "AuditSettings", settings: "DiagnosisSettings", voice: Voice) -> "Diagnosis":
    from friction_audit.pipeline import diagnose_estimate, estimate_log

    with voice.step("diagnose"):
        return diagnose_estimate(estimate_log(log, audit), settings)


def _export(found: "Diagnosis", plan: ExportPlan, recorded: "JointLog", voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.reporting.diagnosis import diagnose_tables

    write_exports(plan, diagnose_tables(found), recorded, voice, overwrite=overwrite)


def _settings(options: DiagnosisOptions) -> "DiagnosisSettings":
    """Return what is asked.

    Raises:
        InputError: If the file of a model is none.
        UsageError: If a value cannot be used.
    """
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.effects.model_file import load_model

    return DiagnosisSettings(
        candidates=tuple(options.candidates) or None,
        alpha=options.alpha,
        seed=options.seed,
        model=None if options.joint_model is None else load_model(options.joint_model),
    )


def _check_model(path: Path | None, model: "ArmModel | None", log: "JointLog") -> None:
    """Refuse a model of another arm, before anything long is done.

    Raises:
        UsageError: If there is not one joint for each of the log.
    """
    if model is not None and len(model.joints) != len(log.joint_names):
        raise UsageError(
            f"--joint-model {path}: {len(model.joints)} joints; {log.source.path} has {len(log.joint_names)}; "
            "give a model with an entry for every joint of the log"
        )


def _warn(found: "Diagnosis", voice: Voice) -> None:
    from friction_audit.reporting.notices import diagnose_notices, notice_lines

    voice.warn(notice_lines(diagnose_notices(found)))


def _require_an_answer(found: "Diagnosis") -> None:
    """Refuse a result without an answer for any joint.

    Raises:
        AnalysisError: With what is said of each joint.
    """
    from friction_audit.diagnosis.result import UNANSWERED

    joints = found.discrepancy.joints
    if all(joint.verdict in UNANSWERED and not joint.traceback for joint in joints):
        lines = "".join(f"\n  joint {joint.joint}: {joint.message}" for joint in joints)
        raise AnalysisError(f"{found.estimate.log.source.path}: no joint can be diagnosed:{lines}")


def joint_bugs(found: "Diagnosis") -> list[tuple[str, str]]:
    """Return a sentence and the traceback for each joint whose diagnosis ended in a bug."""
    return [(f"joint {one.joint}: {one.message}", one.traceback) for one in found.discrepancy.joints if one.traceback]


def _document(found: "Diagnosis", reading: dict[str, object]) -> str:
    from friction_audit.reporting.diagnosis import diagnose_document
    from friction_audit.reporting.documents import write_document

    return write_document(diagnose_document(found, reading))


def _write(found: "Diagnosis", document: str, folder: Path, voice: Voice, *, overwrite: bool) -> None:
    from friction_audit.diagnosis.grown_model import grow_models
    from friction_audit.effects.model_file import save_model
    from friction_audit.io.files import whole_file

    with whole_file(folder / DOCUMENT, overwrite=overwrite) as draft:
        draft.write_text(document, encoding="utf-8")
    grown = grow_models(found.discrepancy, found.estimate.log, found.settings.model)
    voice.warn(f"{folder / MODEL}: joint {joint}: {lack}" for joint, lack in grown.lacking)
    save_model(grown.model, folder / MODEL, overwrite=overwrite)


def _print(found: "Diagnosis", document: str, *, json: bool, verbose: bool) -> None:
    if json:
        say(document, nl=False)
    else:
        from friction_audit.reporting.diagnosis import diagnose_lines

        say("\n".join(diagnose_lines(found, verbose=verbose)))
