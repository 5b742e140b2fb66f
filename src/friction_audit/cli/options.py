"""The options that commands share, in groups; each is declared here once."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from friction_audit.cli import choices
from friction_audit.cli.config import load_config
from friction_audit.cli.grouped_help import GENERAL

READING, SELECTION, TORQUE = "Reading the log", "Part of the log", "Interaction torque"
CYCLES, ESTIMATE, OUTPUT = "Energy cycles", "Estimate", "Output"

PNG = ["png"]
"""Format of the figures where none is given; Typer copies it."""
NO_EXPORT: list[str] = []
"""Exports where none is asked for; Typer copies it."""

ImageFormats = Annotated[
    list[str],
    typer.Option(
        "--format",
        metavar=choices.metavar(choices.IMAGE_FORMATS),
        callback=choices.some_of(choices.IMAGE_FORMATS),
        autocompletion=choices.offer_some(choices.IMAGE_FORMATS),
        help="Formats of the figures; repeatable, or separated by commas.",
        rich_help_panel=OUTPUT,
    ),
]

FiguresBeside = Annotated[
    list[str],
    typer.Option(
        metavar=choices.metavar(choices.IMAGE_FORMATS),
        callback=choices.some_of(choices.IMAGE_FORMATS),
        autocompletion=choices.offer_some(choices.IMAGE_FORMATS),
        help="Formats of the figures in DIR; repeatable, or separated by commas.",
        rich_help_panel=OUTPUT,
    ),
]

Exports = Annotated[
    list[str],
    typer.Option(
        "--export",
        metavar=choices.metavar(choices.EXPORTS),
        callback=choices.some_of(choices.EXPORTS),
        autocompletion=choices.offer_some(choices.EXPORTS),
        help="Also write every table of the result in DIR: mcap as topics on the log's clock, for Foxglove and "
        "PlotJuggler; csv and parquet a file each. Repeatable, or separated by commas.",
        rich_help_panel=OUTPUT,
    ),
]

FigureFolder = Annotated[
    Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the figures.", rich_help_panel=OUTPUT)
]

LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A log file, or the directory of a ROS 2 bag.")]


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadingOptions:
    """How the log is read."""

    topic: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Topic or table to read, where a file holds several.", rich_help_panel=READING
        ),
    ] = None
    mapping: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="CHANNEL=NAME",
            help="Name of a channel in the file, {i} standing for the joint's index, or names separated by commas, "
            "e.g. dq=velocity_{i}. Repeatable.",
            rich_help_panel=READING,
        ),
    ] = None
    robot: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.ROBOTS),
            callback=choices.one_of(choices.ROBOTS),
            autocompletion=choices.offer_one(choices.ROBOTS),
            help="Whose rigid-body model may be used; auto goes by the names in the log.",
            rich_help_panel=READING,
        ),
    ] = "auto"
    time_scale: Annotated[
        float,
        typer.Option(metavar="FACTOR", help="Factor on the log's clock, if it is stretched.", rich_help_panel=READING),
    ] = 1.0
    allow_short: Annotated[
        bool,
        typer.Option(
            "--allow-short", help="Read even what looks like an exception log of libfranka.", rich_help_panel=READING
        ),
    ] = False


@dataclass(frozen=True, kw_only=True, slots=True)
class SelectionOptions:
    """Which part of the log is looked at."""

    joints: Annotated[
        str | None,
        typer.Option(
            metavar="LIST", help="Joints, counted from 1, e.g. 1,3-5. Default: all.", rich_help_panel=SELECTION
        ),
    ] = None
    t_start: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Start, from the first sample.", rich_help_panel=SELECTION),
    ] = None
    t_end: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="End, from the first sample.", rich_help_panel=SELECTION),
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueOptions:
    """How the interaction torque is made."""

    drive: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.DRIVES),
            callback=choices.one_of(choices.DRIVES),
            autocompletion=choices.offer_one(choices.DRIVES),
            help="Who moves the joint: a hand on the arm, or the robot itself.",
            rich_help_panel=TORQUE,
        ),
    ] = "auto"
    torque: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.TORQUES),
            callback=choices.one_of(choices.TORQUES),
            autocompletion=choices.offer_one(choices.TORQUES),
            help="Channel that the interaction torque is made from.",
            rich_help_panel=TORQUE,
        ),
    ] = "auto"
    gravity: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.GRAVITIES),
            callback=choices.one_of(choices.GRAVITIES),
            autocompletion=choices.offer_one(choices.GRAVITIES),
            help="Where the gravity torque comes from.",
            rich_help_panel=TORQUE,
        ),
    ] = "auto"
    inertia: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.INERTIAS),
            callback=choices.one_of(choices.INERTIAS),
            autocompletion=choices.offer_one(choices.INERTIAS),
            help="Whether inertial and Coriolis torques of the model are removed.",
            rich_help_panel=TORQUE,
        ),
    ] = "auto"
    urdf: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="Another arm than the built-in one.",
            rich_help_panel=TORQUE,
        ),
    ] = None
    payload: Annotated[
        str | None,
        typer.Option(
            metavar="MASS,X,Y,Z", help="Mass [kg] and centre of mass in the flange frame [m].", rich_help_panel=TORQUE
        ),
    ] = None
    gravity_vector: Annotated[
        str, typer.Option(metavar="X,Y,Z", help="Gravity in the base frame [m/s^2].", rich_help_panel=TORQUE)
    ] = "0,0,-9.81"
    model_rate: Annotated[
        float,
        typer.Option(metavar="HZ", help="Rate at which the model of the arm is evaluated.", rich_help_panel=TORQUE),
    ] = 50.0


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleOptions:
    """How energy cycles are found."""

    thresholds: Annotated[
        str,
        typer.Option(
            metavar="auto|INIT,TERM",
            help="Speeds at which a cycle begins and ends [rad/s], or auto: from the log's own noise and speeds.",
            rich_help_panel=CYCLES,
        ),
    ] = "0.2,0.05"
    cycles_from: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.CYCLES_FROM),
            callback=choices.one_of(choices.CYCLES_FROM),
            autocompletion=choices.offer_one(choices.CYCLES_FROM),
            help="joint: each joint has its own cycles; hand: the end effector's speed cuts all joints at once.",
            rich_help_panel=CYCLES,
        ),
    ] = "joint"
    hand_thresholds: Annotated[
        str,
        typer.Option(
            metavar="INIT,TERM", help="Hand speeds at which a cycle begins and ends [m/s].", rich_help_panel=CYCLES
        ),
    ] = "0.1,0.025"
    min_path: Annotated[
        float,
        typer.Option(
            metavar="RAD",
            help="With hand cycles: every joint selected must have moved this far.",
            rich_help_panel=CYCLES,
        ),
    ] = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimateOptions:
    """How friction is estimated."""

    estimator: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.ESTIMATORS),
            callback=choices.one_of(choices.ESTIMATORS),
            autocompletion=choices.offer_one(choices.ESTIMATORS),
            help="weighted: rows weighted by their noise, offset and gravity error beside; paper: the literal method.",
            rich_help_panel=ESTIMATE,
        ),
    ] = "weighted"
    model: Annotated[
        str,
        typer.Option(
            metavar=choices.metavar(choices.MODELS),
            callback=choices.one_of(choices.MODELS),
            autocompletion=choices.offer_one(choices.MODELS),
            help="Friction model.",
            rich_help_panel=ESTIMATE,
        ),
    ] = "combined"
    window: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            help="Cycles per point of the history. Default: 20, for the paper's estimator 2 (or 1).",
            rich_help_panel=ESTIMATE,
        ),
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class OutputOptions:
    """What is printed, and whether results replace older ones."""

    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document and nothing else.", rich_help_panel=OUTPUT)
    ] = False
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace files that exist.", rich_help_panel=OUTPUT)
    ] = False


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneralOptions:
    """What every command understands."""

    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml",
            callback=load_config,
            is_eager=True,
            help='Values for any option, e.g. drive = "robot"; the command line wins.',
            rich_help_panel=GENERAL,
        ),
    ] = None
    dump_config: Annotated[
        bool,
        typer.Option("--dump-config", help="Print the options in force as TOML and stop.", rich_help_panel=GENERAL),
    ] = False
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="No warnings and no progress.", rich_help_panel=GENERAL)
    ] = False
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say what is done and how long it took.", rich_help_panel=GENERAL)
    ] = False


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
        """The options of the whole chain; the estimate that runs beside is the default one."""
        return AuditOptions(
            selection=self.selection,
            reading=self.reading,
            torque=self.torque,
            cycles=self.cycles,
            estimate=EstimateOptions(),
            output=self.output,
            general=self.general,
        )
