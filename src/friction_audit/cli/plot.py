"""``friction-audit plot``."""

from pathlib import Path

from friction_audit.cli import chain, choices
from friction_audit.cli import options as opt
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.console import say
from friction_audit.cli.outputs import ResultFolder

EXAMPLES = """Examples:
  friction-audit plot run.mcap
  friction-audit plot run.csv --figures energy,coefficients --figure-format pdf -o paper
  friction-audit plot run.bag --figures all --joints 5 --figure-format svg,png"""


def command(
    log: opt.LogPath,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    figures: list[str] = opt.figures_option(choices.PLOTTED, default="velocity-torque"),
    folder: Path = opt.folder_option("Folder of the figures.", Path("figures")),
    min_effect: opt.MinEffect = 0.0,
    strict: opt.Strict = False,
) -> None:
    """Draw figures for a paper: all joints, and each joint alone."""
    voice = shared.general.voice
    settings, options = audit_settings(shared, friction), read_options(shared.reading, shared.selection)
    kinds = choices.some_figures(figures, choices.PLOTTED)
    out = ResultFolder(folder=folder, figures=kinds, formats=drawn.formats, overwrite=shared.overwrite)
    out.check(log)
    result = chain.estimate(chain.read(log, options, voice), settings, voice)
    from friction_audit.reporting.notices import estimate_notices

    warnings = estimate_notices(result)
    if not shared.general.json:
        chain.warn_about(result.log, warnings, voice)

    results: dict[str, object] = {"estimate": result}
    # Replay and diagnosis, where a figure draws them, with default settings otherwise.
    if set(kinds) & set(choices.REPLAY_FIGURES):
        from friction_audit.compensation.settings import ReplaySettings
        from friction_audit.pipeline import replay_estimate

        with voice.step("replay"):
            results["replay"] = replay_estimate(result, ReplaySettings())
    if set(kinds) & set(choices.DIAGNOSIS_FIGURES):
        from friction_audit.diagnosis.settings import DiagnosisSettings
        from friction_audit.pipeline import diagnose_estimate

        with voice.step("diagnose"):
            results["diagnosis"] = diagnose_estimate(result, DiagnosisSettings(min_effect_nm=min_effect))
    joints, unit = result.interaction.joint_numbers, result.log.source.torque_unit
    files = out.write_figures(results, joints, unit, voice, each_joint=True)
    if shared.general.json:
        from friction_audit.reporting.documents import plot_document, write_document

        figures_ = [(file.kind, file.joint, str(file.path)) for file in files]
        say(write_document(plot_document(result, figures_, chain.reading_settings(options))), nl=False)
    else:
        for file in files:
            say(str(file.path))
    chain.conclude(result.log, warnings, strict=strict)
