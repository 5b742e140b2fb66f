"""Help text with the options under headings, without loading rich."""

import inspect
from collections.abc import Callable, Collection
from dataclasses import fields, is_dataclass
from typing import Any

import typer
from typer.core import TyperCommand

from friction_audit.cli.config import command_line, dump_config
from friction_audit.cli.console import say
from friction_audit.errors import UsageError
from friction_audit.preprocessing.settings import GIVEN, TorqueSettings

CONTEXT = "context"
"""Parameter of a command that takes Typer's context."""
ARGUMENTS, REPLAY, SIMULATION, COMPARISON = "Arguments", "Replay", "Simulation", "Comparison"
SESSIONS, DRIFT, ESTIMATE, DIAGNOSIS = "Sessions", "Drift", "Estimate", "Diagnosis"
OUTPUT, COMMON, FIGURE_FILES = "Output", "Common options", "Figure files"
READING, SELECTION, TORQUE, CYCLES = "Reading the log", "Part of the log", "Interaction torque", "Energy cycles"
TUNING, RUNNING, GENERAL = "Compensator", "Processes", "General"
MOTION = "Motion"
EVERY = "friction_audit.every_option"  # key in the context of a help that shows every option

HEADINGS: dict[str, Collection[str] | None] = {
    ARGUMENTS: None,
    REPLAY: None,
    SIMULATION: None,
    COMPARISON: None,
    SESSIONS: None,
    DRIFT: None,
    ESTIMATE: ("estimate",),
    DIAGNOSIS: ("diagnose",),
    MOTION: None,
    OUTPUT: None,
    FIGURE_FILES: ("plot", "compare", "reproduce"),
    COMMON: None,
    READING: ("info", "convert"),
    SELECTION: ("info", "convert"),
    TORQUE: (),
    CYCLES: (),
    TUNING: (),
    RUNNING: (),
    GENERAL: (),
}
"""Headings of the help in their order -> the commands whose ``--help`` shows them, None: every one that has options
there; ``--help-all`` shows all."""
RENAMED = {
    ("diagnose", "--model"): "--joint-model",
    ("simulate", "--model"): "--joint-model",
    ("plot", "--kind"): "--figures",
    ("replay", "--fixed"): "--coefficients",
    ("replay", "--window"): "--compensator-window",
    ("replay", "--model"): "--compensator-model",
    ("compare", "--margin-seeds"): "--margin-persons",
    **{(command, "--seeds"): "--persons" for command in ("compare", "reproduce")},
    **{(command, "--format"): "--figure-format" for command in ("plot", "compare", "reproduce")},
}


class GroupedCommand(TyperCommand):
    """A command whose help lists its options by task, those without a task (``--help``) last."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:  # noqa: ANN401 - types of Typer's private copy of click
        """Refuse the former name of an option with its new one."""
        for word in args:
            old = word.partition("=")[0]
            if (new := RENAMED.get((str(self.name), old))) is not None:
                raise UsageError(f"{old}: {self.name} calls it {new}; write {new}")
        return super().parse_args(ctx, args)

    def format_options(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401 - types of Typer's private copy of click
        """Write arguments and options under their headings; with ``--help`` only those that the command shows."""
        records: dict[str, list[tuple[str, str]]] = {heading: [] for heading in HEADINGS}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                records[_heading(parameter)].append(record)
        for heading, commands in HEADINGS.items():
            shown = commands is None or self.name in commands or ctx.meta.get(EVERY)
            if records[heading] and shown:
                with formatter.section(heading):
                    formatter.write_dl(records[heading])


def _heading(parameter: Any) -> str:  # noqa: ANN401 - as above
    if parameter.param_type_name == "argument":
        return ARGUMENTS
    return str(getattr(parameter, "rich_help_panel", None) or COMMON)


def show_every_option(context: typer.Context, wanted: bool) -> None:
    """Print the help with every option and stop."""
    if wanted and not context.resilient_parsing:
        context.meta[EVERY] = True
        say(context.get_help())
        raise typer.Exit


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command as Typer wants it: every dataclass parameter replaced by its fields, --dump-config served.

    A field carries its option as ``Annotated[type, typer.Option(...)]`` and its default as the field's default; a field
    that is a dataclass itself is a group within the group.
    """
    parameters = [p for p in inspect.signature(command).parameters.values() if p.name != CONTEXT]
    groups = {p.name: p.annotation for p in parameters if is_dataclass(p.annotation)}
    flat = [one for p in parameters for one in (_fields(p.annotation) if p.name in groups else [_keyword(p)])]
    takes_context = CONTEXT in inspect.signature(command).parameters

    def run(context: typer.Context, **values: Any) -> None:  # noqa: ANN401 - any option
        if values.get("dump_config"):
            say(dump_config(context), nl=False)
            return
        own = "gravity" in values
        filled = {name: _fill(group, values) for name, group in groups.items()}
        choices = [one.name.removesuffix("_hz") for one in fields(TorqueSettings)]
        given = GIVEN.set(command_line(context, leave_out=choices) if own else "")
        try:
            command(**filled, **values, **({CONTEXT: context} if takes_context else {}))
        finally:
            GIVEN.reset(given)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    context = inspect.Parameter(CONTEXT, inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    run.__annotations__ = {p.name: p.annotation for p in (context, *flat)}
    run.__signature__ = inspect.Signature([context, *flat])  # type: ignore[attr-defined]
    return run


def _fields(group: Any) -> list[inspect.Parameter]:  # noqa: ANN401 - a dataclass
    found: list[inspect.Parameter] = []
    for f in fields(group):
        one = inspect.Parameter(f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=f.type)
        found += _fields(f.type) if is_dataclass(f.type) else [one]
    return found


def _keyword(parameter: inspect.Parameter) -> inspect.Parameter:
    return parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)


def _fill(group: Any, values: dict[str, Any]) -> Any:  # noqa: ANN401 - a dataclass
    taken = {f.name: _fill(f.type, values) if is_dataclass(f.type) else values.pop(f.name) for f in fields(group)}
    return group(**taken)
