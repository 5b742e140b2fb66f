"""Small simulated logs, and what runs them without processes."""

import shutil
from collections.abc import Callable, Generator, Iterable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from friction_audit.batch.executor import Asked, Done, Executor, Lost
from friction_audit.batch.find_logs import LogFile, find_logs
from friction_audit.batch.ledger import BatchSettings, Ledger
from friction_audit.batch.run_batch import catch_up, gather
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog
from friction_audit.simulation import BenchSettings, JointParameters, simulate

COULOMB_NM = (0.30, 0.32, 0.34, 0.36)
SUFFIXES = (".parquet", ".csv", ".npz", ".parquet")


class Inline:
    """Runs the work here and now, and remembers what it was given."""

    def __init__(self, *, lose: str = "") -> None:
        self.taken: list[str] = []
        self._lose = lose

    def run(self, work: Callable[[Asked], Done], tasks: Iterable[Asked]) -> Generator[tuple[Asked, Done | Lost]]:
        for task in tasks:
            assert isinstance(task, LogFile)
            self.taken.append(Path(task.place).name)
            if self._lose and self._lose in task.place:
                yield task, Lost("gone")
            else:
                yield task, work(task)


@pytest.fixture(scope="session")
def recordings() -> tuple[JointLog, ...]:
    """Return recordings of one joint with known friction, of 15 s each."""
    settings = BenchSettings(duration_s=15.0, rate_hz=200.0)
    return tuple(
        simulate(replace(settings, joints=(JointParameters(coulomb_nm=friction),)), seed=seed).log
        for seed, friction in enumerate(COULOMB_NM)
    )


@pytest.fixture(scope="session")
def written(recordings: tuple[JointLog, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of the recordings in several formats, a day after the other."""
    folder = tmp_path_factory.mktemp("written") / "rig"
    for day, (log, suffix) in enumerate(zip(recordings, SUFFIXES, strict=True), start=1):
        write_log(log, folder / f"2026-03-{day:02d}{suffix}")
    return folder


@pytest.fixture
def rig(written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of that folder, in the folder where the test is."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(written, "rig"))


Batch = Callable[..., Any]


@pytest.fixture
def batch(tmp_path: Path) -> Batch:
    """Return the batch of some names, with the ledger of the test."""

    def run(
        *names: object, executor: Executor | None = None, settings: BatchSettings | None = None, ledger: str = "out"
    ) -> SimpleNamespace:
        with Ledger(tmp_path / ledger / "ledger.sqlite") as opened:
            logs = find_logs([str(name) for name in names], {})
            chosen = settings or BatchSettings()
            standing = catch_up(logs, chosen, opened, executor or Inline(), lambda *_: None)
            sessions, failed, warnings = gather(standing, chosen, opened)
            found = {"sessions": sessions, "failed": failed, "warnings": warnings}
            return SimpleNamespace(new=standing.new, known=standing.known, **found)

    return run
