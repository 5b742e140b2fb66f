"""What a command says: results to standard output, everything else to standard error; no control characters."""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any, NamedTuple, TextIO

import typer

from friction_audit.errors import UsageError, printable

Report = Callable[..., None]  # takes the share of the work that is done, 0 to 1, and, if there is more to say, a note

PATIENCE_S = 1.0  # work shorter than this shows no progress
EXCEEDED = 5  # exit code: done, but beyond a limit that the user set
UNTESTABLE = 7  # exit code: the sessions cannot test a limit that the user set
DAMAGED = 6  # exit code: done, but part of the input was damaged and left out
UNHEARD = 141  # exit code: the reader of standard output went away, as shells have it for SIGPIPE


def say(text: str, *, nl: bool = True) -> None:
    """Print a result."""
    try:
        typer.echo(printable(text), nl=nl)
    except BrokenPipeError as error:
        discard(sys.stdout)
        raise typer.Exit(UNHEARD) from error
    except OSError as error:
        discard(sys.stdout)
        raise UsageError(f"standard output: cannot be written: {error.strerror}; write it to another place") from error


def say_table(rows: Sequence[tuple[str, ...]], margin: str = "") -> None:
    """Print rows of words, each column as wide as its longest one."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for *cells, last in rows:
        say(margin + "".join(f"{cell:<{width}}  " for cell, width in zip(cells, widths, strict=False)) + last)


def remark(text: str) -> None:
    """Print what is no result to standard error; where that is full or gone, the result counts all the same."""
    try:
        typer.echo(printable(text), err=True)
    except OSError:
        discard(sys.stderr)


def discard(stream: TextIO) -> None:
    """Let a stream that cannot be written to lead nowhere: Python would try once more at the end and complain."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def open_streams() -> None:
    """Open standard streams that are closed, so that no file takes their place."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, mode)  # noqa: PTH123, SIM115 - a device, open to the end
            os.set_inheritable(stream.fileno(), True)  # noqa: FBT003 - takes no keyword
            setattr(sys, name, stream)


class Voice(NamedTuple):
    """How much a command says on standard error."""

    quiet: bool  # no warnings and no progress
    verbose: bool  # every step and how long it took
    json: bool = False  # a document is printed, which holds the warnings of the result
    course: "Course | None" = None  # the bar that steps move on, shown once the work takes long; None: each alone

    def warn(self, messages: Iterable[str], total: str = "", *, held: bool = False) -> None:
        """Say warnings, one per line, under a line with their total if there is one; ``held``: of the result."""
        if not (self.quiet or (held and self.json)):
            for message in (total, *messages):
                if message:
                    remark(f"{'  ' if total and message != total else 'warning: '}{' '.join(message.split())}")

    @contextmanager
    def step(self, name: str) -> Iterator[Report | None]:
        """Show that a step is under way, on a terminal and only if it takes long; yield what takes the share done."""
        begin = time.perf_counter()
        with (
            nullcontext(self) if self.course else self.stages(1) as voice,
            voice.course.stage(name) if voice.course else nullcontext() as report,
        ):
            yield report
        if self.verbose:
            remark(f"{name}: {time.perf_counter() - begin:.2f} s")

    @contextmanager
    def stages(self, lengths: int | Sequence[float]) -> "Iterator[Voice]":
        """Show one bar over several steps; yield the voice whose steps move it on, each named while it is under way.

        ``lengths``: how many steps, or how long each takes compared with the others, from which the time left follows.
        """
        if self.quiet or not sys.stderr.isatty():
            yield self
            return
        course = Course([1.0] * lengths if isinstance(lengths, int) else lengths)
        timer = threading.Timer(PATIENCE_S, course.show)
        timer.daemon = True
        timer.start()
        try:
            yield self._replace(course=course)
        finally:
            timer.cancel()
            timer.join()
            if course.bar is not None:
                course.bar.stop()


class Course:
    """Stages on the way to a result, on one bar; rich is loaded when the bar is shown."""

    def __init__(self, lengths: Sequence[float]) -> None:
        self.bar: Any = None  # of rich
        self._lengths, self._done, self._begin = iter(lengths), 0.0, time.monotonic()
        self._state: dict[str, Any] = {"description": "", "total": sum(lengths)}

    def show(self) -> None:
        """Show, from another thread, a bar with the time so far and the time left, that vanishes at the end."""
        from rich import progress
        from rich.console import Console

        times = (progress.TaskProgressColumn, progress.TimeElapsedColumn, progress.TimeRemainingColumn)
        name = progress.TextColumn("{task.description}", markup=False)
        made = (progress.SpinnerColumn(), name, progress.BarColumn(), *(column() for column in times))
        bar = progress.Progress(*made, console=Console(stderr=True), transient=True)
        bar.add_task("")
        bar.tasks[0].start_time = self._begin
        self.bar = bar
        self._move()
        bar.start()

    def _move(self, **state: Any) -> None:  # noqa: ANN401 - of a task
        self._state |= state
        if self.bar is not None:
            self.bar.update(self.bar.task_ids[0], **self._state)

    @contextmanager
    def stage(self, name: str) -> Iterator[Report]:
        """Name the stage that is under way; yield what takes the share of it that is done."""
        begin, length = self._done, next(self._lengths, 0.0)
        name = f"{printable(name)} ..."
        self._move(completed=begin, description=name)
        yield lambda share, note="": self._move(completed=begin + share * length, description=f"{name} {note}")
        self._done += length
        self._move(completed=self._done)
