"""Parameters of a command: options declared in groups, their help under headings without rich, values from a file."""

import inspect
import shlex
from collections.abc import Callable, Collection, Sequence
from dataclasses import Field, dataclass, field, fields, is_dataclass
from functools import partial
from math import inf
from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any, NamedTuple, TypeVar, dataclass_transform

import typer
from typer.core import TyperCommand

from friction_audit.cli.console import say
from friction_audit.effects import registry
from friction_audit.errors import UsageError, few, near_misses, printable, shortened
from friction_audit.io.files import read_toml
from friction_audit.joint_numbers import parse_joint_numbers
from friction_audit.preprocessing.settings import GIVEN, TorqueSettings
from friction_audit.reporting.figures import figures_of, style as figure_style

FIGURES, REPLAY_FIGURES, DIAGNOSIS_FIGURES, BATCH_FIGURES, DIFF_FIGURES = (
    tuple(figure.name for figure in figures_of(result))
    for result in ("estimate", "replay", "diagnosis", "drift", "diff")
)
PLOTTED = (*FIGURES, *REPLAY_FIGURES, *DIAGNOSIS_FIGURES)
ALL = "all"
Group = TypeVar("Group")
OPTION = "option"  # key of a field's metadata
EFFECTS, IMAGE_FORMATS = registry.NAMES, figure_style.FORMATS
EXPORTS = ("mcap", "csv", "parquet")


def completed_by(names: Sequence[str] | str, *, several: bool = False) -> Callable[[str], list[str]]:
    """Return what a shell completes an option with: one of the names, or of several another one after a comma.

    Names may be those of a registry, ``"module:REGISTRY"``, whose module loads numerics.
    """

    def offer(incomplete: str) -> list[str]:
        chosen, comma, begun = incomplete.rpartition(",") if several else ("", "", incomplete)
        known = names if not isinstance(names, str) else [one.name for one in resolve_name(f"friction_audit.{names}")]
        left = (name for name in known if name not in chosen.split(","))
        return [f"{chosen}{comma}{name}" for name in left if name.startswith(begun)]

    return offer


@dataclass_transform(kw_only_default=True, frozen_default=True)
def group(heading: str) -> Callable[[type[Group]], type[Group]]:
    """Return what makes a class a group of options under a heading of the help, but those with another one."""

    def make(of: type[Group]) -> type[Group]:
        made = dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)(of)
        for one in fields(made):  # type: ignore[arg-type] # it is a dataclass by now
            info = one.metadata.get(OPTION)
            if info and info.rich_help_panel is None:
                info.rich_help_panel = heading
        return made

    return make


def option(text: str, *names: str, default: object = None, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option as the default of a parameter of a command, or of a field of a group; see ``described``."""
    return field(default=default, metadata={OPTION: described(text, *names, **settings)})


def flag(text: str, *names: str, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option without a value, by its names: of a single one Typer would make two, with and without no-."""
    return option(text, *names, default=False, **settings)


def positive(text: str, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option for a number above zero, a bound that click has not."""

    def check(value: float | None) -> float | None:
        if value is not None and not value > 0.0:
            raise typer.BadParameter(f"{value:g}: expected a number above zero")
        return value

    return option(text, callback=check, **settings)


def described(
    text: str,
    *names: str,
    panel: str | None = None,
    one_of: Sequence[str] = (),
    some_of: Sequence[str] = (),
    **settings: Any,  # noqa: ANN401 - of typer.Option
) -> Any:  # noqa: ANN401 - of Typer
    """Return an option for ``Annotated``; ``one_of`` its values, or ``some_of`` them, repeated or between commas."""
    if known := tuple(one_of or some_of):
        shown = f"{'|'.join(known)}{',...' if some_of else ''}"
        offer = completed_by(known, several=bool(some_of))
        settings = {"metavar": shown, "callback": check_known(known), "autocompletion": offer, **settings}
    return typer.Option(*names, help=text, rich_help_panel=panel, **settings)


def check_known(names: Sequence[str]) -> Callable[[Any], Any]:
    """Return what refuses a value that is, or holds, none of the names, and leaves repetitions out."""

    def check(value: Any) -> Any:  # noqa: ANN401 - a name, several of them, or None
        several = isinstance(value, list | tuple)
        chosen = [name.strip() for one in value for name in one.split(",")] if several else [value]
        for name in chosen:
            if name is not None and name not in names:
                near = near_misses(name, names)
                raise typer.BadParameter(f"{printable(name)}: expected one of {', '.join(names)}{near}")
        return list(dict.fromkeys(chosen)) if several else value

    return check


def set_style(name: str) -> str:
    """Draw the figures of this command in a style."""
    figure_style.STYLE.set(figure_style.load_style(name))
    return name


def parse_joints(text: str | None) -> tuple[int, ...] | None:
    """Return the joints of ``"1,3-5"``, in order and each once, or None for all."""
    return None if text is None else parse_joint_numbers(text, f"--joints {text}")


def parse_numbers(option: str, text: str, names: tuple[str, ...], *words: str) -> tuple[float, ...]:
    """Return the numbers of ``"0.2,0.05"``, one per name; the option also takes some words."""
    try:
        found = tuple(map(float, text.split(",")))
    except ValueError:
        found = ()
    if len(found) != len(names):
        numbers = f"{len(names)} number{'s' * (len(names) > 1)} {','.join(names)}"
        raise UsageError(f"{option} {printable(text)}: expected {' or '.join((*words, numbers))}")
    return found


def parse_range(
    option: str, text: str | None, unit: str, least: float = -inf, most: float = inf
) -> tuple[float, float] | None:
    """Return the ends of ``"0.01,1"``; None where there is no text."""
    if text is None:
        return None
    low, high = parse_numbers(option, text, ("LOW", "HIGH"))
    if not (least <= low < high <= most and high < inf):
        ends = (f"{least:g} <= " if least > -inf else "", f" <= {most:g}" if most < inf else "")
        raise UsageError(f"{option} {text}: expected {ends[0]}LOW < HIGH{ends[1]} [{unit}]")
    return low, high


def parse_mapping(entries: list[str] | None) -> dict[str, str]:
    """Return the mapping of ``["dq=vel_{i}", ...]``: channel -> name in the file."""
    mapping: dict[str, str] = {}
    for entry in entries or []:
        channel, equals, name = entry.partition("=")
        if not equals or not channel or not name:
            raise UsageError(f"--map {entry}: expected CHANNEL=NAME, e.g. --map dq=velocity_{{i}}")
        if channel in mapping:
            raise UsageError(f"--map {entry}: {channel} is mapped twice; give its names separated by commas")
        mapping[channel] = name
    return mapping


CONTEXT = "context"  # parameter of a command that takes Typer's context
ARGUMENTS, REPLAY, SIMULATION, COMPARISON = "Arguments", "Replay", "Simulation", "Comparison"
SESSIONS, DRIFT, ESTIMATE, DIAGNOSIS = "Sessions", "Drift", "Estimate", "Diagnosis"
OUTPUT, COMMON, FIGURE_FILES = "Output", "Common options", "Figure files"
READING, SELECTION, TORQUE, CYCLES = "Reading the log", "Part of the log", "Interaction torque", "Energy cycles"
TUNING, RUNNING, GENERAL, MOTION = "Compensator", "Processes", "General", "Motion"
EVERY = "friction_audit.every_option"  # key in the context of a help that shows every option

# Headings of the help in their order -> the commands whose ``--help`` shows them, None: every one that has options
# there; ``--help-all`` shows all.
HEADINGS: dict[str, Collection[str] | None] = {
    **dict.fromkeys((ARGUMENTS, REPLAY, SIMULATION, COMPARISON, SESSIONS, DRIFT)),
    ESTIMATE: ("estimate",),
    DIAGNOSIS: ("diagnose",),
    MOTION: None,
    OUTPUT: None,
    FIGURE_FILES: ("plot", "compare", "reproduce"),
    COMMON: None,
    **dict.fromkeys((READING, SELECTION), ("info", "convert")),
    **dict.fromkeys((TORQUE, CYCLES, TUNING, RUNNING, GENERAL), ()),
}


class _Given(NamedTuple):
    """Lets Typer convert only what was given and is no text: it loads pydantic for that, a fifth of a short run."""

    runtime_param: Callable[[], Any]

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:  # noqa: ANN401 - as Typer's own
        """Return the value of a parameter."""
        kind, is_argument = param.type_descriptor.annotation, param.param_type_name == "argument"
        several = param.multiple or param.nargs == -1
        if value is None:
            return () if several else None
        if ctx.get_parameter_source(param.name).name == "DEFAULT":
            return list(value) if several else value
        if isinstance(value, str) and (kind is str or (kind is Path and is_argument)):
            return kind(value)
        return self.runtime_param().coerce(value, param=param, ctx=ctx)


class LateParams:
    """A command of Typer whose parameters are converted late."""

    def get_params(self, ctx: Any) -> Any:  # noqa: ANN401 - of Typer's private copy of click
        """Return the parameters."""
        found = super().get_params(ctx)  # type: ignore[misc] # of TyperCommand or TyperGroup
        for one in found:
            if not isinstance(one.get_runtime_param, partial):
                one.get_runtime_param = partial(_Given, one.get_runtime_param)
        return found


class GroupedCommand(LateParams, TyperCommand):
    """A command whose help lists its options by task, those without a task (``--help``) last."""

    def format_options(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401 - types of Typer's private copy of click
        """Write arguments and options under their headings; with ``--help`` only those that the command shows."""
        records: dict[str, list[tuple[str, str]]] = {heading: [] for heading in HEADINGS}
        for parameter in self.get_params(ctx):
            if (record := parameter.get_help_record(ctx)) is not None:
                heading = getattr(parameter, "rich_help_panel", None) or COMMON
                records[ARGUMENTS if parameter.param_type_name == "argument" else heading].append(record)
        for heading, commands in HEADINGS.items():
            if records[heading] and (commands is None or self.name in commands or ctx.meta.get(EVERY)):
                with formatter.section(heading):
                    formatter.write_dl(records[heading])


def show_every_option(context: typer.Context, wanted: bool) -> None:
    """Print the help with every option and stop."""
    if wanted and not context.resilient_parsing:
        context.meta[EVERY] = True
        say(context.get_help())
        raise typer.Exit


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command as Typer wants it: every dataclass parameter replaced by its fields."""
    parameters = inspect.signature(command).parameters.values()
    flat = [one for p in parameters if p.name != CONTEXT for one in _flat(p.name, p.annotation, p.default)]

    def run(context: typer.Context, **values: Any) -> None:  # noqa: ANN401 - any option
        choices = [one.name.removesuffix("_hz") for one in fields(TorqueSettings)]
        again = command_line(context, leave_out=choices) if "gravity" in values else ""
        writes = " --output " in again or context.command.name in ("report", "plot")
        given = GIVEN.set(again + " --overwrite" * (writes and values.get("overwrite") is False))
        values[CONTEXT] = context
        try:
            command(**{p.name: _filled(p.name, p.annotation, values) for p in parameters})
        finally:
            GIVEN.reset(given)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    context = inspect.Parameter(CONTEXT, inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    run.__annotations__ = {p.name: p.annotation for p in (context, *flat)}
    run.__signature__ = inspect.Signature([context, *flat])  # type: ignore[attr-defined]
    return run


def _flat(name: str, annotation: Any, default: Any) -> list[inspect.Parameter]:  # noqa: ANN401
    """Return the parameters of a group of options, or a single one, as Typer wants them; a default may be a field."""
    if is_dataclass(annotation):
        return [one for f in fields(annotation) for one in _flat(f.name, f.type, f)]
    if isinstance(default, Field):
        if info := default.metadata.get(OPTION):
            annotation = Annotated[annotation, info]
        default = default.default
    return [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)]


def _filled(name: str, annotation: Any, values: dict[str, Any]) -> Any:  # noqa: ANN401
    """Return the value of a parameter of a command, a group of options filled."""
    if is_dataclass(annotation):
        return annotation(**{f.name: _filled(f.name, f.type, values) for f in fields(annotation)})  # type: ignore[operator]
    return values[name]


NOT_IN_FILES = ("config", "help", "help_all")
LONGEST_KEY = 40  # characters of an unknown key that a message names


def command_line(context: typer.Context, *, leave_out: Collection[str]) -> str:
    """Return the command that was given, as it is typed, without some of its parameters."""
    words: list[str] = []
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if name not in leave_out and source is not None and source.name != "DEFAULT":
            option = max(parameter.opts, key=len) if parameter.param_type_name == "option" else ""
            value = context.params[name]
            if isinstance(value, bool):
                words += [option] if value else []
                continue
            for item in value if isinstance(value, list | tuple) else [value]:
                words += [option, str(item)] if option else [str(item)]
    return shlex.join(["friction-audit", str(context.command.name), *words])


def load_config(context: typer.Context, path: Path | None) -> Path | None:
    """Make the file's values the defaults of the command's options; called before any other option is read."""
    if path is None or context.resilient_parsing:
        return path
    try:
        values = {key.replace("_", "-"): value for key, value in read_toml(path).items()}
    except OSError as error:
        raise typer.BadParameter(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise typer.BadParameter(f"{path}: not TOML with options: {printable(str(error))}") from error
    offered = [p for p in context.command.params if p.param_type_name == "option" and p.name not in NOT_IN_FILES]
    options = {max(option.opts, key=len).removeprefix("--"): option for option in offered}
    if unknown := few([shortened(printable(key), LONGEST_KEY) for key in values if key not in options]):
        named = ", ".join(f"{key}{near_misses(key, tuple(options))}" for key in unknown)
        listed = "" if "?" in named else f" (options of this command: {', '.join(options)})"
        raise typer.BadParameter(f"{path}: no option {named}{listed}")
    given = {options[key].name: _as_given(value, several=options[key].multiple) for key, value in values.items()}
    context.default_map = given
    return path


def _as_given(value: Any, *, several: bool) -> Any:  # noqa: ANN401 - any TOML value
    if isinstance(value, dict):
        value = [f"{key}={item}" for key, item in value.items()]
    if several:
        return [str(item) for item in (value if isinstance(value, list) else [value])]
    if isinstance(value, list):
        return ",".join(map(str, value))
    return value if isinstance(value, bool) else str(value)
