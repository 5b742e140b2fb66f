"""The command line: read, one library call, write."""

import errno
import gc
import io
import os
import sys
import warnings
from contextlib import nullcontext
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from friction_audit import __version__
from friction_audit.cli.console import discard, open_streams, remark, say
from friction_audit.cli.parameters import GroupedCommand, LateParams, with_option_groups
from friction_audit.errors import AnalysisError, FrictionAuditError, InputError, UsageError, shortened
from friction_audit.parallel import BLAS_THREADS, own_process

NAMES = (  # of the commands, in the order of the help text
    *("info", "estimate", "plot", "replay", "diagnose", "report", "plan", "export", "diff"),
    *("batch-report", "convert", "simulate", "reproduce", "compare"),
)
# Errors of the system that say that a place cannot be written to; all others are bugs if they come as far as here.
NO_PLACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.ENAMETOOLONG)
LONGEST_COMMAND = 200  # characters of a command that a message repeats


@cache
def command_of(name: str) -> Any:  # noqa: ANN401 - types of Typer's private copy of click
    """Return a command, loaded when it is asked for: ``command`` of its module, with its EXAMPLES."""
    module = import_module(f"friction_audit.cli.{name.replace('-', '_')}")
    alone = typer.Typer(rich_markup_mode=None, add_completion=False)
    alone.command(name, cls=GroupedCommand, epilog=f"\b\n{module.EXAMPLES}")(with_option_groups(module.command))
    return typer.main.get_command(alone)


class _Group(LateParams, TyperGroup):
    def __init__(self, **settings: Any) -> None:  # noqa: ANN401 - of TyperGroup
        super().__init__(**settings)
        self.commands: Any = dict.fromkeys(NAMES)  # a misspelt one is compared with these names

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


def main(argv: list[str] | None = None) -> None:
    """Run the command line and exit; deliberate errors become one line and their exit code, bugs a traceback.

    ``argv``: words of a command, from a program that goes on; None if this process is the command.
    """
    open_streams()
    for stream in (sys.stdout, sys.stderr):
        # File names need not be text, and terminals need not know every letter: neither is worth a traceback.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # Joints run side by side and their matrices are tall and narrow: threads inside a product only wait for each other.
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1") | os.environ)
    if argv is None and not sys.warnoptions:
        # Warnings of libraries are for developers, who ask for them with -W or PYTHONWARNINGS.
        warnings.simplefilter("ignore")
        os.environ["PYTHONWARNINGS"] = "ignore"  # for the processes of a batch
    try:
        with own_process() if argv is None else nullcontext():
            app(args=argv, prog_name="friction-audit")
    except (FrictionAuditError, MemoryError, RecursionError, OverflowError, OSError) as error:
        reason = _in_words(error, " ".join(sys.argv[1:] if argv is None else argv))
        if reason is None:
            raise
        lines = [f"error: {reason}"]
        if isinstance(reason, AnalysisError) and reason.of_joints:
            from friction_audit.reporting.notices import reason_lines

            lines += reason_lines(SimpleNamespace(joint=joint, reason=why) for joint, why in reason.of_joints)
        remark("\n  ".join(lines))
        sys.exit(reason.exit_code)
    finally:
        gc.freeze()  # the process ends: a search of the libraries' objects for garbage is of no use


def _in_words(error: Exception, command: str) -> FrictionAuditError | None:
    """Return what an error means for the command, also one of the machine; None if it is a bug."""
    where = shortened(command, LONGEST_COMMAND)
    match error:
        case FrictionAuditError():
            return error
        case MemoryError():
            advice = "look at a part of the log with --t-start and --t-end, or --joints, or use a machine with more"
            return InputError(f"{where}: not enough memory{f' ({error})' if str(error) else ''}; {advice}")
        case RecursionError():
            return InputError(f"{where}: something in the input is nested too deeply; write it again with less nesting")
        case OverflowError():
            return InputError(f"{where}: a number in the input is too large ({error}); correct it or leave its row out")
        case OSError(errno=number) if number in NO_PLACE:
            if error.filename is None:
                discard(sys.stdout)  # it may be what is full
            place = error.filename or f"{where}: standard output or the temporary folder"
            return UsageError(f"{place}: cannot be written: {error.strerror}; make room there or choose another place")
    return None
