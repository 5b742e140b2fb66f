"""``friction-audit plot``."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace

from friction_audit.cli import chain, options as opt
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import DIAGNOSIS_FIGURES, PLOTTED, REPLAY_FIGURES

EXAMPLES = """Examples:
  friction-audit plot run.mcap
  friction-audit plot run.csv --figures energy,coefficients --figure-format pdf -o paper
  friction-audit plot run.bag --figures all --joints 5 --figure-format svg,png"""


def command(
    log: opt.LogPath,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    figures: list[str] = opt.figures_option(PLOTTED, default="velocity-torque"),
    folder: Path = opt.folder_option("Folder of the figures.", Path("figures")),
    min_effect: opt.MinEffect = 0.0,
    strict: opt.Strict = False,
) -> None:
    """Draw figures for a paper: all joints, and each joint alone."""
    voice = shared.general.voice
    settings, options = chain.audit_settings(shared, friction), chain.read_options(shared.reading, shared.selection)
    out = ResultFolder(folder=folder, figures=figures, formats=drawn.formats, overwrite=shared.overwrite)
    out.check(log)
    result = chain.estimate(chain.read(log, options, voice), settings, voice)
    from friction_audit.reporting.documents import PLOT
    from friction_audit.reporting.notices import estimate_notices

    warnings = estimate_notices(result)
    chain.warn_about(result.log, warnings, voice)
    results: dict[str, object] = {"estimate": result}
    # Replay and diagnosis, where a figure draws them, with default settings otherwise.
    if set(figures) & set(REPLAY_FIGURES):
        from friction_audit.compensation.settings import ReplaySettings
        from friction_audit.pipeline import replay_estimate

        with voice.step("replay"):
            results["replay"] = replay_estimate(result, ReplaySettings())
    if set(figures) & set(DIAGNOSIS_FIGURES):
        from friction_audit.diagnosis.settings import DiagnosisSettings
        from friction_audit.pipeline import diagnose_estimate

        with voice.step("diagnose"):
            results["diagnosis"] = diagnose_estimate(result, DiagnosisSettings(min_effect_nm=min_effect))
    joints, unit = result.interaction.joint_numbers, result.log.source.torque_unit
    written = out.write_figures(results, joints, unit, voice, each_joint=True)
    plot = SimpleNamespace(estimate=result, figures=written)
    document = partial(PLOT.of, plot, chain.reading_settings(options))
    show(document, lambda: [path for *_, path in written], voice)
    chain.conclude(result.log, warnings, strict=strict)
