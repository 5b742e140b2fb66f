"""The program and its commands."""

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from friction_audit import __version__
from friction_audit.cli.console import say
from friction_audit.cli.grouped_help import GroupedCommand, with_option_groups

if TYPE_CHECKING:
    from types import ModuleType

NAMES = (
    *("info", "estimate", "plot", "replay", "diagnose", "report", "plan", "export", "diff"),
    *("batch-report", "convert", "simulate", "reproduce", "compare"),
)
"""Of the commands, in the order of the help text."""


def module_of(name: str) -> "ModuleType":
    """Return the module of a command, which holds ``command`` and EXAMPLES."""
    return import_module(f"friction_audit.cli.{name.replace('-', '_')}")


@cache
def command_of(name: str) -> Any:  # noqa: ANN401 - types of Typer's private copy of click
    """Return a command, loaded when it is asked for."""
    module, alone = module_of(name), typer.Typer(rich_markup_mode=None, add_completion=False)
    alone.command(name, cls=GroupedCommand, epilog=f"\b\n{module.EXAMPLES}")(with_option_groups(module.command))
    return typer.main.get_command(alone)


class _Group(TyperGroup):
    def __init__(self, **settings: Any) -> None:  # noqa: ANN401 - of TyperGroup
        super().__init__(**settings)
        self.commands: Any = dict.fromkeys(NAMES)  # a misspelt one is compared with these names

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401, ARG002 - as above
        return list(NAMES)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ANN401, ARG002 - as above
        return command_of(cmd_name) if cmd_name in NAMES else None


# Plain help text: rich would cost more time than everything else that --help does.
app = typer.Typer(cls=_Group, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)


def _show_version(wanted: bool) -> None:
    if wanted:
        say(f"friction-audit {__version__}")
        raise typer.Exit


@app.callback()
def program(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Estimate joint friction from recorded logs of a torque-sensed arm."""
