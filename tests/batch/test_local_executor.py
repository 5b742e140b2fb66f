"""Processes: work is spread, dead workers cost their own log alone."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from friction_audit.batch.executor import LocalExecutor, Lost
from friction_audit.batch.identity import Worked
from friction_audit.batch.work import Task

PATIENCE_S = 60.0


def fragile(task: Task) -> Worked:
    """Die on some tasks: always, or when it is the first time."""
    if task.path == "deadly" or (task.path == "once" and not Path(task.place).exists()):
        Path(task.place).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if task.path == "leaves":
        os._exit(3)
    return Worked(sha256=f"{task.path} {os.getpid()} {os.environ.get('OPENBLAS_NUM_THREADS')}")


def slow(task: Task) -> Worked:
    """Say who works, then take very long."""
    Path(task.place).write_text(str(os.getpid()))
    time.sleep(PATIENCE_S)
    return Worked(sha256="late")


def tasks(folder: Path, *names: str) -> Iterator[Task]:
    return (Task(path=name, place=str(folder / name)) for name in names)


def test_dead_workers_cost_their_own_log_alone(tmp_path: Path) -> None:
    names = ("a", "deadly", "b", "once", "c", "leaves", "d")
    found = {task.path: outcome for task, outcome in LocalExecutor(workers=2).run(fragile, tasks(tmp_path, *names))}
    assert set(found) == set(names)
    lost = {name: outcome.message for name, outcome in found.items() if isinstance(outcome, Lost)}
    assert set(lost) == {"deadly", "leaves"}
    assert "was ended by SIGKILL twice" in lost["deadly"]
    assert "ended with code 3 twice" in lost["leaves"]
    done = [outcome.sha256.split() for outcome in found.values() if isinstance(outcome, Worked)]
    assert str(os.getpid()) not in {pid for _, pid, _ in done}


def test_tasks_are_taken_as_workers_become_free(tmp_path: Path) -> None:
    taken: list[str] = []

    def watched() -> Iterator[Task]:
        for task in tasks(tmp_path, *"abcdef"):
            taken.append(task.path)
            yield task

    for done, _ in enumerate(LocalExecutor(workers=1).run(fragile, watched()), start=1):
        assert len(taken) <= done + 1
    assert taken == list("abcdef")


def test_nothing_to_do_starts_nothing() -> None:
    assert list(LocalExecutor(workers=2).run(fragile, iter(()))) == []


def test_processes_are_kept_from_run_to_run_in_a_block(tmp_path: Path) -> None:
    with LocalExecutor(workers=1) as executor:
        found = [outcome for name in "ab" for _, outcome in executor.run(fragile, tasks(tmp_path, name))]
    pids = {outcome.sha256.split()[1] for outcome in found if isinstance(outcome, Worked)}
    assert len(found) == 2
    assert len(pids) == 1
    with pytest.raises(ProcessLookupError):
        os.kill(int(pids.pop()), 0)


def test_giving_up_ends_the_work_under_way(tmp_path: Path) -> None:
    outcomes = LocalExecutor(workers=2).run(_slow_after_one, tasks(tmp_path, "quick", "x"))
    next(outcomes)
    place = tmp_path / "x"
    begin = time.monotonic()
    while not place.exists() or not place.read_text():
        assert time.monotonic() < begin + PATIENCE_S
        time.sleep(0.02)
    outcomes.close()
    assert time.monotonic() < begin + PATIENCE_S
    with pytest.raises(ProcessLookupError):
        os.kill(int(place.read_text()), 0)


def _slow_after_one(task: Task) -> Worked:
    return Worked(sha256="") if task.path == "quick" else slow(task)
