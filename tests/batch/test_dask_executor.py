"""The same batch on a Dask cluster of this machine."""

import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

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


HERE: dict[str, str | None] = dict.fromkeys(executors.COMPARED, "1.0")


def cluster_of(*workers: dict[str, str | None]) -> Any:
    """Return a client whose workers have some other versions than this process."""
    its = {f"tcp://w{k}": {"packages": HERE | own} for k, own in enumerate(workers)}
    return SimpleNamespace(get_versions=lambda **_: {"client": {"packages": HERE}, "workers": its})


@pytest.mark.parametrize(("workers", "message"), [
    (({}, {"numpy": "0.1"}), r"worker tcp://w1 runs other versions: numpy 0\.1 there, 1\.0 here; .* install"),
    (({"friction_audit": None},), "worker tcp://w0 has no friction_audit; .* install friction-audit"),
    ((), "the cluster has no workers"),
])  # fmt: skip
def test_other_versions_are_refused(workers: tuple[dict[str, str | None], ...], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        executors._check_workers(cluster_of(*workers), "tcp://s")


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "PATIENCE_S", 0.5)
    with pytest.raises(UsageError, match=r"--scheduler tcp://127\.0\.0\.1:9: no scheduler answers"):
        next(DaskExecutor(address="tcp://127.0.0.1:9").run(fragile, iter(())))


@pytest.mark.thorough
def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'friction-audit\[cluster\]'"):
        next(DaskExecutor(address="tcp://h:1").run(fragile, iter(())))
