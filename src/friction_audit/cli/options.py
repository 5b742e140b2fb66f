"""The options that commands share, in groups; each is declared here once."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from friction_audit.cli import parameters as params
from friction_audit.cli.console import Voice
from friction_audit.cli.parameters import described, flag, group, load_config, option, show_every_option
from friction_audit.friction.settings import ESTIMATORS, MODELS
from friction_audit.preprocessing import settings

FORMATS = described("Formats of figures.", "--figure-format", some_of=params.IMAGE_FORMATS, panel=params.FIGURE_FILES)
FigureFormats = Annotated[list[str], FORMATS]
STYLE = "sans; ieee or latex: fonts of a paper or of LaTeX; a style of matplotlib, or a style sheet."


@group(params.FIGURE_FILES)
class FigureOptions:
    """How figures are drawn."""

    formats: FigureFormats = ("png",)  # type: ignore[assignment] # a dataclass takes no list
    style: str = option(STYLE, default="sans", metavar="NAME|FILE.mplstyle", callback=params.set_style)


EXPORT = "Also write every table to DIR: mcap as topics on the log's clock, csv and parquet one file per table."
Exports = Annotated[list[str], described(EXPORT, some_of=params.EXPORTS, panel=params.OUTPUT)]
MIN_EFFECT = "Effects of a smaller rms torque [N m] are negligible: listed separately, and not in the verdict."
MinEffect = Annotated[float, described(MIN_EFFECT, metavar="NM", min=0.0, panel=params.DIAGNOSIS)]
FAIL_ON = "Exit with 5 if a coefficient has changed by more, e.g. coulomb=15%, with 7 if it is untestable. Repeatable."
FailOn = Annotated[list[str] | None, described(FAIL_ON, metavar="COEFFICIENT=LIMIT", panel=params.DRIFT)]
JUNIT = "Write the limits as JUnit, a case per joint and limit: failure if exceeded, error if it cannot be tested."
JUnit = Annotated[Path | None, described(JUNIT, metavar="FILE.xml", panel=params.DRIFT)]


def figures_option(names: Sequence[str], default: str = params.ALL) -> Any:  # noqa: ANN401 - of any parameter
    """Return the option that says which of some figures are drawn."""
    text, known = f"Figures to draw: {params.ALL}, or some of {', '.join(names)}.", (*names, params.ALL)
    check = params.check_known(known)
    settings: dict[str, Any] = {"some_of": known, "metavar": "NAME,...", "panel": params.OUTPUT}
    settings["callback"] = lambda value: [name for name in names if {name, params.ALL} & {*check(value)}]
    return option(text, "--figures", default=(default,), **settings)


def folder_option(text: str, default: Path | None = None) -> Any:  # noqa: ANN401
    """Return the option that names the folder of the results."""
    return option(text, "--output", "-o", default=default, metavar="DIR", panel=params.OUTPUT)


DIALECT = "One of convert --list-dialects. Default: the first one with the suffix of the new log."
OFFERED = params.completed_by("io.writers.write_log:WRITERS")
Dialect = Annotated[str | None, described(DIALECT, metavar="NAME", autocompletion=OFFERED, panel=params.GENERAL)]
LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A log file, or the directory of a ROS 2 bag.")]
Overwrite = Annotated[bool, described("Replace files that exist.", "--overwrite", panel=params.GENERAL)]
STRICT = "Exit with 5, when all is written, if a warning is about the physics."
Strict = Annotated[bool, described(STRICT, "--strict", panel=params.GENERAL)]


@group(params.READING)
class ReadingOptions:
    """How the log is read."""

    robot: str = option(
        "Arm that gives limits and kind of torque, and, of the panda, a rigid-body model; auto: the robot that the "
        "log names.", default="auto", one_of=settings.ROBOTS, panel=params.COMMON,
    )  # fmt: skip
    topic: str | None = option("Topic or table to read, where a file holds several.", metavar="NAME")
    mapping: list[str] | None = option(
        "Column of a channel; {i} is the joint's index, or give one name per joint, separated by commas: "
        "dq=velocity_{i}; with a unit: q=angle_{i}:deg, tau_J=i_{i}:A. Repeatable.", "--map", metavar="CHANNEL=NAME",
    )  # fmt: skip
    join: list[Path] | None = option(
        "Another file of the same log: its channels are interpolated at the stamps of LOG. Repeatable.", "--join",
        metavar="FILE",
    )  # fmt: skip
    time_scale: float = option("Factor on the log's clock, if its rate is wrong.", default=1.0, metavar="FACTOR")
    torque_constant: str | None = option(
        "The torque column is a motor current: torque constant [N m/A], one or per joint.", metavar="K,...",
        panel=params.TORQUE,
    )  # fmt: skip
    gear_ratio: str | None = option(
        "With it, turns of the motor per turn of the joint, one or per joint.", metavar="N,...", panel=params.TORQUE
    )
    torque_scale: str | None = option("Factor on the torque, one or per joint.", metavar="K,...", panel=params.TORQUE)
    flip: str | None = option("Joints whose measured torque has the other sign.", metavar="LIST", panel=params.TORQUE)
    allow_short: bool = flag("Accept a log that looks like an exception log of libfranka.", "--allow-short")


@group(params.SELECTION)
class SelectionOptions:
    """Which part of the log is used."""

    joints: str | None = option(
        "Joints, counted from 1, e.g. 1,3-5. Default: all.", metavar="LIST", panel=params.COMMON
    )
    t_start: float | None = option("Start, counted from the first sample.", metavar="SECONDS")
    t_end: float | None = option("End, counted from the first sample.", metavar="SECONDS")


@group(params.TORQUE)
class TorqueOptions:
    """How the interaction torque is made."""

    drive: str = option(
        "What moves the joints: a hand on the arm, or the robot's motors; auto: the one that dissipates energy.",
        default="auto", one_of=settings.DRIVES, panel=params.COMMON,
    )  # fmt: skip
    torque: str = option("Torque channel to use.", default="auto", one_of=settings.TORQUES)
    gravity: str = option(
        "Gravity in tau_J: in-torque: stays in, only cycles that return to their start count; removed: tau_J holds "
        "none; logged, model: subtract the log's or the model's.", default="auto", one_of=settings.GRAVITIES,
    )  # fmt: skip
    inertia: str = option("Inertial and Coriolis torques to remove.", default="auto", one_of=settings.INERTIAS)
    urdf: Path | None = option(
        "URDF of the arm, from base to flange; its joints are matched with the log's by name, else in order.",
        metavar="FILE", exists=True, dir_okay=False,
    )  # fmt: skip
    payload: str | None = option("Mass [kg] and centre of mass in the flange frame [m].", metavar="MASS,X,Y,Z")
    gravity_vector: str = option("Gravity in the base frame [m/s^2].", default="0,0,-9.81", metavar="X,Y,Z")
    model_rate: float = option("Rate of the model's inertial torque and hand speed.", default=50.0, metavar="HZ")


@group(params.CYCLES)
class CycleOptions:
    """How energy cycles are found."""

    thresholds: str = option(
        "Speeds at which a cycle begins and ends [rad/s]; auto: from the log's noise and speeds.", default="0.2,0.05",
        metavar="auto|INIT,TERM",
    )  # fmt: skip
    cycles_from: str = option(
        "joint: each joint has its own cycles; hand: the end effector's speed separates the cycles of all joints.",
        default="joint", one_of=settings.CYCLES_FROM,
    )  # fmt: skip
    hand_thresholds: str = option(
        "End-effector speeds at which a cycle begins and ends [m/s].", default="0.1,0.025", metavar="INIT,TERM"
    )
    min_path: float = option("With --cycles-from hand: least path of every joint.", default=0.1, metavar="RAD")


@group(params.ESTIMATE)
class EstimateOptions:
    """How friction is estimated."""

    estimator: str = option(
        "weighted: weighted least squares with offset and gravity-error regressors; paper: as published.",
        default="weighted", one_of=ESTIMATORS,
    )  # fmt: skip
    model: str = option("Friction model.", default="combined", one_of=MODELS)
    window: int | None = option("Cycles per point of the history. Default: a third, at most 20; paper: 2.", metavar="K")


@group(params.COMMON)
class GeneralOptions:
    """What every command understands."""

    json: bool = flag("Print one JSON document and nothing else.", "--json")
    quiet: bool = flag("No warnings and no progress.", "--quiet", "-q")
    help_all: bool = flag("Show every option.", "--help-all", callback=show_every_option, is_eager=True)
    verbose: bool = flag("Print each step and its duration.", "--verbose", "-v", panel=params.GENERAL)
    config: Path | None = option(
        'Values for any option, e.g. drive = "robot"; the command line has priority.', metavar="FILE.toml",
        callback=load_config, is_eager=True, panel=params.GENERAL,
    )  # fmt: skip

    @property
    def voice(self) -> Voice:
        """What is printed on standard error."""
        return Voice(quiet=self.quiet, verbose=self.verbose, json=self.json)


@group(params.COMMON)
class LogOptions:
    """What every command that goes from a log to its cycles understands."""

    selection: SelectionOptions
    reading: ReadingOptions
    torque: TorqueOptions
    cycles: CycleOptions
    general: GeneralOptions
    overwrite: Overwrite = False


@group(params.SIMULATION)
class ChangeOptions:
    """What of a simulation differs from its scenario."""

    effects: list[str] | None = option(
        "Add an effect to all moving joints, or to some: stribeck:excess_nm=0.2@2,5. Repeatable.", "--effect",
        metavar="NAME[:PARAMETER=VALUE,...][@JOINTS]", autocompletion=params.completed_by(params.EFFECTS),
    )  # fmt: skip
    assignments: list[str] | None = option(
        "Change a setting: joints.coulomb_nm=0.4@2,5. Repeatable.", "--set", metavar="NAME=VALUE[@JOINTS]"
    )
    ideal: bool = flag("Sensors without noise and quantisation, no dropped samples; --set may override.", "--ideal")
