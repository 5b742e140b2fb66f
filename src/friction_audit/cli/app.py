"""The program and its commands."""

from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit import __version__
from friction_audit.cli import (
    batch_report,
    compare,
    convert,
    diagnose,
    estimate,
    export,
    info,
    plot,
    replay,
    report,
    reproduce,
    simulate,
)
from friction_audit.cli.console import say
from friction_audit.cli.grouped_help import GroupedCommand, with_option_groups

if TYPE_CHECKING:
    from types import ModuleType

# Plain help text: rich would cost more time than everything else that --help does.
app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)

COMMANDS = (info, estimate, plot, replay, diagnose, report, export, batch_report, convert, simulate, reproduce, compare)
"""Modules of the commands, in the order of the help text; each holds ``command``, named as the module, and EXAMPLES."""


def name_of(command: "ModuleType") -> str:
    """Return what a command is called on the command line."""
    return command.__name__.rpartition(".")[2].replace("_", "-")


for module in COMMANDS:
    app.command(name_of(module), cls=GroupedCommand, epilog=f"\b\n{module.EXAMPLES}")(
        with_option_groups(module.command)
    )


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
