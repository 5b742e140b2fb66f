"""``friction-audit diagnose``."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import Voice
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import DIAGNOSIS, DIAGNOSIS_FIGURES, EFFECTS, group, option, positive

if TYPE_CHECKING:
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.pipeline import Diagnosis

EXAMPLES = """Examples:
  friction-audit diagnose run.mcap
  friction-audit diagnose run.csv --drive robot -o results
  friction-audit diagnose run.parquet --candidates stribeck,presliding --joints 1 --json
  friction-audit diagnose next.parquet --joint-model results/model.toml
  friction-audit diagnose run.mcap -o results --export mcap,parquet"""

DOCUMENT, MODEL = "diagnose.json", "model.toml"
LENGTH = 10.0  # of the diagnosis, compared with reading
# While the log is read: what processes would load one by one after they are forked; with the loops of the noise, numba.
LOADED = (
    *("friction_audit.friction.estimate", "friction_audit.diagnosis.diagnose"),
    *("friction_audit.diagnosis.noise", "scipy.ndimage"),
)


@group(DIAGNOSIS)
class DiagnosisOptions:
    """What is asked of a diagnosis."""

    candidates: list[str] = option(
        "Effects to consider. Default: all.", default=(), some_of=EFFECTS, metavar="NAME,..."
    )
    min_effect: opt.MinEffect = 0.0
    seed: int = option(
        "Seed of the screening test; no effect and no verdict depends on it.", default=0, metavar="INT", min=0
    )
    at_most: float = positive(
        "Of a longer log, so much is diagnosed, in parts spread over it [min].", default=5.0, metavar="MINUTES"
    )
    joint_model: Path | None = option(
        "Nominal model of the joints, e.g. model.toml of an earlier diagnosis. Default: inertia, Coulomb and "
        "viscous friction.",
        metavar="FILE.toml",
        exists=True,
        dir_okay=False,
    )


def command(
    log: opt.LogPath,
    options: DiagnosisOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    folder: Path | None = opt.folder_option(
        f"Also write {DOCUMENT}, the augmented model {MODEL} and the figures to DIR."
    ),
    figures: list[str] = opt.figures_option(DIAGNOSIS_FIGURES),
    export: opt.Exports = [],
    strict: opt.Strict = False,
) -> None:
    """Name the effects that the model of each joint misses."""
    voice, again = shared.general.voice, shared.overwrite
    audit, reading = chain.audit_settings(shared), chain.read_options(shared.reading, shared.selection)
    settings = _settings(options)
    out = ResultFolder(folder, "diagnose", figures, drawn.formats, export, overwrite=again)
    out.check(log, (DOCUMENT, MODEL), "diagnosis:DIAGNOSE")
    with voice.stages([1.0, LENGTH, *[1.0] * out.stages]) as stages:
        # No step reads what is desired, and it takes memory.
        recorded = replace(chain.read(log, reading, stages, loaded=LOADED), tau_J_d=None)
        if settings.model is not None:
            chain.check_joint_model(options.joint_model, settings.model, recorded)
        from friction_audit.pipeline import Diagnosis, diagnosis_subjects, estimate_log, without_samples

        with stages.step("diagnose") as share:
            estimate = estimate_log(recorded, audit)
            from friction_audit.diagnosis.diagnose import diagnose_subjects

            subjects = diagnosis_subjects(estimate, settings)
            estimate = without_samples(estimate)  # most of the memory, released before processes are forked
            recorded = estimate.log
            joints = diagnose_subjects(subjects, settings, share)
            found = Diagnosis(estimate=estimate, joints=joints, settings=settings)
        from friction_audit.diagnosis.result import UNANSWERED
        from friction_audit.reporting.diagnosis import DIAGNOSE, diagnose_lines
        from friction_audit.reporting.notices import diagnose_notices

        answered = not all(joint.verdict in UNANSWERED and not joint.traceback for joint in joints)
        chain.warn_about(recorded, diagnose_notices(found), stages, marked=answered)
        if not answered:
            chain.require_one(recorded, joints, "no joint can be diagnosed")
        document = partial(DIAGNOSE.of, found, chain.reading_settings(reading))
        text = out.write_document(DOCUMENT, document, voice)
        _write_model(found, out, stages)
        out.write_figures({"diagnosis": found}, [one.joint for one in joints], recorded.source.torque_unit, stages)
        out.write_exports(DIAGNOSE.tables(found), recorded, stages)
    show(text, lambda: diagnose_lines(found, verbose=voice.verbose), voice)
    chain.exit_for_bugs(joints, voice)
    chain.conclude(recorded, diagnose_notices(found), strict=strict)


def _settings(options: DiagnosisOptions) -> "DiagnosisSettings":
    from friction_audit.diagnosis.settings import DiagnosisSettings

    model = None
    if options.joint_model is not None:
        from friction_audit.effects.joint_model import load_model

        model = load_model(options.joint_model)
    return DiagnosisSettings(
        candidates=tuple(options.candidates) or None,
        min_effect_nm=options.min_effect,
        seed=options.seed,
        at_most_s=60.0 * options.at_most,
        model=model,
    )


def _write_model(found: "Diagnosis", out: ResultFolder, voice: Voice) -> None:
    if out.folder is None:
        return
    from friction_audit.diagnosis.augmented_model import augment_models
    from friction_audit.effects.joint_model import save_model
    from friction_audit.reporting.notices import notices

    path = out.folder / MODEL
    augmented, lacking = augment_models(found.joints, found.estimate.log, found.settings.model)
    voice.warn(f"{path}: {lack}" for lack in notices(lacking))
    save_model(augmented, path, overwrite=out.overwrite)
