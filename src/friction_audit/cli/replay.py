"""``friction-audit replay``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from friction_audit.cli import chain, choices
from friction_audit.cli import options as opt
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.console import Voice
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.replay_settings import ReplayOptions, replay_settings

if TYPE_CHECKING:
    from friction_audit.compensation.settings import ModelFile
    from friction_audit.joint_log import JointLog

EXAMPLES = """Examples:
  friction-audit replay run.mcap
  friction-audit replay run.csv --compensator-model coulomb -o results
  friction-audit replay run.parquet --factor 1.5 --no-passivity
  friction-audit replay run.parquet --coefficients coulomb=0.25,viscous=0.1 --joints 1 --json
  friction-audit replay next.parquet --compensator model --joint-model results/model.toml
  friction-audit replay run.mcap -o results --export mcap"""

DOCUMENT, HISTORY = "replay.json", "replay.csv"
MOMENTS = ("friction_step", "torque_drift")  # effects that hold for moments of the recording they were found on


def command(
    log: opt.LogPath,
    options: ReplayOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    folder: Annotated[
        Path | None, opt.folder_option(f"Also write {DOCUMENT}, {HISTORY} and the figures to DIR.")
    ] = None,
    figures: Annotated[list[str], opt.figures_option(choices.REPLAY_FIGURES)] = [choices.ALL],  # noqa: B006 - copied
    export: opt.Exports = opt.NO_EXPORT,
    strict: opt.Strict = False,
) -> None:
    """Replay a friction compensator with passivity controller."""
    voice = shared.general.voice
    settings = replay_settings(options, shared.cycles)
    audit, reading = audit_settings(shared), read_options(shared.reading, shared.selection)
    kinds, again = choices.some_figures(figures, choices.REPLAY_FIGURES), shared.overwrite
    out = ResultFolder(
        folder=folder, name="replay", figures=kinds, formats=drawn.formats, exports=export, overwrite=again
    )
    out.check(log, (DOCUMENT, HISTORY), "replay")
    with voice.stages(3 + out.stages) as stages:
        with chain.loading("friction_audit.friction.estimate", "friction_audit.compensation.counterfactual"):
            recorded = chain.read(log, reading, stages)
        if settings.joint_model is not None:
            chain.check_joint_model(settings.joint_model.path, settings.joint_model.model, recorded)
        estimated = chain.estimate(recorded, audit, stages)
        from friction_audit.pipeline import replay_estimate
        from friction_audit.reporting.documents import write_document
        from friction_audit.reporting.notices import replay_notices
        from friction_audit.reporting.replay import history_table, replay_document, replay_tables
        from friction_audit.reporting.replay_text import replay_lines

        with stages.step("replay"):
            found = replay_estimate(estimated, settings)
        joints, json = found.replay.joints, shared.general.json
        if not json:
            chain.warn_about(recorded, replay_notices(found), stages, marked=not all(one.reason for one in joints))
            _warn_of_moments(settings.joint_model, recorded, stages)
        chain.require_one(recorded, joints, "no joint can be replayed")
        text = write_document(replay_document(found, chain.reading_settings(reading)))
        out.write_text(DOCUMENT, text)
        out.write_csv(HISTORY, history_table(found))
        out.write_figures({"replay": found}, [joint.joint for joint in joints], recorded, stages)
        out.write_exports(replay_tables(found), recorded, stages)
    show(text, lambda: replay_lines(found), json=json)
    chain.conclude(recorded, replay_notices(found), strict=strict)


def _warn_of_moments(given: "ModelFile | None", log: "JointLog", voice: Voice) -> None:
    """Warn of effects of a model that hold for moments of another recording."""
    for number, joint in enumerate(() if given is None else given.model.joints, start=1):
        if joint is None or joint.provenance.sha256 in ("", log.source.sha256):
            continue
        names = ", ".join(term.name for term in joint.terms if term.name in MOMENTS)
        if names:
            voice.warn(
                [f"joint {number}: {names} of the model holds for moments of {joint.provenance.log}, not of this log"]
            )
