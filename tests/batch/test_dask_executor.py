"""The same batch on a Dask cluster of this machine."""

import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from friction_audit.batch import dask_executor
from friction_audit.batch.dask_executor import DaskExecutor
from friction_audit.batch.executor import Lost
from friction_audit.batch.find_logs import find_logs
from friction_audit.batch.ledger import Ledger
from friction_audit.batch.recorded import Worked
from friction_audit.batch.run_batch import catch_up, gather
from friction_audit.batch.settings import BatchSettings
from friction_audit.batch.work import Task
from friction_audit.errors import UsageError
from tests.batch.conftest import Batch
from tests.batch.fragile_work import deadly_once

pytest.importorskip("distributed")
pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.xdist_group("dask")]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Return two workers in processes of their own, that find the tests' modules where this process does."""
    root = str(Path(__file__).parents[2])
    sys.path.insert(0, root)
    distributed: Any = import_module("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as running:
        yield running
    sys.path.remove(root)


def test_the_same_numbers_to_the_bit(cluster: Any, rig: Path, batch: Batch, tmp_path: Path) -> None:
    here = batch(rig)
    with Ledger(tmp_path / "there" / "ledger.sqlite") as ledger:
        executor = DaskExecutor(address=cluster.scheduler_address)
        there = gather(
            catch_up(find_logs([str(rig)], {}), BatchSettings(), ledger, executor, lambda _: None),
            BatchSettings(),
            ledger,
        )
    assert there.new == 4
    assert repr(there.sessions) == repr(here.sessions)


def test_a_worker_killed_in_the_middle_costs_nothing(cluster: Any, tmp_path: Path) -> None:
    names = [*map(str, range(8)), "bug"]
    tasks = (Task(path=name, place=str(tmp_path / name)) for name in names)
    executor = DaskExecutor(address=cluster.scheduler_address)
    found = {task.path: outcome for task, outcome in executor.run(deadly_once, tasks)}
    assert set(found) == set(names)
    bug = found.pop("bug")
    assert isinstance(bug, Lost)
    assert "lost on the cluster: ZeroDivisionError: by nought" in bug.message
    assert all(isinstance(outcome, Worked) and outcome.sha256 == name for name, outcome in found.items())
    assert (tmp_path / "3").exists()


def test_other_versions_are_refused() -> None:
    ours = dask_executor.versions()
    real = dask_executor._check_workers

    class Newer:
        def run(self, *_: object, **__: object) -> dict[str, dict[str, str]]:
            return {"tcp://w": ours | {"friction-audit": "99.0"}}

    with pytest.raises(UsageError, match=r"worker tcp://w runs other versions: friction-audit 99\.0 there, .* here"):
        real(Newer(), "tcp://s")

    class Without:
        def run(self, *_: object, **__: object) -> dict[str, Exception]:
            return {"tcp://w": ModuleNotFoundError("No module named 'friction_audit'")}

    with pytest.raises(UsageError, match=r"worker tcp://w cannot run friction-audit .*install friction-audit"):
        real(Without(), "tcp://s")

    class Empty:
        def run(self, *_: object, **__: object) -> dict[str, str]:
            return {}

    with pytest.raises(UsageError, match="the cluster has no workers"):
        real(Empty(), "tcp://s")


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_executor, "PATIENCE_S", 0.5)
    with pytest.raises(UsageError, match=r"--scheduler tcp://127\.0\.0\.1:9: no scheduler answers"):
        next(DaskExecutor(address="tcp://127.0.0.1:9").run(deadly_once, iter(())))


def test_without_the_extra() -> None:
    code = (
        "import sys; sys.modules['distributed'] = None\n"
        "from friction_audit.batch.dask_executor import DaskExecutor\n"
        "next(DaskExecutor(address='tcp://h:1').run(print, iter(())))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "install friction-audit[cluster]" in done.stderr
