"""The options that commands share, in groups; each is declared here once."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from friction_audit.cli import choices
from friction_audit.cli import grouped_help as panel
from friction_audit.cli.choices import described, option
from friction_audit.cli.console import Voice
from friction_audit.cli.grouped_help import load_config, show_every_option
from friction_audit.friction.settings import ESTIMATORS, MODELS
from friction_audit.preprocessing import settings

FigureFormats = Annotated[
    list[str],
    described(panel.FIGURE_FILES, "Formats of the figures.", "--figure-format", some_of=choices.IMAGE_FORMATS),
]


def style_option(heading: str) -> Any:  # noqa: ANN401 - of any parameter, as those below
    """Return the option that chooses the rcParams of the figures."""
    text = "sans; ieee or latex: fonts of a paper or of LaTeX; a style of matplotlib, or a style sheet."
    return option(heading, text, default="sans", metavar="NAME|FILE.mplstyle", callback=choices.style)


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureOptions:
    """How figures are drawn."""

    formats: FigureFormats = ("png",)  # type: ignore[assignment] # a dataclass takes no list
    style: str = style_option(panel.FIGURE_FILES)


Exports = Annotated[
    list[str],
    described(
        panel.OUTPUT,
        "Also write every table of the result to DIR: mcap as topics on the log's clock, csv and parquet one file "
        "per table.",
        some_of=choices.EXPORTS,
    ),
]
MIN_EFFECT = (
    "Effects of a smaller rms torque are negligible: they are listed separately and do not change the verdict [N m]."
)
MinEffect = Annotated[float, described(panel.DIAGNOSIS, MIN_EFFECT, metavar="NM", min=0.0)]
JUNIT = (
    "Write the limits as JUnit, a test case per joint and limit: a failure where it is exceeded, an error where it "
    "cannot be tested."
)
JUnit = Annotated[Path | None, described(panel.DRIFT, JUNIT, metavar="FILE.xml")]


def joint_model_option(panel: str, text: str) -> Any:  # noqa: ANN401
    """Return the option that names the file of a joint model."""
    return option(panel, text, "--joint-model", metavar="FILE.toml", exists=True, dir_okay=False)


def dialect_option(heading: str, text: str) -> Any:  # noqa: ANN401
    """Return the option that names the dialect of a log to be written."""
    return option(heading, text, metavar="NAME", autocompletion=choices.completed_by(choices.dialects))


def fail_on_option(example: str, changed: str, tested: str) -> Any:  # noqa: ANN401
    """Return the option that sets limits to coefficients."""
    more = f"with 7 if the {tested} cannot test this limit. Repeatable."
    text = f"Exit with 5 if a coefficient has {changed} further, e.g. {example}; {more}"
    return option(panel.DRIFT, text, metavar="COEFFICIENT=LIMIT")


def figures_option(names: Sequence[str], default: str = choices.ALL) -> Any:  # noqa: ANN401
    """Return the option that says which of some figures are drawn."""
    text, known = f"Figures to draw: {choices.ALL}, or some of {', '.join(names)}.", (*names, choices.ALL)
    return option(panel.OUTPUT, text, "--figures", default=(default,), some_of=known, metavar="NAME,...")


def folder_option(text: str, default: Path | None = None) -> Any:  # noqa: ANN401
    """Return the option that names the folder of the results."""
    return option(panel.OUTPUT, text, "--output", "-o", default=default, metavar="DIR")


LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A log file, or the directory of a ROS 2 bag.")]
Overwrite = Annotated[bool, described(panel.GENERAL, "Replace files that exist.", "--overwrite")]
Strict = Annotated[
    bool, described(panel.GENERAL, "Exit with 5, when all is written, if a warning is about the physics.", "--strict")
]


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadingOptions:
    """How the log is read."""

    robot: str = option(
        panel.COMMON,
        "Arm that gives limits and kind of torque, and, of the panda, a rigid-body model; auto: the robot that the "
        "log names.",
        default="auto",
        one_of=settings.ROBOTS,
    )
    topic: str | None = option(panel.READING, "Topic or table to read, where a file holds several.", metavar="NAME")
    mapping: list[str] | None = option(
        panel.READING,
        "Column of a channel; {i} is the joint's index, or give one name per joint, separated by commas: "
        "dq=velocity_{i}; with a unit: q=angle_{i}:deg, tau_J=i_{i}:A. Repeatable.",
        "--map",
        metavar="CHANNEL=NAME",
    )
    join: list[Path] | None = option(
        panel.READING,
        "Another file of the same log: its channels are interpolated at the stamps of LOG. Repeatable.",
        "--join",
        metavar="FILE",
    )
    time_scale: float = option(
        panel.READING, "Factor on the log's clock, if its rate is wrong.", default=1.0, metavar="FACTOR"
    )
    torque_constant: str | None = option(
        panel.TORQUE,
        "The torque column is a motor current: torque constant [N m/A], one or per joint.",
        metavar="K,...",
    )
    gear_ratio: str | None = option(
        panel.TORQUE, "With it, turns of the motor per turn of the joint, one or per joint.", metavar="N,..."
    )
    torque_scale: str | None = option(
        panel.TORQUE, "Factor on the measured torque, one or per joint.", metavar="FACTOR,..."
    )
    flip: str | None = option(panel.TORQUE, "Joints whose measured torque has the other sign.", metavar="LIST")
    allow_short: bool = option(
        panel.READING, "Accept a log that looks like an exception log of libfranka.", "--allow-short", default=False
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class SelectionOptions:
    """Which part of the log is used."""

    joints: str | None = option(panel.COMMON, "Joints, counted from 1, e.g. 1,3-5. Default: all.", metavar="LIST")
    t_start: float | None = option(panel.SELECTION, "Start, counted from the first sample.", metavar="SECONDS")
    t_end: float | None = option(panel.SELECTION, "End, counted from the first sample.", metavar="SECONDS")


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueOptions:
    """How the interaction torque is made."""

    drive: str = option(
        panel.COMMON,
        "What moves the joints: a hand on the arm, or the robot's motors; auto: the one that dissipates energy.",
        default="auto",
        one_of=settings.DRIVES,
    )
    torque: str = option(panel.TORQUE, "Torque channel to use.", default="auto", one_of=settings.TORQUES)
    gravity: str = option(
        panel.TORQUE,
        "Gravity in tau_J: in-torque: stays in, only cycles that return to their start count; removed: tau_J holds "
        "none; logged, model: subtract the log's or the model's.",
        default="auto",
        one_of=settings.GRAVITIES,
    )
    inertia: str = option(
        panel.TORQUE,
        "Whether the model's inertial and Coriolis torques are removed.",
        default="auto",
        one_of=settings.INERTIAS,
    )
    urdf: Path | None = option(
        panel.TORQUE,
        "URDF of the arm, from base to flange; its joints are matched with the log's by name, else in order.",
        metavar="FILE",
        exists=True,
        dir_okay=False,
    )
    payload: str | None = option(
        panel.TORQUE, "Mass [kg] and centre of mass in the flange frame [m].", metavar="MASS,X,Y,Z"
    )
    gravity_vector: str = option(
        panel.TORQUE, "Gravity in the base frame [m/s^2].", default="0,0,-9.81", metavar="X,Y,Z"
    )
    model_rate: float = option(
        panel.TORQUE, "Rate at which the rigid-body model is evaluated.", default=50.0, metavar="HZ"
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleOptions:
    """How energy cycles are found."""

    thresholds: str = option(
        panel.CYCLES,
        "Speeds at which a cycle begins and ends [rad/s]; auto: from the log's noise and speeds.",
        default="0.2,0.05",
        metavar="auto|INIT,TERM",
    )
    cycles_from: str = option(
        panel.CYCLES,
        "joint: each joint has its own cycles; hand: the end effector's speed separates the cycles of all joints.",
        default="joint",
        one_of=settings.CYCLES_FROM,
    )
    hand_thresholds: str = option(
        panel.CYCLES,
        "End-effector speeds at which a cycle begins and ends [m/s].",
        default="0.1,0.025",
        metavar="INIT,TERM",
    )
    min_path: float = option(
        panel.CYCLES,
        "With --cycles-from hand: path that every selected joint must have travelled.",
        default=0.1,
        metavar="RAD",
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimateOptions:
    """How friction is estimated."""

    estimator: str = option(
        panel.ESTIMATE,
        "weighted: weighted least squares with offset and gravity-error regressors; paper: as published.",
        default="weighted",
        one_of=ESTIMATORS,
    )
    model: str = option(panel.ESTIMATE, "Friction model.", default="combined", one_of=MODELS)
    window: int | None = option(
        panel.ESTIMATE, "Cycles per point of the history. Default: a third, at most 20; paper: 2.", metavar="K"
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneralOptions:
    """What every command understands."""

    json: bool = option(panel.COMMON, "Print one JSON document and nothing else.", "--json", default=False)
    quiet: bool = option(panel.COMMON, "No warnings and no progress.", "--quiet", "-q", default=False)
    help_all: bool = option(
        panel.COMMON, "Show every option.", "--help-all", default=False, callback=show_every_option, is_eager=True
    )
    verbose: bool = option(panel.GENERAL, "Print each step and its duration.", "--verbose", "-v", default=False)
    config: Path | None = option(
        panel.GENERAL,
        'Values for any option, e.g. drive = "robot"; the command line has priority.',
        metavar="FILE.toml",
        callback=load_config,
        is_eager=True,
    )
    dump_config: bool = option(
        panel.GENERAL, "Print the options in force as TOML and stop.", "--dump-config", default=False
    )

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

    effects: list[str] | None = option(
        panel.SIMULATION,
        "Add an effect to all moving joints, or to some: stribeck:excess_nm=0.2@2,5. Repeatable.",
        "--effect",
        metavar="NAME[:PARAMETER=VALUE,...][@JOINTS]",
        autocompletion=choices.completed_by(lambda: choices.EFFECTS),
    )
    assignments: list[str] | None = option(
        panel.SIMULATION,
        "Change a setting: joints.coulomb_nm=0.4@2,5. Repeatable.",
        "--set",
        metavar="NAME=VALUE[@JOINTS]",
    )
    ideal: bool = option(
        panel.SIMULATION,
        "Sensors without noise and quantisation, no dropped samples; --set may override.",
        "--ideal",
        default=False,
    )
