"""The work of a batch done by the process of the tests: the same work, without the start of processes."""

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager

import pytest

from friction_audit.batch.executor import Asked, Done, LocalExecutor


def _run(
    executor: LocalExecutor, work: Callable[[Asked], Done], tasks: Iterable[Asked]
) -> Generator[tuple[Asked, Done]]:
    assert executor.workers > 0
    for task in tasks:
        yield task, work(task)


@contextmanager
def in_this_process() -> Iterator[None]:
    """Let batches start no processes; what they are for is tested in ``tests/batch`` and once for the command."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LocalExecutor, "run", _run)
        yield
