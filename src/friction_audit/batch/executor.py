"""What runs the work: one interface for the processes of this machine and for a cluster."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from friction_audit.batch.recorded import Worked
from friction_audit.batch.work import Task


@dataclass(frozen=True, slots=True)
class Lost:
    """Work that nobody finished: why, as people are told beside the name of the log."""

    message: str


Work = Callable[[Task], Worked]
Outcomes = Generator[tuple[Task, Worked | Lost]]


class Executor(Protocol):
    """Runs work on tasks side by side."""

    def run(self, work: Work, tasks: Iterable[Task]) -> Outcomes:
        """Yield what came of each task as soon as it is known, in any order.

        Tasks are taken only as workers become free, so that neither tasks nor results pile up, and whoever yields
        them may still change his mind. When the iterator is closed, work under way is given up.
        """
        ...
