"""The options that commands share, in groups; each is declared here once."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from friction_audit.cli import choices
from friction_audit.cli import grouped_help as panel
from friction_audit.cli.choices import option
from friction_audit.cli.console import Voice
from friction_audit.cli.grouped_help import load_config, show_every_option
from friction_audit.friction.settings import ESTIMATORS, MODELS
from friction_audit.preprocessing import settings

# Defaults of options that are lists; Typer copies them.
PNG = ["png"]
NO_EXPORT: list[str] = []

FigureFormats = Annotated[
    list[str], option(panel.FIGURE_FILES, "Formats of the figures.", "--figure-format", some_of=choices.IMAGE_FORMATS)
]


def style_option(heading: str) -> object:
    """Return the option that chooses the rcParams of the figures."""
    text = "sans; ieee or latex: fonts of a paper or of LaTeX; a style of matplotlib, or a style sheet."
    return option(heading, text, metavar="NAME|FILE.mplstyle", callback=choices.style)


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureOptions:
    """How figures are drawn."""

    formats: FigureFormats = ("png",)  # type: ignore[assignment] # a dataclass takes no list
    style: Annotated[str, style_option(panel.FIGURE_FILES)] = "sans"


Exports = Annotated[
    list[str],
    option(
        panel.OUTPUT,
        "Also write every table of the result to DIR: mcap as topics on the log's clock, csv and parquet one file "
        "per table.",
        "--export",
        some_of=choices.EXPORTS,
    ),
]
MinEffect = Annotated[
    float,
    option(
        panel.DIAGNOSIS,
        "Effects of a smaller rms torque are negligible: they are listed separately and do not change the verdict "
        "[N m].",
        "--min-effect",
        metavar="NM",
        min=0.0,
    ),
]


JUnit = Annotated[
    Path | None,
    option(
        panel.DRIFT,
        "Write the limits as JUnit, a test case per joint and limit: a failure where it is exceeded, an error where it "
        "cannot be tested.",
        "--junit",
        metavar="FILE.xml",
    ),
]


def joint_model_option(panel: str, text: str) -> object:
    """Return the option that names the file of a joint model."""
    return option(panel, text, "--joint-model", metavar="FILE.toml", exists=True, dir_okay=False)


def dialect_option(heading: str, text: str) -> object:
    """Return the option that names the dialect of a log to be written."""
    return option(heading, text, metavar="NAME", autocompletion=choices.completed_by(choices.dialects))


def fail_on_option(example: str, changed: str, tested: str) -> object:
    """Return the option that sets limits to coefficients."""
    more = f"with 7 if the {tested} cannot test this limit. Repeatable."
    text = f"Exit with 5 if a coefficient has {changed} further, e.g. {example}; {more}"
    return option(panel.DRIFT, text, metavar="COEFFICIENT=LIMIT")


def figures_option(names: Sequence[str]) -> object:
    """Return the option that says which of some figures are drawn."""
    text = f"Figures to draw: {choices.ALL}, or some of {', '.join(names)}."
    return option(panel.OUTPUT, text, "--figures", some_of=(*names, choices.ALL), metavar="NAME,...")


def folder_option(text: str) -> object:
    """Return the option that names the folder of the results."""
    return option(panel.OUTPUT, text, "--output", "-o", metavar="DIR")


FigureFolder = Annotated[Path, folder_option("Folder of the figures.")]
LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A log file, or the directory of a ROS 2 bag.")]
Overwrite = Annotated[bool, option(panel.GENERAL, "Replace files that exist.", "--overwrite")]
Strict = Annotated[
    bool, option(panel.GENERAL, "Exit with 5, when all is written, if a warning is about the physics.", "--strict")
]


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadingOptions:
    """How the log is read."""

    robot: Annotated[
        str,
        option(
            panel.COMMON,
            "Arm that gives limits and kind of torque, and, of the panda, a rigid-body model; auto: the robot that the "
            "log names.",
            one_of=settings.ROBOTS,
        ),
    ] = "auto"
    topic: Annotated[
        str | None, option(panel.READING, "Topic or table to read, where a file holds several.", metavar="NAME")
    ] = None
    mapping: Annotated[
        list[str] | None,
        option(
            panel.READING,
            "Column of a channel; {i} is the joint's index, or give one name per joint, separated by commas: "
            "dq=velocity_{i}; with a unit: q=angle_{i}:deg, tau_J=i_{i}:A. Repeatable.",
            "--map",
            metavar="CHANNEL=NAME",
        ),
    ] = None
    join: Annotated[
        list[Path] | None,
        option(
            panel.READING,
            "Another file of the same log: its channels are interpolated at the stamps of LOG. Repeatable.",
            "--join",
            metavar="FILE",
        ),
    ] = None
    time_scale: Annotated[
        float, option(panel.READING, "Factor on the log's clock, if its rate is wrong.", metavar="FACTOR")
    ] = 1.0
    torque_constant: Annotated[
        str | None,
        option(
            panel.TORQUE,
            "The torque column is a motor current: torque constant [N m/A], one or per joint.",
            metavar="K,...",
        ),
    ] = None
    gear_ratio: Annotated[
        str | None,
        option(panel.TORQUE, "With it, turns of the motor per turn of the joint, one or per joint.", metavar="N,..."),
    ] = None
    torque_scale: Annotated[
        str | None,
        option(panel.TORQUE, "Factor on the measured torque, one or per joint.", metavar="FACTOR,..."),
    ] = None
    flip: Annotated[
        str | None, option(panel.TORQUE, "Joints whose measured torque has the other sign.", metavar="LIST")
    ] = None
    allow_short: Annotated[
        bool,
        option(panel.READING, "Accept a log that looks like an exception log of libfranka.", "--allow-short"),
    ] = False


@dataclass(frozen=True, kw_only=True, slots=True)
class SelectionOptions:
    """Which part of the log is used."""

    joints: Annotated[
        str | None, option(panel.COMMON, "Joints, counted from 1, e.g. 1,3-5. Default: all.", metavar="LIST")
    ] = None
    t_start: Annotated[
        float | None, option(panel.SELECTION, "Start, counted from the first sample.", metavar="SECONDS")
    ] = None
    t_end: Annotated[
        float | None, option(panel.SELECTION, "End, counted from the first sample.", metavar="SECONDS")
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueOptions:
    """How the interaction torque is made."""

    drive: Annotated[
        str,
        option(
            panel.COMMON,
            "What moves the joints: a hand on the arm, or the robot's motors; auto: the one that dissipates energy.",
            one_of=settings.DRIVES,
        ),
    ] = "auto"
    torque: Annotated[str, option(panel.TORQUE, "Torque channel to use.", one_of=settings.TORQUES)] = "auto"
    gravity: Annotated[
        str,
        option(
            panel.TORQUE,
            "Gravity in tau_J: in-torque: stays in, only cycles that return to their start count; removed: tau_J "
            "holds none; logged, model: subtract the log's or the model's.",
            one_of=settings.GRAVITIES,
        ),
    ] = "auto"
    inertia: Annotated[
        str,
        option(
            panel.TORQUE, "Whether the model's inertial and Coriolis torques are removed.", one_of=settings.INERTIAS
        ),
    ] = "auto"
    urdf: Annotated[
        Path | None,
        option(
            panel.TORQUE,
            "URDF of the arm, from base to flange; its joints are matched with the log's by name, else in order.",
            metavar="FILE",
            exists=True,
            dir_okay=False,
        ),
    ] = None
    payload: Annotated[
        str | None, option(panel.TORQUE, "Mass [kg] and centre of mass in the flange frame [m].", metavar="MASS,X,Y,Z")
    ] = None
    gravity_vector: Annotated[str, option(panel.TORQUE, "Gravity in the base frame [m/s^2].", metavar="X,Y,Z")] = (
        "0,0,-9.81"
    )
    model_rate: Annotated[
        float, option(panel.TORQUE, "Rate at which the rigid-body model is evaluated.", metavar="HZ")
    ] = 50.0


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleOptions:
    """How energy cycles are found."""

    thresholds: Annotated[
        str,
        option(
            panel.CYCLES,
            "Speeds at which a cycle begins and ends [rad/s]; auto: from the log's noise and speeds.",
            metavar="auto|INIT,TERM",
        ),
    ] = "0.2,0.05"
    cycles_from: Annotated[
        str,
        option(
            panel.CYCLES,
            "joint: each joint has its own cycles; hand: the end effector's speed separates the cycles of all joints.",
            one_of=settings.CYCLES_FROM,
        ),
    ] = "joint"
    hand_thresholds: Annotated[
        str, option(panel.CYCLES, "End-effector speeds at which a cycle begins and ends [m/s].", metavar="INIT,TERM")
    ] = "0.1,0.025"
    min_path: Annotated[
        float,
        option(
            panel.CYCLES, "With --cycles-from hand: path that every selected joint must have travelled.", metavar="RAD"
        ),
    ] = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimateOptions:
    """How friction is estimated."""

    estimator: Annotated[
        str,
        option(
            panel.ESTIMATE,
            "weighted: weighted least squares with offset and gravity-error regressors; paper: as published.",
            one_of=ESTIMATORS,
        ),
    ] = "weighted"
    model: Annotated[str, option(panel.ESTIMATE, "Friction model.", one_of=MODELS)] = "combined"
    window: Annotated[
        int | None,
        option(panel.ESTIMATE, "Cycles per point of the history. Default: a third, at most 20; paper: 2.", metavar="K"),
    ] = None


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneralOptions:
    """What every command understands."""

    json: Annotated[bool, option(panel.COMMON, "Print one JSON document and nothing else.", "--json")] = False
    quiet: Annotated[bool, option(panel.COMMON, "No warnings and no progress.", "--quiet", "-q")] = False
    help_all: Annotated[
        bool, option(panel.COMMON, "Show every option.", "--help-all", callback=show_every_option, is_eager=True)
    ] = False
    verbose: Annotated[bool, option(panel.GENERAL, "Print each step and its duration.", "--verbose", "-v")] = False
    config: Annotated[
        Path | None,
        option(
            panel.GENERAL,
            'Values for any option, e.g. drive = "robot"; the command line has priority.',
            metavar="FILE.toml",
            callback=load_config,
            is_eager=True,
        ),
    ] = None
    dump_config: Annotated[
        bool, option(panel.GENERAL, "Print the options in force as TOML and stop.", "--dump-config")
    ] = False

    @property
    def voice(self) -> Voice:
        """What is printed on standard error."""
        return Voice(quiet=self.quiet, verbose=self.verbose)


@dataclass(frozen=True, kw_only=True, slots=True)
class LogOptions:
    """What every command that goes from a log to its cycles understands."""

    selection: SelectionOptions
    reading: ReadingOptions
    torque: TorqueOptions
    cycles: CycleOptions
    general: GeneralOptions
    overwrite: Overwrite = False


@dataclass(frozen=True, kw_only=True, slots=True)
class ChangeOptions:
    """What of a simulation differs from its scenario."""

    effects: Annotated[
        list[str] | None,
        option(
            panel.SIMULATION,
            "Add an effect to all moving joints, or to some: stribeck:excess_nm=0.2@2,5. Repeatable.",
            "--effect",
            metavar="NAME[:PARAMETER=VALUE,...][@JOINTS]",
            autocompletion=choices.completed_by(lambda: choices.EFFECTS),
        ),
    ] = None
    assignments: Annotated[
        list[str] | None,
        option(
            panel.SIMULATION,
            "Change a setting: joints.coulomb_nm=0.4@2,5. Repeatable.",
            "--set",
            metavar="NAME=VALUE[@JOINTS]",
        ),
    ] = None
    ideal: Annotated[
        bool,
        option(
            panel.SIMULATION,
            "Sensors without noise and quantisation, no dropped samples; --set may override.",
            "--ideal",
        ),
    ] = False
