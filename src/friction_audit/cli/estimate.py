"""``friction-audit estimate``."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from friction_audit.cli import chain, options as opt
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import FIGURES

EXAMPLES = """Examples:
  friction-audit estimate run.mcap
  friction-audit estimate run.csv --drive robot -o results --figure-format pdf,png
  friction-audit estimate run.bag --topic /left/joint_states --joints 1,3-5 --json
  friction-audit estimate slow.parquet --thresholds auto --estimator paper
  friction-audit estimate run.mcap -o results --export mcap,csv"""

DOCUMENT, HISTORY = "estimate.json", "coefficient_history.csv"


def command(
    log: opt.LogPath,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    folder: Path | None = opt.folder_option(f"Also write {DOCUMENT}, {HISTORY} and the figures to DIR."),
    figures: list[str] = opt.figures_option(FIGURES),
    export: opt.Exports = [],
    strict: opt.Strict = False,
) -> None:
    """Estimate friction per joint over time, with 95 % intervals."""
    voice = shared.general.voice
    settings, options = chain.audit_settings(shared, friction), chain.read_options(shared.reading, shared.selection)
    out = ResultFolder(folder, "estimate", figures, drawn.formats, export, overwrite=shared.overwrite)
    out.check(log, (DOCUMENT, HISTORY), "estimate:ESTIMATE")
    with voice.stages(2 + out.stages) as stages:
        with chain.loading("friction_audit.friction.estimate"):
            from friction_audit.pipeline import while_read

            # Figures and exports take all joints at once. The text of the terminal shows no hash.
            how = replace(options, in_blocks=True, hashed=shared.general.json) if folder is None else options
            recorded = chain.read(log, how, stages, while_read(settings))
        result = chain.estimate(recorded, settings, stages)
        from friction_audit.reporting import estimate as output
        from friction_audit.reporting.notices import estimate_notices

        joints = result.friction.joints
        chain.warn_about(recorded, estimate_notices(result), stages, marked=not all(one.reason for one in joints))
        chain.require_one(recorded, joints)
        document = partial(output.ESTIMATE.of, result, chain.reading_settings(options))
        text = out.write_document(DOCUMENT, document, voice)
        out.write_csv(HISTORY, output.HISTORY.file(joints, "history", recorded.source.torque_unit))
        out.write_figures({"estimate": result}, [one.joint for one in joints], recorded.source.torque_unit, stages)
        if export:
            out.write_exports(output.ESTIMATE.tables(result), recorded, stages)
    show(text, lambda: output.estimate_lines(result), voice)
    chain.conclude(recorded, estimate_notices(result), strict=strict)
