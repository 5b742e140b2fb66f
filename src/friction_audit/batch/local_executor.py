"""Executor on this machine: processes, each with a pipe of its own, so that the one that dies is known by its log.

A process that dies takes nothing with it but the log it was working on. That log is tried once more, when nothing runs
beside it (most often memory was short); if that fails too, it is lost.
"""

import os
import signal
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass, field
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from friction_audit.batch.executor import Lost, Outcomes, Work
from friction_audit.batch.recorded import Worked
from friction_audit.batch.work import Task

PATIENCE_S = 5.0
"""For a process that was asked to end."""

_SPAWN = get_context("spawn")
"""A forked copy of a process with threads may stop for ever."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LocalExecutor:
    """Processes of this machine.

    Attributes:
        workers: How many of them.
    """

    workers: int = field(default_factory=lambda: len(os.sched_getaffinity(0)))

    def run(self, work: Work, tasks: Iterable[Task]) -> Outcomes:
        """Yield what came of each task, in any order."""
        again: list[Task] = []
        with closing(_run(work, iter(tasks), self.workers)) as outcomes:
            for task, outcome in outcomes:
                if isinstance(outcome, Lost):
                    again.append(task)
                else:
                    yield task, outcome
        for task in again:
            with closing(_run(work, iter([task]), 1)) as outcomes:
                yield from outcomes


@dataclass(eq=False, slots=True)
class _Worker:
    """A process and what it is working on."""

    process: BaseProcess
    pipe: Connection
    task: Task | None = None

    @classmethod
    def start(cls, work: Work) -> "_Worker":
        ours, theirs = _SPAWN.Pipe()
        process = _SPAWN.Process(target=_labour, args=(theirs, work), daemon=True)
        process.start()
        theirs.close()  # the end of the process is then the end of the pipe
        return cls(process, ours)

    def give(self, task: Task) -> None:
        self.task = task
        try:
            self.pipe.send(task)
        except OSError:
            return  # it has died; the end of its pipe will tell

    def take(self) -> Worked | Lost:
        try:
            outcome: Worked = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            return Lost(_how_it_ended(self.process.exitcode))
        return outcome

    def dismiss(self) -> None:
        """End the process: at once if it is at work, else as soon as it notices that there is none any more."""
        self.pipe.close()
        if self.task is not None:
            self.process.terminate()
        self.process.join(PATIENCE_S)
        self.process.kill()
        self.process.join()
        self.process.close()


def _run(work: Work, tasks: Iterable[Task], workers: int) -> Outcomes:
    waiting = iter(tasks)
    team: list[_Worker] = []
    try:
        _employ(team, work, waiting, workers)
        while busy := {worker.pipe: worker for worker in team if worker.task is not None}:
            for pipe in connection.wait(list(busy)):
                worker = busy[pipe]  # type: ignore[index] # wait returns what it was given
                outcome, task = worker.take(), worker.task
                assert task is not None
                worker.task = None
                if isinstance(outcome, Lost):
                    team.remove(worker)
                    worker.dismiss()
                yield task, outcome
            _employ(team, work, waiting, workers)
    finally:
        for worker in team:
            worker.dismiss()


def _employ(team: list[_Worker], work: Work, waiting: Iterable[Task], workers: int) -> None:
    """Give every idle worker a task, and start workers while there are tasks for them."""
    idle = [worker for worker in team if worker.task is None]
    for _ in range(workers - len(team) + len(idle)):
        task = next(iter(waiting), None)
        if task is None:
            return
        if idle:
            worker = idle.pop()
        else:
            worker = _Worker.start(work)
            team.append(worker)
        worker.give(task)


def _labour(pipe: Connection, work: Work) -> None:
    """Work until there is nothing left to do, or nobody left to do it for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the main process decides
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            return
        outcome = work(task)
        try:
            pipe.send(outcome)
        except OSError:
            return


def _how_it_ended(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return (
            f"the process that worked on it was ended by {name} twice, the second time with nothing beside it; "
            "expected it to finish; if memory was short, cut the log or use a machine with more"
        )
    return f"the process that worked on it ended with code {code} twice; expected it to finish; report it with the log"
