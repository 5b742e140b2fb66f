"""The options that commands share, in groups; each is declared here once."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated

import typer

from friction_audit.cli import choices
from friction_audit.cli.choices import option
from friction_audit.cli.config import load_config
from friction_audit.cli.console import Voice
from friction_audit.cli.grouped_help import GENERAL

READING, SELECTION, TORQUE = "Reading the log", "Part of the log", "Interaction torque"
CYCLES, ESTIMATE, DIAGNOSIS, OUTPUT = "Energy cycles", "Estimate", "Diagnosis", "Output"

# Defaults of options that are lists; Typer copies them.
PNG = ["png"]
NO_EXPORT: list[str] = []

FigureFormats = Annotated[
    list[str],
    option(
        OUTPUT,
        "Formats of the figures; repeatable, or separated by commas.",
        "--figure-format",
        some_of=choices.IMAGE_FORMATS,
    ),
]

Exports = Annotated[
    list[str],
    option(
        OUTPUT,
        "Also write every table of the result in DIR: mcap as topics on the log's clock, for Foxglove and "
        "PlotJuggler; csv and parquet a file each. Repeatable, or separated by commas.",
        "--export",
        some_of=choices.EXPORTS,
    ),
]

MinEffect = Annotated[
    float,
    option(
        DIAGNOSIS,
        "Effects of a smaller rms torque are negligible: they are listed apart and change no verdict [N m].",
        "--min-effect",
        metavar="NM",
        min=0.0,
    ),
]


def figures_option(names: Sequence[str]) -> object:
    """Return the option that says which of some figures are drawn."""
    text = f"Figures to draw: {choices.ALL}, or some of {', '.join(names)}. Repeatable, or separated by commas."
    return option(OUTPUT, text, "--figures", some_of=(*names, choices.ALL), metavar="NAME")


FigureFolder = Annotated[Path, option(OUTPUT, "Folder of the figures.", "--output", "-o", metavar="DIR")]

LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A log file, or the directory of a ROS 2 bag.")]


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadingOptions:
    """How the log is read."""

    topic: Annotated[
        str | None,
        option(READING, "Topic or table to read, where a file holds several.", metavar="NAME"),
    ] = None
    mapping: Annotated[
        list[str] | None,
        option(
            READING,
            "Name of a channel in the file, {i} standing for the joint's index, or names separated by commas, "
            "e.g. dq=velocity_{i}. Repeatable.",
            "--map",
            metavar="CHANNEL=NAME",
        ),
    ] = None
    robot: Annotated[
        str,
        option(
            READING, "Whose rigid-body model may be used; auto goes by the names in the log.", one_of=choices.ROBOTS
        ),
    ] = "auto"
    time_scale: Annotated[
        float,
        option(READING, "Factor on the log's clock, if it is stretched.", metavar="FACTOR"),
    ] = 1.0
    allow_short: Annotated[
        bool,
        option(READING, "Read even what looks like an exception log of libfranka.", "--allow-short"),
    ] = False


@dataclass(frozen=True, kw_only=True, slots=True)
class SelectionOptions:
    """Which part of the log is looked at."""

    joints: Annotated[
        str | None,
        option(SELECTION, "Joints, counted from 1, e.g. 1,3-5. Default: all.", metavar="LIST"),
    ] = None
    t_start: Annotated[
        float | None,
        option(SELECTION, "Start, from the first sample.", metavar="SECONDS"),
    ] = None
    t_end: Annotated[
        float | None,
        option(SELECTION, "End, from the first sample.", metavar="SECONDS"),
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueOptions:
    """How the interaction torque is made."""

    drive: Annotated[
        str,
        option(TORQUE, "Who moves the joint: a hand on the arm, or the robot itself.", one_of=choices.DRIVES),
    ] = "auto"
    torque: Annotated[
        str,
        option(TORQUE, "Channel that the interaction torque is made from.", one_of=choices.TORQUES),
    ] = "auto"
    gravity: Annotated[
        str,
        option(TORQUE, "Where the gravity torque comes from.", one_of=choices.GRAVITIES),
    ] = "auto"
    inertia: Annotated[
        str,
        option(TORQUE, "Whether inertial and Coriolis torques of the model are removed.", one_of=choices.INERTIAS),
    ] = "auto"
    urdf: Annotated[
        Path | None,
        option(TORQUE, "Another arm than the built-in one.", metavar="FILE", exists=True, dir_okay=False),
    ] = None
    payload: Annotated[
        str | None,
        option(TORQUE, "Mass [kg] and centre of mass in the flange frame [m].", metavar="MASS,X,Y,Z"),
    ] = None
    gravity_vector: Annotated[str, option(TORQUE, "Gravity in the base frame [m/s^2].", metavar="X,Y,Z")] = "0,0,-9.81"
    model_rate: Annotated[
        float,
        option(TORQUE, "Rate at which the model of the arm is evaluated.", metavar="HZ"),
    ] = 50.0


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleOptions:
    """How energy cycles are found."""

    thresholds: Annotated[
        str,
        option(
            CYCLES,
            "Speeds at which a cycle begins and ends [rad/s], or auto: from the log's own noise and speeds.",
            metavar="auto|INIT,TERM",
        ),
    ] = "0.2,0.05"
    cycles_from: Annotated[
        str,
        option(
            CYCLES,
            "joint: each joint has its own cycles; hand: the end effector's speed cuts all joints at once.",
            one_of=choices.CYCLES_FROM,
        ),
    ] = "joint"
    hand_thresholds: Annotated[
        str,
        option(CYCLES, "Hand speeds at which a cycle begins and ends [m/s].", metavar="INIT,TERM"),
    ] = "0.1,0.025"
    min_path: Annotated[
        float,
        option(CYCLES, "With hand cycles: every joint selected must have moved this far.", metavar="RAD"),
    ] = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimateOptions:
    """How friction is estimated."""

    estimator: Annotated[
        str,
        option(
            ESTIMATE,
            "weighted: equations weighted by their noise, offset and gravity error estimated too; paper: as printed.",
            one_of=choices.ESTIMATORS,
        ),
    ] = "weighted"
    model: Annotated[
        str,
        option(ESTIMATE, "Friction model.", one_of=choices.MODELS),
    ] = "combined"
    window: Annotated[
        int | None,
        option(
            ESTIMATE, "Cycles per point of the history. Default: 20, for the paper's estimator 2 (or 1).", metavar="K"
        ),
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class OutputOptions:
    """What is printed, and whether results replace older ones."""

    json: Annotated[bool, option(OUTPUT, "Print one JSON document and nothing else.", "--json")] = False
    overwrite: Annotated[bool, option(OUTPUT, "Replace files that exist.", "--overwrite")] = False


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneralOptions:
    """What every command understands."""

    config: Annotated[
        Path | None,
        option(
            GENERAL,
            'Values for any option, e.g. drive = "robot"; the command line wins.',
            metavar="FILE.toml",
            callback=load_config,
            is_eager=True,
        ),
    ] = None
    dump_config: Annotated[
        bool,
        option(GENERAL, "Print the options in force as TOML and stop.", "--dump-config"),
    ] = False
    quiet: Annotated[bool, option(GENERAL, "No warnings and no progress.", "--quiet", "-q")] = False
    verbose: Annotated[bool, option(GENERAL, "Say what is done and how long it took.", "--verbose", "-v")] = False

    @property
    def voice(self) -> Voice:
        """How much is said on standard error."""
        return Voice(quiet=self.quiet, verbose=self.verbose)


@dataclass(frozen=True, kw_only=True, slots=True)
class AuditOptions:
    """What every command that goes from a log to its friction understands."""

    selection: SelectionOptions
    reading: ReadingOptions
    torque: TorqueOptions
    cycles: CycleOptions
    estimate: EstimateOptions
    output: OutputOptions
    general: GeneralOptions


@dataclass(frozen=True, kw_only=True, slots=True)
class LogOptions:
    """What every command that goes from a log to its cycles understands."""

    selection: SelectionOptions
    reading: ReadingOptions
    torque: TorqueOptions
    cycles: CycleOptions
    output: OutputOptions
    general: GeneralOptions

    @property
    def audit(self) -> AuditOptions:
        """The options of the whole chain, with the default estimate."""
        return AuditOptions(estimate=EstimateOptions(), **{f.name: getattr(self, f.name) for f in fields(self)})
