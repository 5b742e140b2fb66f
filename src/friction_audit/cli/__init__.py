"""The command line: read, one library call, write."""

import gc
import io
import os
import sys
from contextlib import nullcontext

import typer

from friction_audit.cli.app import app
from friction_audit.errors import FrictionAuditError
from friction_audit.own_process import own_process

__all__ = ["app", "main"]


def main(argv: list[str] | None = None) -> None:
    """Run the command line and exit; deliberate errors become one line and their exit code, bugs a traceback.

    Args:
        argv: The words of a command, from a program that goes on; None if this process is the command.
    """
    for stream in (sys.stdout, sys.stderr):
        # File names need not be text, and terminals need not know every letter: neither is worth a traceback.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # Joints run side by side and their matrices are tall and narrow: threads inside a product only wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        with own_process() if argv is None else nullcontext():
            app(args=argv, prog_name="friction-audit")
    except FrictionAuditError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(error.exit_code)
    finally:
        gc.freeze()  # the process ends: nobody needs to search the libraries' objects for garbage first
