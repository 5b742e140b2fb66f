"""What runs the work of a batch: one interface for the processes of this machine and for a cluster."""

import os
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing.process import BaseProcess
from typing import Any, Protocol, Self, TypeVar

from friction_audit.parallel import processes, team_of

Asked = TypeVar("Asked")
Done = TypeVar("Done")

# Processes share the cores; threads inside a product would only wait for each other.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
PRELOAD = ("friction_audit.batch.work",)  # what every process needs, imported once


@dataclass(frozen=True, slots=True)
class Lost:
    """Work that was not finished, and why."""

    message: str


class Executor(Protocol):
    """Runs work on tasks side by side."""

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task as soon as it is known, in any order.

        Work, tasks and what comes of them can be pickled. Tasks are taken only as workers become free, so that neither
        tasks nor results pile up, and whoever yields them may still change his mind. When the iterator is closed, work
        under way is given up.
        """
        ...


@dataclass(eq=False, kw_only=True, slots=True)
class LocalExecutor:
    """Processes of this machine; in a ``with`` block they are kept from one run to the next.

    A process that dies breaks the pool. What was under way is tried again, one task at a time and at most twice, with
    nothing else running (most often memory was short); a task whose process dies then is lost, and no other.

    Attributes:
        workers: How many of them.
    """

    workers: int = field(default_factory=lambda: len(os.sched_getaffinity(0)))
    _pool: ProcessPoolExecutor | None = field(default=None, init=False)
    _open: ExitStack = field(default_factory=ExitStack, init=False)
    _team: list[BaseProcess] = field(default_factory=list, init=False)
    _broken: bool = field(default=False, init=False)
    _under_way: "dict[Future[Any], Any]" = field(default_factory=dict, init=False)
    _kept: bool = field(default=False, init=False)

    def __enter__(self) -> Self:
        """Keep the processes until the block ends."""
        self._kept = True
        return self

    def __exit__(self, *_: object) -> None:
        """End them."""
        self._kept = False
        self._close()

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order."""
        again: list[Asked] = []
        try:
            for task, outcome in self._run(work, iter(tasks), self.workers):
                if isinstance(outcome, Lost):
                    again.append(task)
                else:
                    yield task, outcome
            for task in again:
                for _ in range(2):  # it may not have been the one that broke the pool
                    self._close()  # what the processes hold is free for this one
                    ((_, outcome),) = self._run(work, iter([task]), 1)
                    if not isinstance(outcome, Lost):
                        break
                yield task, outcome
        finally:
            if self._under_way or not self._kept:
                self._close()

    def _run(
        self, work: Callable[[Asked], Done], waiting: Iterator[Asked], workers: int
    ) -> Generator[tuple[Asked, Done | Lost]]:
        self._employ(work, waiting, workers)
        while self._under_way:
            done = wait(self._under_way, return_when=FIRST_COMPLETED).done
            finished = [(self._under_way.pop(future), future) for future in done]
            outcomes = [(task, self._outcome(future)) for task, future in finished]
            # Before the caller looks at what came of the last task: no worker waits for that.
            self._employ(work, waiting, workers)
            yield from outcomes

    def _employ(self, work: Callable[[Asked], Done], waiting: Iterator[Asked], workers: int) -> None:
        """Give work to idle processes; once all that a broken pool had under way is back, to those of a new one."""
        if self._broken and self._under_way:
            return
        if self._broken:
            self._close()
        for task in islice(waiting, workers - len(self._under_way)):
            if self._pool is None:
                os.environ.update(ONE_THREAD)
                self._pool = self._open.enter_context(processes(self.workers, "forkserver", preload=PRELOAD))
            try:
                future = self._pool.submit(work, task)
            except BrokenProcessPool as error:
                future = Future()
                future.set_exception(error)
            self._under_way[future] = task
            self._team = team_of(self._pool)

    def _outcome(self, future: "Future[Any]") -> Any:  # noqa: ANN401 - what the work returns
        if not isinstance(future.exception(), BrokenProcessPool):
            return future.result()
        self._broken = True
        if self._pool is not None:
            self._pool.shutdown()  # until then its own thread asks for the exit codes
        return Lost(_how_it_ended(next((code for one in self._team if (code := one.exitcode)), 1)))

    def _close(self) -> None:
        self._pool, self._broken = None, False
        self._under_way.clear()
        self._open.close()


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return (
            f"the process that worked on it was ended by {name} twice, the second time while nothing else ran; "
            "expected it to finish; if memory was short, cut the log or use a machine with more"
        )
    return f"the process that worked on it ended with code {code} twice; expected it to finish; report it with the log"
