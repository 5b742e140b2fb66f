"""Arms that others analyse come to the same, and in the same order."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import replace

import pytest

from friction_audit.batch.executor import Asked, Done, LocalExecutor, Lost
from friction_audit.batch.run_batch import drift_of_arms
from friction_audit.drift.analyse import analyse_drift
from friction_audit.drift.session import Session
from friction_audit.drift.settings import DriftSettings
from friction_audit.errors import AnalysisError
from tests.drift.made_sessions import make_sessions, noisy

QUICK = DriftSettings(permutations=199)


class Nobody:
    """Loses whatever it is given."""

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        del work
        yield from ((task, Lost("no memory")) for task in tasks)


def sessions_of(*robots: str) -> list[Session]:
    levels = (noisy(8, seed) for seed in range(len(robots)))
    made = ((make_sessions(level), robot) for level, robot in zip(levels, robots, strict=True))
    return [replace(session, robot=robot) for sessions, robot in made for session in sessions]


def test_processes_find_what_is_found_here() -> None:
    sessions = sessions_of("right", "left", "middle")
    found = drift_of_arms(sessions, QUICK, LocalExecutor(workers=2))
    assert [arm.robot for arm in found.arms] == ["left", "middle", "right"]
    assert repr(found) == repr(analyse_drift(sessions, QUICK))


def test_a_single_arm_is_analysed_here() -> None:
    sessions = sessions_of("only")
    assert repr(drift_of_arms(sessions, QUICK, Nobody())) == repr(analyse_drift(sessions, QUICK))


def test_an_arm_that_nobody_finishes_is_named() -> None:
    with pytest.raises(AnalysisError, match=r"^left: its drift cannot be analysed: no memory$"):
        drift_of_arms(sessions_of("right", "left"), QUICK, Nobody())
