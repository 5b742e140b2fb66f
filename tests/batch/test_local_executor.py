"""Processes: work is spread, dead workers cost their own log alone; arms that others analyse come to the same."""

import os
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from friction_audit.batch.executor import LocalExecutor, Lost
from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import Worked
from friction_audit.batch.run_batch import drift_of_arms
from friction_audit.drift.analyse import analyse_arm
from friction_audit.drift.report import DriftSettings
from friction_audit.drift.session import Session
from friction_audit.errors import AnalysisError
from tests.batch.fragile_work import fragile, tasks
from tests.drift.made_sessions import make_sessions, noisy

PATIENCE_S = 60.0


def slow_after_one(task: LogFile) -> Worked:
    """Say who works, then take very long, but for one task."""
    if task.path != "quick":
        Path(task.place).write_text(str(os.getpid()))
        time.sleep(PATIENCE_S)
    return Worked(sha256="")


def test_dead_workers_cost_their_own_log_alone(tmp_path: Path) -> None:
    names = ("a", "deadly", "b", "once", "c", "leaves", "d")
    with LocalExecutor(workers=2) as executor:
        found = {task.path: outcome for task, outcome in executor.run(fragile, tasks(tmp_path, *names))}
    assert set(found) == set(names)
    lost = {name: outcome.message for name, outcome in found.items() if isinstance(outcome, Lost)}
    assert set(lost) == {"deadly", "leaves"}
    assert "was ended by SIGKILL twice" in lost["deadly"]
    assert "ended with code 3 twice" in lost["leaves"]
    done = [outcome.sha256.split() for outcome in found.values() if isinstance(outcome, Worked)]
    assert str(os.getpid()) not in {pid for _, pid in done}


def test_tasks_are_taken_as_workers_become_free(tmp_path: Path) -> None:
    taken: list[str] = []

    def watched() -> Iterator[LogFile]:
        for task in tasks(tmp_path, *"abcdef"):
            taken.append(task.path)
            yield task

    with LocalExecutor(workers=1) as executor:
        for done, _ in enumerate(executor.run(fragile, watched()), start=1):
            assert len(taken) <= done + 1
    assert taken == list("abcdef")


def test_processes_are_kept_from_run_to_run_in_a_block(tmp_path: Path) -> None:
    with LocalExecutor(workers=1) as executor:
        found = [outcome for name in "ab" for _, outcome in executor.run(fragile, tasks(tmp_path, name))]
    pids = {outcome.sha256.split()[1] for outcome in found if isinstance(outcome, Worked)}
    assert len(found) == 2
    assert len(pids) == 1
    with pytest.raises(ProcessLookupError):
        os.kill(int(pids.pop()), 0)


def test_giving_up_ends_the_work_under_way(tmp_path: Path) -> None:
    outcomes = LocalExecutor(workers=2).run(slow_after_one, tasks(tmp_path, "quick", "x"))
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


QUICK = DriftSettings(permutations=199)


def sessions_of(*robots: str) -> list[Session]:
    levels = (noisy(8, seed) for seed in range(len(robots)))
    made = ((make_sessions(level), robot) for level, robot in zip(levels, robots, strict=True))
    return [replace(session, robot=robot) for sessions, robot in made for session in sessions]


def test_processes_find_what_is_found_here() -> None:
    sessions = sessions_of("right", "left", "middle")
    with LocalExecutor(workers=2) as executor:
        found = drift_of_arms(sessions, QUICK, executor)
    assert [arm.robot for arm in found] == ["left", "middle", "right"]
    assert repr(found[2]) == repr(analyse_arm(sessions[:8], QUICK))


def test_an_unfinished_arm_is_named() -> None:
    losing: Any = SimpleNamespace(run=lambda _, tasks: ((task, Lost("no memory")) for task in tasks))
    with pytest.raises(AnalysisError, match=r"^left: its drift cannot be analysed: no memory$"):
        drift_of_arms(sessions_of("right", "left"), QUICK, losing)
