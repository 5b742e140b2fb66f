"""What runs the work: one interface for the processes of this machine and for a cluster."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Protocol, TypeVar

Asked = TypeVar("Asked")
Done = TypeVar("Done")


@dataclass(frozen=True, slots=True)
class Lost:
    """Work that nobody finished: why, as people are told beside the name of what was asked."""

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
