"""``friction-audit export``."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.outputs import show
from friction_audit.cli.parameters import OUTPUT, group, option, parse_joints, parse_range
from friction_audit.errors import UsageError

FASTEST = 1000.0  # rad/s: no joint turns faster

EXAMPLES = """Examples:
  friction-audit export run.mcap panda.urdf --into my_panda.urdf
  friction-audit export results/model.toml panda.xml --into my_panda.xml --armature
  friction-audit export results friction.hpp --joints 1-4
  friction-audit export run.parquet joint_friction.py"""

SOURCE = "A log, an estimate.json, a model.toml, a batch.json or its ledger, or a folder that holds one."
OUT = "File to write: .urdf, .xml, .sdf, .usda, .py, .hpp or .h, .yaml or .csv."


@group(OUTPUT)
class ExportOptions:
    """How friction is written."""

    arm: str | None = option("Arm of a batch whose reference is exported. Default: the only one.", metavar="NAME")
    into: Path | None = option(
        "URDF, MJCF or SDF of the robot: OUT is a copy of it with the friction in its joints.", metavar="FILE",
        exists=True, dir_okay=False,
    )  # fmt: skip
    speeds: str | None = option(
        "Speeds [rad/s] over which the file is to hold. Default: those of the log; without one 0.01,1.",
        metavar="LOW,HIGH",
    )
    armature: bool | None = option(
        "Write the inertia as armature. Default: where it is without that of the links.", "--armature/--no-armature"
    )


def command(
    source: Annotated[Path, typer.Argument(metavar="SOURCE", help=SOURCE)],
    out: Annotated[Path, typer.Argument(metavar="OUT", help=OUT)],
    options: ExportOptions,
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
) -> None:
    """Export friction to a file of a simulator or a controller."""
    from friction_audit.export.export import choose_target, export_friction, read_into
    from friction_audit.export.friction_law import of_estimate, read_result, result_file

    voice = shared.general.voice
    target = choose_target(out)
    into = None if options.into is None else read_into(target, options.into)
    for kept in (source, options.into or source):
        chain.check_outputs([out], overwrite=shared.overwrite, log=kept)
    speeds = parse_range("--speeds", options.speeds, "rad/s", 0.0, FASTEST)
    wanted = parse_joints(shared.selection.joints)
    written = partial(export_friction, out=out, wanted=wanted, speeds=speeds, armature=options.armature)
    result = result_file(source)
    if options.arm is not None and result is None:
        raise UsageError(f"--arm {options.arm}: is for a result of batch-report; choose an arm of a log with --topic")
    estimate = None
    if result is None:
        audit = chain.audit_settings(shared, friction)
        log = chain.read_torque(source, shared, voice)
        estimate = chain.estimate(log, audit, voice)
        chain.require_one(estimate.log, estimate.friction.joints)
    found = of_estimate(estimate) if estimate else read_result(result or source, options.arm)
    with voice.step(f"write {out}"):
        export = written(found, into=into, estimate=estimate, overwrite=shared.overwrite)
    from friction_audit.reporting.export import EXPORT, export_lines, export_notices
    from friction_audit.reporting.notices import notice_lines

    if estimate:
        chain.warn_about(estimate.log, export_notices(export), voice)
    else:
        voice.warn(notice_lines(export_notices(export)), held=True)
    show(lambda: EXPORT.json(export), lambda: export_lines(export), voice)
    if estimate:
        chain.conclude(estimate.log)
