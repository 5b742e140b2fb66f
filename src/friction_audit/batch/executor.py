"""What runs the work of a batch: the processes of this machine, or a Dask cluster that sees the same paths."""

import os
import signal
import warnings
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor as Pool, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from itertools import islice
from typing import Any, NamedTuple, Protocol, TypeVar

from friction_audit import __version__
from friction_audit.errors import UsageError
from friction_audit.parallel import processes, team_of

Asked = TypeVar("Asked")
Done = TypeVar("Done")

# Processes share the cores; threads inside a product would only wait for each other.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
PRELOAD = ("friction_audit.batch.work",)  # what every process needs, imported once
PATIENCE_S = 15.0  # for the scheduler's first answer
COMPARED = ("python", "friction_audit", "numpy", "scipy")  # versions of a worker and of this process
PER_THREAD = 2  # tasks under way for every thread of the cluster: one is worked on, one is at hand


class Lost(NamedTuple):
    """Work that was not finished, and why."""

    message: str


class Executor(Protocol):
    """Runs work on tasks side by side; work, tasks and what comes of them can be pickled."""

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order; take tasks as workers become free; when closed, give up."""
        ...


def feed(
    submit: "Callable[[Asked], Future[Done]]", room: Callable[[], int], tasks: Iterable[Asked]
) -> "Generator[tuple[Asked, Future[Done]]]":
    """Yield each task with its future when that is done; there is room for so many tasks at a time."""
    waiting, pending, done = iter(tasks), dict["Future[Done]", Asked](), list[tuple[Asked, "Future[Done]"]]()
    while True:  # tasks are given out before the caller looks at what came of the last one: no worker waits for that
        pending.update((submit(task), task) for task in islice(waiting, max(room() - len(pending), 0)))
        yield from done
        if not pending:
            return
        done = [(pending.pop(future), future) for future in wait(pending, return_when=FIRST_COMPLETED).done]


@dataclass(eq=False, kw_only=True, slots=True)
class LocalExecutor(AbstractContextManager["LocalExecutor"]):
    """Processes of this machine, kept from one run to the next until the ``with`` block ends.

    A process that dies breaks the pool. What was under way is tried again, one task at a time and at most twice, with
    nothing else running (most often memory was short); a task whose process dies then is lost, and no other.
    """

    workers: int = field(default_factory=lambda: len(os.sched_getaffinity(0)))  # how many of them
    _pool: ProcessPoolExecutor | None = field(default=None, init=False)
    _open: ExitStack = field(default_factory=ExitStack, init=False)

    def __exit__(self, *_: object) -> None:
        self._close()

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order."""
        again, submit = list[Asked](), partial(self._submit, work)
        try:
            for task, future in feed(submit, lambda: self.workers, tasks):
                if isinstance(future.exception(), BrokenProcessPool):
                    again.append(task)
                else:
                    yield task, future.result()
            for task in again:
                for _ in range(2):  # it may not have been the one that broke the pool
                    self._close()  # what the processes hold is free for this one
                    future = submit(task)
                    if not isinstance(future.exception(), BrokenProcessPool):
                        yield task, future.result()
                        break
                else:
                    yield task, self._loss()
        except BaseException:  # also where the iterator is closed before its end
            self._close()
            raise

    def _submit(self, work: Callable[[Asked], Done], task: Asked) -> "Future[Done]":
        """Give work to the processes, or to new ones where those are broken."""
        if self._pool is not None:
            try:
                return self._pool.submit(work, task)
            except BrokenProcessPool:
                self._close()
        os.environ.update(ONE_THREAD)
        self._pool = self._open.enter_context(processes(self.workers, "forkserver", preload=PRELOAD))
        return self._pool.submit(work, task)

    def _loss(self) -> Lost:
        """Say how the process ended that worked on a task."""
        assert self._pool is not None
        team = team_of(self._pool)
        self._pool.shutdown()  # until then its own thread asks for the exit codes
        code = next((code for one in team if (code := one.exitcode)), 1)
        how, more = f"ended with code {code} twice", "report it with the log"
        if code < 0:
            name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
            how = f"was ended by {name} twice, the second time while nothing else ran"
            more = "if memory was short, cut the log or use a machine with more"
        return Lost(f"the process that worked on it {how}; expected it to finish; {more}")

    def _close(self) -> None:
        self._pool = None
        self._open.close()


@dataclass(frozen=True, kw_only=True, slots=True)
class DaskExecutor:
    """A Dask cluster."""

    address: str  # of its scheduler, ``tcp://host:port``

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order; the scheduler gives the work of a lost worker to others."""
        client = _connect(self.address)
        pool: Pool = client.get_executor(pure=False)
        try:
            _check_workers(client, self.address)
            threads = client.nthreads
            for task, future in feed(
                lambda task: pool.submit(work, task), lambda: PER_THREAD * max(sum(threads().values()), 1), tasks
            ):
                error = future.exception()
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


def _check_workers(client: Any, address: str) -> None:  # noqa: ANN401
    """Compare what makes the numbers: work for a worker that lacks the program would never be answered."""
    found = client.get_versions(packages=COMPARED[1:])  # that of Python comes in any case
    if not found["workers"]:
        raise UsageError(f"--scheduler {address}: the cluster has no workers; expected at least one; start one there")
    ours = found["client"]["packages"]
    for worker, theirs in ((worker, its["packages"]) for worker, its in found["workers"].items()):
        lacking = [name for name in COMPARED if theirs[name] is None]
        unlike = [f"{name} {theirs[name]} there, {ours[name]} here" for name in COMPARED if theirs[name] != ours[name]]
        if unlike:
            said = f"has no {', '.join(lacking)}" if lacking else f"runs other versions: {', '.join(unlike)}"
            raise UsageError(
                f"--scheduler {address}: worker {worker} {said}; expected the same as here, so that the numbers are; "
                f"install friction-audit {__version__} with the same libraries on all machines"
            )
