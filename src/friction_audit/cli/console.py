"""What a command says: results to standard output, everything else to standard error."""

import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from rich.console import RenderableType

PATIENCE_S = 1.0
"""Work shorter than this shows no progress."""
DAMAGED = 6
"""Exit code: done, but part of the input was damaged and left out."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Voice:
    """How much a command says on standard error.

    Attributes:
        quiet: No warnings and no progress.
        verbose: Every step and how long it took.
    """

    quiet: bool
    verbose: bool

    def warn(self, messages: Iterable[str]) -> None:
        """Say warnings, one per line."""
        if not self.quiet:
            for message in messages:
                typer.echo(f"warning: {' '.join(message.split())}", err=True)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Show that a step is under way, on a terminal and only if it takes long."""
        begin = time.perf_counter()
        with _spinner(name) if sys.stderr.isatty() and not self.quiet else _silence():
            yield
        if self.verbose:
            typer.echo(f"{name}: {time.perf_counter() - begin:.2f} s", err=True)


def print_rich(parts: "Iterable[RenderableType]") -> None:
    """Print tables no wider than the terminal, plain where there is none; lines of text are never broken."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    for part in parts:
        console.print(part, soft_wrap=isinstance(part, Text))


@contextmanager
def _silence() -> Iterator[None]:
    yield


@contextmanager
def _spinner(name: str) -> Iterator[None]:
    from rich.console import Console

    status = Console(stderr=True).status(f"{name} ...")
    timer = threading.Timer(PATIENCE_S, status.start)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
        status.stop()
