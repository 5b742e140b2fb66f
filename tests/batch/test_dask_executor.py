"""The same batch on a Dask cluster of this machine."""

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import PackageNotFoundError
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from friction_audit import __version__
from friction_audit.batch import executor as executors
from friction_audit.batch.executor import DaskExecutor, Lost
from friction_audit.batch.identity import Worked
from friction_audit.errors import UsageError
from tests.batch.conftest import Batch
from tests.batch.fragile_work import fragile, tasks

MISSING = pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")
pytestmark = [MISSING, pytest.mark.filterwarnings("ignore"), pytest.mark.xdist_group("dask")]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Return two workers in processes of their own, that find the tests' modules where this process does."""
    root = str(Path(__file__).parents[2])
    sys.path.insert(0, root)
    distributed: Any = import_module("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as running:
        yield running
    sys.path.remove(root)


@pytest.mark.thorough
def test_the_same_numbers_to_the_bit(cluster: Any, rig: Path, batch: Batch) -> None:
    here = batch(rig)
    there = batch(rig, executor=DaskExecutor(address=cluster.scheduler_address), ledger="there")
    assert there.new == 4
    assert repr(there.sessions) == repr(here.sessions)


def test_a_worker_killed_in_the_middle_costs_nothing(cluster: Any, tmp_path: Path) -> None:
    names = ["a", "b", "c", "once", "d", "e", "f", "g", "bug"]
    executor = DaskExecutor(address=cluster.scheduler_address)
    found = {task.path: outcome for task, outcome in executor.run(fragile, tasks(tmp_path, *names))}
    assert set(found) == set(names)
    bug = found.pop("bug")
    assert isinstance(bug, Lost)
    assert "lost on the cluster: ZeroDivisionError: by nought" in bug.message
    assert all(isinstance(outcome, Worked) and outcome.sha256.split()[0] == name for name, outcome in found.items())
    assert (tmp_path / "once").exists()


class Workers:
    """One worker, which has some versions installed; what asks for them is of the standard library."""

    def __init__(self, **installed: str | Exception) -> None:
        self.installed = installed

    def run(self, function: Callable[..., object], name: str = "Python", **_: object) -> dict[str, object]:
        assert function.__module__ in ("importlib.metadata", "sysconfig")  # a worker without this program has them
        return {"tcp://w": self.installed.get(name.replace("-", "_"), function(*[name] if name != "Python" else []))}


@pytest.mark.parametrize(
    ("workers", "message"),
    [
        (Workers(numpy="0.1"), r"worker tcp://w runs other versions: numpy 0\.1 there, .* here; .* install"),
        (Workers(friction_audit="99.0"), r"friction-audit 99\.0 there, .* here; expected .* install friction-audit"),
        (Workers(friction_audit=PackageNotFoundError("x")), "worker tcp://w has no friction-audit; .* install"),
    ],
)
def test_other_versions_are_refused(workers: Workers, message: str) -> None:
    executors._check_workers(Workers(friction_audit=__version__), "tcp://s")
    with pytest.raises(UsageError, match=message):
        executors._check_workers(workers, "tcp://s")


def test_a_cluster_without_workers_is_refused() -> None:
    with pytest.raises(UsageError, match="the cluster has no workers"):
        executors._check_workers(SimpleNamespace(run=lambda *_, **__: {}), "tcp://s")


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "PATIENCE_S", 0.5)
    with pytest.raises(UsageError, match=r"--scheduler tcp://127\.0\.0\.1:9: no scheduler answers"):
        next(DaskExecutor(address="tcp://127.0.0.1:9").run(fragile, iter(())))


@pytest.mark.thorough
def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'friction-audit\[cluster\]'"):
        next(DaskExecutor(address="tcp://h:1").run(fragile, iter(())))
