"""Executor on this machine: processes, each with a pipe of its own, so that the one that dies is known by its log.

A process that dies takes nothing with it but the log it was working on. That log is tried once more, when nothing runs
beside it (most often memory was short); if that fails too, it is lost.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass, field
from multiprocessing import Pipe, connection
from multiprocessing.connection import Connection

from friction_audit.batch.executor import Lost, Outcomes, Work
from friction_audit.batch.local_worker import labour
from friction_audit.batch.recorded import Worked
from friction_audit.batch.work import Task

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Processes share the cores; threads inside a product would only wait for each other."""
PATIENCE_S = 5.0
"""For a process that was asked to end."""


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

    process: "subprocess.Popen[bytes]"
    pipe: Connection
    task: Task | None = None

    @classmethod
    def start(cls, work: Work) -> "_Worker":
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
        worker = cls(process, ours)
        worker._send(work)
        return worker

    def give(self, task: Task) -> None:
        self.task = task
        self._send(task)

    def take(self) -> Worked | Lost:
        try:
            outcome: Worked = self.pipe.recv()
        except (EOFError, OSError):
            return Lost(_how_it_ended(self.process.wait()))
        return outcome

    def dismiss(self) -> None:
        """End the process: at once if it is at work, else as soon as it notices that there is none any more."""
        self.pipe.close()
        if self.task is not None:
            self.process.kill()
        try:
            self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def _send(self, what: object) -> None:
        try:
            self.pipe.send(what)
        except OSError:
            return  # it has died; the end of its pipe will tell


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


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return (
            f"the process that worked on it was ended by {name} twice, the second time with nothing beside it; "
            "expected it to finish; if memory was short, cut the log or use a machine with more"
        )
    return f"the process that worked on it ended with code {code} twice; expected it to finish; report it with the log"
