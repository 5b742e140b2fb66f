"""The program and its commands."""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, cast

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
def _command(name: str) -> Any:  # noqa: ANN401 - types of Typer's private copy of click
    module, alone = module_of(name), typer.Typer(rich_markup_mode=None, add_completion=False)
    alone.command(name, cls=GroupedCommand, epilog=f"\b\n{module.EXAMPLES}")(with_option_groups(module.command))
    return typer.main.get_command(alone)


class _Commands(Mapping[str, Any]):
    """Commands by name, each loaded when it is asked for."""

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401 - as above
        if name not in NAMES:
            raise KeyError(name)
        return _command(name)

    def __iter__(self) -> Iterator[str]:
        return iter(NAMES)

    def __len__(self) -> int:
        return len(NAMES)


class _Group(TyperGroup):
    def __init__(self, **settings: Any) -> None:  # noqa: ANN401 - of TyperGroup
        super().__init__(**settings)
        self.commands = cast("Any", _Commands())

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401, ARG002 - as above
        return list(NAMES)


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
