"""What runs the work of a batch: the processes of this machine, or a Dask cluster that sees the same paths."""

import os
import platform
import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures import Executor as Pool
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from multiprocessing.process import BaseProcess
from typing import Any, Protocol, Self, TypeVar

from friction_audit import __version__
from friction_audit.errors import UsageError
from friction_audit.parallel import processes, team_of

Asked = TypeVar("Asked")
Done = TypeVar("Done")

# Processes share the cores; threads inside a product would only wait for each other.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
PRELOAD = ("friction_audit.batch.work",)  # what every process needs, imported once

DISTRIBUTION = "friction-audit"
PATIENCE_S = 15.0  # for the scheduler's first answer
PER_THREAD = 2  # tasks under way for every thread of the cluster: one is worked on, one is at hand


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
    """

    workers: int = field(default_factory=lambda: len(os.sched_getaffinity(0)))  # how many of them
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


@dataclass(frozen=True, kw_only=True, slots=True)
class DaskExecutor:
    """A Dask cluster."""

    address: str  # of its scheduler, ``tcp://host:port``

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order; the scheduler gives the work of a lost worker to others."""
        client = _connect(self.address)
        pool: Pool = client.get_executor(pure=False)
        waiting, pending = iter(tasks), dict[Future[Done], Asked]()
        try:
            _check_workers(client, self.address)
            while True:
                room = PER_THREAD * max(sum(client.nthreads().values()), 1) - len(pending)
                pending |= {pool.submit(work, task): task for task in islice(waiting, max(room, 0))}
                if not pending:
                    return
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    task, error = pending.pop(future), future.exception()
                    said = f"{type(error).__name__}: {' '.join(str(error).split())}"
                    yield task, future.result() if error is None else Lost(f"lost on the cluster: {said}")
        finally:
            pool.shutdown(wait=False)  # gives up what is under way
            client.close()


def _connect(address: str) -> Any:  # noqa: ANN401
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise UsageError(
            f"--scheduler {address}: needs dask.distributed, which is not installed; run: "
            "pip install 'friction-audit[cluster]'"
        ) from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # versions are compared below, those that matter
            return distributed.Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise UsageError(
            f"--scheduler {address}: no scheduler answers ({said}); expected an address such as tcp://host:8786; check "
            "that it runs and can be reached"
        ) from error


def versions() -> dict[str, str]:
    """Return the versions that have to be the same on all machines for the numbers to be the same."""
    import numpy as np
    import scipy

    return {
        "friction-audit": __version__,
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }


def _check_installed(client: Any, address: str) -> None:  # noqa: ANN401
    """Ask for the version with a function that any worker has: one that it lacks would never be answered."""
    found = client.run(version, DISTRIBUTION, on_error="return")
    if not found:
        raise UsageError(f"--scheduler {address}: the cluster has no workers; expected at least one; start one there")
    for worker, there in found.items():
        if there != __version__:
            said = "has no friction-audit" if isinstance(there, Exception) else f"has friction-audit {there}"
            raise UsageError(
                f"--scheduler {address}: worker {worker} {said}; expected {__version__}, as here, so that the numbers "
                f"are the same; install friction-audit {__version__} there"
            )


def _check_workers(client: Any, address: str) -> None:  # noqa: ANN401
    _check_installed(client, address)
    ours = versions()
    theirs = client.run(versions, on_error="return")
    for worker, found in theirs.items():
        if isinstance(found, Exception):
            raise UsageError(
                f"--scheduler {address}: worker {worker} cannot run friction-audit ({type(found).__name__}: {found}); "
                f"install friction-audit {__version__} there"
            )
        unlike = [f"{name} {found.get(name)} there, {own} here" for name, own in ours.items() if found.get(name) != own]
        if unlike:
            raise UsageError(
                f"--scheduler {address}: worker {worker} runs other versions: {', '.join(unlike)}; expected the same, "
                "so that the numbers are; install the same on all machines"
            )
