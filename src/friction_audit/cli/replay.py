"""``friction-audit replay``."""

from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_audit import compensation
from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import Voice
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import REPLAY, REPLAY_FIGURES, TUNING, flag, group, option, parse_numbers, positive
from friction_audit.errors import UsageError
from friction_audit.friction.settings import MODELS

if TYPE_CHECKING:
    from friction_audit.compensation.law import Coefficients
    from friction_audit.compensation.settings import ModelFile, ReplaySettings
    from friction_audit.joint_log import JointLog

EXAMPLES = """Examples:
  friction-audit replay run.mcap
  friction-audit replay run.csv --compensator-model coulomb -o results
  friction-audit replay run.parquet --factor 1.5 --no-passivity
  friction-audit replay run.parquet --coefficients coulomb=0.25,viscous=0.1 --joints 1 --json
  friction-audit replay next.parquet --compensator model --joint-model results/model.toml
  friction-audit replay run.mcap -o results --export mcap"""

DOCUMENT, HISTORY = "replay.json", "replay_cycles.csv"
TIMED = ("friction_step", "torque_drift")  # effects that hold for times of the recording they were found on


@group(TUNING)
class ReplayOptions:
    """Compensator that is replayed, and what is assumed of the person."""

    assume: str = option(
        "Assumption about the person: what stays as recorded.", default="same-motion", one_of=compensation.ASSUMES,
        panel=REPLAY,
    )  # fmt: skip
    compensator: str = option(
        "energy: energy-based, as published; fixed: the coefficients of this log; model: the friction of "
        "--joint-model; others: baseline compensators.", default="energy", one_of=("energy", *compensation.COMPETITORS),
        panel=REPLAY,
    )  # fmt: skip
    joint_model: Path | None = option(
        "Joint model, e.g. model.toml of a diagnosis; it replaces the joint fitted to the log in same-torque and "
        "same-operator, and is what --compensator model compensates.", metavar="FILE.toml", exists=True, dir_okay=False,
        panel=REPLAY,
    )  # fmt: skip
    factor: float = option("Scale factor on the estimated friction.", default=1.0, metavar="FACTOR", panel=REPLAY)
    model: str | None = option("Model that energy estimates. Default: combined.", "--compensator-model", one_of=MODELS)
    window: int | None = option(
        "Cycles per estimate of the energy compensator. Default: 4 (2 with one coefficient); paper: 2.",
        "--compensator-window", metavar="K",
    )  # fmt: skip
    coefficients: str | None = option(
        "Constant coefficients of the energy compensator in place of its estimate [N m, N m s/rad].",
        metavar="coulomb=NM,viscous=NMS",
    )
    no_passivity: bool = flag("No passivity controller.", "--no-passivity")
    max_damping: float | None = positive("Damping limit of passivity control [N m s/rad]. Default: 5.", metavar="NMS")
    max_torque: float | None = positive("Maximum torque [N m]. Default: limits of the arm, or none.", metavar="NM")
    max_rate: float | None = positive("Maximum torque rate [N m/s]. Default: a Panda's 1000, or none.", metavar="NM/S")
    observer_gain: float | None = positive("Gain of disturbance_observer [1/s]. Default: 20.", metavar="1/S")
    motor_inertia: float | None = positive(
        "Motor inertia of disturbance_observer and torque_regulation [kg m^2]. Default: fitted to the log.",
        metavar="KG_M2",
    )
    desired_inertia: float | None = positive(
        "Desired inertia of torque_regulation [kg m^2]. Default: half the motor inertia.", metavar="KG_M2"
    )
    operator: str | None = option(
        "Person's impedance at the joint with --assume same-operator [kg m^2, N m s/rad, N m/rad]. Default: fitted "
        "to the log.", metavar="MASS,DAMPING,STIFFNESS",
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse options that contradict each other, before any log is read."""
        inertial = ("disturbance_observer", "torque_regulation")
        users = {
            "--compensator-model": (self.model, ("energy",)),
            "--compensator-window": (self.window, ("energy",)),
            "--factor": (None if self.factor == 1.0 else self.factor, ("energy",)),
            "--coefficients": (self.coefficients, ("energy",)),
            "--max-damping": (self.max_damping, ("energy",)),
            "--no-passivity": (self.no_passivity or None, ("energy",)),
            "--observer-gain": (self.observer_gain, inertial[:1]),
            "--motor-inertia": (self.motor_inertia, inertial),
            "--desired-inertia": (self.desired_inertia, inertial[1:]),
        }
        given = {name: own for name, (value, own) in users.items() if value is not None}
        unused = [name for name in ("--compensator-model", "--compensator-window", "--factor") if name in given]
        if self.coefficients is not None and unused:
            raise UsageError(f"--coefficients {self.coefficients}: nothing is estimated; remove {', '.join(unused)}")
        if wrong := [name for name, own in given.items() if self.compensator not in own]:
            raise UsageError(f"--compensator {self.compensator}: does not use {', '.join(wrong)}; remove it")
        if self.no_passivity and self.max_damping is not None:
            raise UsageError("--no-passivity --max-damping: only the controller damps; remove one of them")


def command(
    log: opt.LogPath,
    options: ReplayOptions,
    shared: opt.LogOptions,
    drawn: opt.FigureOptions,
    folder: Path | None = opt.folder_option(f"Also write {DOCUMENT}, {HISTORY} and the figures to DIR."),
    figures: list[str] = opt.figures_option(REPLAY_FIGURES),
    export: opt.Exports = [],
    strict: opt.Strict = False,
) -> None:
    """Replay a friction compensator with passivity controller."""
    voice = shared.general.voice
    settings = replay_settings(options, shared.cycles)
    audit, reading = chain.audit_settings(shared), chain.read_options(shared.reading, shared.selection)
    out = ResultFolder(folder, "replay", figures, drawn.formats, export, overwrite=shared.overwrite)
    out.check(log, (DOCUMENT, HISTORY), "replay:REPLAY")
    with voice.stages(3 + out.stages) as stages:
        with chain.loading("friction_audit.friction.estimate", "friction_audit.compensation.plant"):
            from friction_audit.pipeline import while_read

            # Figures and exports take all samples at once, and so does a joint that moves otherwise.
            in_blocks = folder is None and not settings.needs_whole
            # The text of the terminal shows no hash; that of a model's log is compared with it.
            hashed = shared.general.json or not in_blocks or settings.joint_model is not None
            how = replace(reading, in_blocks=in_blocks, hashed=hashed)
            recorded = chain.read(log, how, stages, while_read(audit))
        if settings.joint_model is not None:
            chain.check_joint_model(settings.joint_model.path, settings.joint_model.model, recorded)
        estimated = chain.estimate(recorded, audit, stages)
        from friction_audit.pipeline import replay_estimate
        from friction_audit.reporting import replay as output
        from friction_audit.reporting.notices import replay_notices

        with stages.step("replay"):
            found = replay_estimate(estimated, settings)
        joints = found.replay.joints
        chain.warn_about(recorded, replay_notices(found), stages, marked=not all(one.reason for one in joints))
        _warn_of_times(settings.joint_model, recorded, stages)
        chain.require_one(recorded, joints, "no joint can be replayed")
        document = partial(output.REPLAY.of, found, chain.reading_settings(reading))
        text = out.write_document(DOCUMENT, document, voice)
        out.write_csv(HISTORY, output.HISTORY.file(joints, "history", recorded.source.torque_unit))
        out.write_figures({"replay": found}, [joint.joint for joint in joints], recorded.source.torque_unit, stages)
        out.write_exports(output.REPLAY.tables(found), recorded, stages)
    show(text, lambda: output.replay_lines(found), voice)
    chain.conclude(recorded, replay_notices(found), strict=strict)


def _warn_of_times(given: "ModelFile | None", log: "JointLog", voice: Voice) -> None:
    """Warn of effects of a model that hold for times of another recording."""
    for number, joint in enumerate(() if given is None else given.model.joints, start=1):
        if joint is None or joint.provenance.sha256 in ("", log.source.sha256):
            continue
        if names := ", ".join(term.name for term in joint.terms if term.name in TIMED):
            held = f"holds for moments of {joint.provenance.log}, not of this log"
            voice.warn([f"joint {number}: {names} of the model {held}"], held=True)


def replay_settings(options: ReplayOptions, cycles: opt.CycleOptions) -> "ReplaySettings":
    """Return the settings."""
    from friction_audit.compensation import settings
    from friction_audit.effects.joint_model import load_model

    def given(**values: object) -> dict[str, Any]:
        return {name: value for name, value in values.items() if value is not None}

    competitor = operator = None
    if options.compensator != "energy":
        tuning = given(
            observer_gain_per_s=options.observer_gain,
            motor_inertia_kg_m2=options.motor_inertia,
            desired_inertia_kg_m2=options.desired_inertia,
        )
        competitor = settings.Competitor(name=options.compensator, **tuning)
    if options.operator is not None:
        numbers = parse_numbers("--operator", options.operator, ("MASS", "DAMPING", "STIFFNESS"))
        names = ("inertia_kg_m2", "damping_nms_per_rad", "stiffness_nm_per_rad")
        operator = settings.OperatorImpedance(**dict(zip(names, numbers, strict=True)))
    forced = None if options.coefficients is None else _parse_coefficients(options.coefficients)
    least = cycles.min_path if cycles.cycles_from == "hand" else None
    own = given(model=options.model, minimum_path_rad=least, max_damping_nms_per_rad=options.max_damping)
    compensator = settings.energy_compensator(
        window=options.window, factor=options.factor, forced=forced, forced_from_cycle=1, forced_until_acted=False,
        passivity=not options.no_passivity, **own,
    )  # fmt: skip
    path = options.joint_model
    model = None if path is None else settings.ModelFile(path=str(path), model=load_model(path))
    return settings.ReplaySettings(
        assume=options.assume, compensator=compensator, competitor=competitor, joint_model=model, operator=operator,
        max_torque_nm=options.max_torque, max_torque_rate_nm_s=options.max_rate,
    )  # fmt: skip


def _parse_coefficients(text: str) -> "Coefficients":
    """Return the coefficients of ``"coulomb=0.2,viscous=0.1"``; one left out is zero."""
    from friction_audit.compensation.law import Coefficients

    parts = [part.strip().partition("=") for part in text.split(",")]
    with suppress(ValueError):
        values = {"coulomb": 0.0, "viscous": 0.0} | {name: float(number) for name, _, number in parts}
        once = len(values) == len(("coulomb", "viscous")) and len({name for name, *_ in parts}) == len(parts)
        if once and all(0.0 <= value < inf for value in values.values()):
            return Coefficients(coulomb_nm=values["coulomb"], viscous_nms_per_rad=values["viscous"])
    expected = "coulomb=NUMBER,viscous=NUMBER of zero or more; less would brake the joint"
    raise UsageError(f"--coefficients {text}: expected {expected}")
