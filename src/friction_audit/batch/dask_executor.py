"""Executor on a Dask cluster: the same work, named by paths that the workers see."""

import platform
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from queue import SimpleQueue
from typing import Any

from friction_audit import __version__
from friction_audit.batch.executor import Asked, Done, Lost
from friction_audit.errors import UsageError

DISTRIBUTION = "friction-audit"
PATIENCE_S = 15.0  # for the scheduler's first answer
PER_THREAD = 2  # tasks under way for every thread of the cluster: one is worked on, one is at hand


@dataclass(frozen=True, kw_only=True, slots=True)
class DaskExecutor:
    """A Dask cluster.

    Attributes:
        address: Of its scheduler, ``tcp://host:port``.
    """

    address: str

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        """Yield what came of each task, in any order; the scheduler gives the work of a lost worker to others.

        Raises:
            UsageError: If there is no scheduler or worker, or they run another version.
        """
        client = _connect(self.address)
        pending: dict[Any, Asked] = {}
        try:
            _check_workers(client, self.address)
            yield from _run(client, work, iter(tasks), pending)
        finally:
            client.cancel(list(pending))
            client.close()


def _run(
    client: Any,  # noqa: ANN401 - distributed has no types
    work: Callable[[Asked], Done],
    waiting: Iterator[Asked],
    pending: dict[Any, Asked],
) -> Generator[tuple[Asked, Done | Lost]]:
    done: SimpleQueue[Any] = SimpleQueue()
    while True:
        room = PER_THREAD * max(sum(client.nthreads().values()), 1) - len(pending)
        for task in islice(waiting, max(room, 0)):
            future = client.submit(work, task, pure=False)
            pending[future] = task
            future.add_done_callback(done.put)
        if not pending:
            return
        future = done.get()
        task, error = pending.pop(future), future.exception()
        text = " ".join(str(error).split())
        yield task, future.result() if error is None else Lost(f"lost on the cluster: {type(error).__name__}: {text}")


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
