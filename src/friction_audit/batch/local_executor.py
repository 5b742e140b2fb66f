"""Executor on this machine: processes, each with a pipe of its own, so that the one that dies is known by its log.

A process that dies takes nothing with it but the log it was working on. That log is tried once more, when nothing runs
beside it (most often memory was short); if that fails too, it is lost.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field
from multiprocessing import Pipe, connection
from multiprocessing.connection import Connection
from typing import Any, Self

from friction_audit.batch.executor import Asked, Done, Lost
from friction_audit.batch.local_worker import labour

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Processes share the cores; threads inside a product would only wait for each other."""


@dataclass(eq=False, kw_only=True, slots=True)
class LocalExecutor:
    """Processes of this machine; in a ``with`` block they are kept from one run to the next.

    Attributes:
        workers: How many of them.
    """

    workers: int = field(default_factory=lambda: len(os.sched_getaffinity(0)))
    _team: "list[_Worker]" = field(default_factory=list, init=False)
    _kept: bool = field(default=False, init=False)

    def __enter__(self) -> Self:
        """Keep the processes until the block ends."""
        self._kept = True
        return self

    def __exit__(self, *_: object) -> None:
        """End them."""
        self._kept = False
        _dismiss(self._team)

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order."""
        again: list[Asked] = []
        try:
            for task, outcome in _run(self._team, work, iter(tasks), self.workers):
                if isinstance(outcome, Lost):
                    again.append(task)
                else:
                    yield task, outcome
            for task in again:
                _dismiss(self._team)  # what they hold is free for this one
                yield from _run(self._team, work, iter([task]), 1)
        finally:
            _dismiss(self._team, only_busy=self._kept)


@dataclass(eq=False, slots=True)
class _Worker:
    """A process and whether it is working on something."""

    process: "subprocess.Popen[bytes]"
    pipe: Connection
    busy: bool = False

    @classmethod
    def start(cls) -> "_Worker":
        ours, theirs = Pipe()
        with theirs:  # only the process keeps it: its end is then the end of the pipe, and ours the end of the process
            handle = theirs.fileno()
            code = f"from {labour.__module__} import {labour.__name__}; {labour.__name__}({handle})"
            process = subprocess.Popen(  # noqa: S603 - this program itself
                [sys.executable, "-P", "-c", code],
                pass_fds=[handle],
                env=os.environ | ONE_THREAD,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,  # results are printed by one process alone
                start_new_session=True,  # what Ctrl-C means, the main process decides
            )
        return cls(process, ours)

    def give(self, work: object, task: object) -> None:
        self.busy = True
        try:
            self.pipe.send((work, task))
        except OSError:
            return  # it has died; the end of its pipe will tell

    def take(self) -> Any:  # noqa: ANN401 - whatever its work returns
        try:
            outcome = self.pipe.recv()
        except (EOFError, OSError):
            return Lost(_how_it_ended(self.process.wait()))
        self.busy = False
        return outcome

    def dismiss(self) -> None:
        """End the process at once: it keeps nothing, and would take half a second to take itself apart."""
        self.pipe.close()
        self.process.kill()
        self.process.wait()


def _run(
    team: list[_Worker], work: Callable[[Asked], Done], waiting: Iterator[Asked], workers: int
) -> Generator[tuple[Asked, Done | Lost]]:
    under_way: dict[_Worker, Asked] = {}
    _employ(team, work, waiting, workers, under_way)
    while under_way:
        busy = {worker.pipe: worker for worker in under_way}
        for pipe in connection.wait(list(busy)):
            worker = busy[pipe]  # type: ignore[index] # wait returns what it was given
            outcome, task = worker.take(), under_way.pop(worker)
            if isinstance(outcome, Lost):
                team.remove(worker)
                worker.dismiss()
            # Before anybody looks at what came of the last task: no worker waits for that.
            _employ(team, work, waiting, workers, under_way)
            yield task, outcome


def _employ(
    team: list[_Worker],
    work: Callable[[Asked], Done],
    waiting: Iterator[Asked],
    workers: int,
    under_way: dict[_Worker, Asked],
) -> None:
    """Give every idle worker a task, and start workers while there are tasks for them."""
    while len(under_way) < workers:
        try:
            task = next(waiting)
        except StopIteration:
            return
        worker = next((worker for worker in team if not worker.busy), None)
        if worker is None:
            worker = _Worker.start()
            team.append(worker)
        under_way[worker] = task
        worker.give(work, task)


def _dismiss(team: list[_Worker], *, only_busy: bool = False) -> None:
    """End the processes, or those that are at work, and forget them."""
    leaving = [worker for worker in team if worker.busy or not only_busy]
    team[:] = [worker for worker in team if worker not in leaving]
    for worker in leaving:
        worker.dismiss()


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return (
            f"the process that worked on it was ended by {name} twice, the second time with nothing beside it; "
            "expected it to finish; if memory was short, cut the log or use a machine with more"
        )
    return f"the process that worked on it ended with code {code} twice; expected it to finish; report it with the log"
