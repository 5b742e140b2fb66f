"""``batch-report`` from words to files and exit codes."""

import json
import shutil
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_audit.batch.executor import LocalExecutor
from friction_audit.batch.ledger import SCHEMA_VERSION
from friction_audit.cli.batch_report import RESULTS
from friction_audit.io.writers.write_log import write_log
from friction_audit.reporting.figures.registry import figures_of
from friction_audit.simulation import BenchSettings, simulate
from tests.cli.conftest import Run
from tests.in_this_process import in_this_process

DAYS, STEP = 8, 5


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of days of one joint, its friction 30 % higher from the sixth on."""
    folder = tmp_path_factory.mktemp("days") / "rig"
    settings = BenchSettings(duration_s=20.0, rate_hz=200.0)
    for day in range(DAYS):
        log = simulate(settings, seed=day).log
        assert log.tau_interaction is not None
        torque = np.asfortranarray(log.tau_interaction * (1.3 if day >= STEP else 1.0))
        write_log(replace(log, tau_interaction=torque), folder / f"2026-03-{day + 1:02d}.npz")
    return folder


@pytest.fixture
def rig(written: Path, run: Run, tmp_path: Path) -> Path:
    """Return a copy of it where the command runs."""
    assert run("--version").code == 0
    shutil.copytree(written, tmp_path / "rig")
    return Path("rig")


@pytest.fixture
def here(sketched: None) -> Iterator[None]:  # noqa: ARG001 - it takes effect by being there
    """Start no processes for the logs and the figures, and paint no figure: they take longest."""
    with in_this_process():
        yield


def test_from_logs_to_every_output(rig: Path, run: Run) -> None:
    (rig / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    answer = run("batch-report", rig, "--json", "-q", "--workers", "1")
    assert answer.code == 6
    document = answer.document()
    assert (document["computed"], document["known"]) == (DAYS + 1, 0)
    assert [failed["path"] for failed in document["failed"]] == ["rig/bad.csv"]
    assert document["joints"][0]["drift"] is True
    assert document["joints"][0]["coefficients"]["coulomb_nm"]["change_points"][0]["session"] == STEP + 1
    folder = Path("friction-drift")
    figures = {f"{kind.name}.png" for kind in figures_of("drift")}
    assert {path.name for path in folder.iterdir()} == {"ledger.sqlite", *RESULTS, *figures}
    assert json.loads((folder / "batch.json").read_text()) == document
    table = pd.read_parquet(folder / "sessions.parquet")
    assert len(table) == 2 * DAYS
    assert table["value"].to_numpy() == pytest.approx(pd.read_csv(folder / "sessions.csv")["value"].to_numpy())
    first = {path.name: path.stat().st_mtime_ns for path in folder.iterdir() if path.name in (*RESULTS, *figures)}
    again = run("batch-report", rig, "-q")
    assert again.code == 6
    assert f"{DAYS} sessions of 1 arm: 0 computed, {DAYS + 1} known from the ledger, 1 of these failed" in again.out
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir() if path.name in first} == first
    assert run("batch-report", rig, "--json", "-q").document()["known"] == DAYS + 1


@pytest.mark.usefixtures("here")
def test_limits_come_before_failures(rig: Path, run: Run) -> None:
    (rig / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    answer = run("batch-report", rig, "--fail-on", "coulomb=15%", "-q")
    assert (answer.code, "limit exceeded:" in answer.out) == (5, True), answer
    assert "failed: rig/bad.csv: no column for a torque" in answer.out
    assert run("batch-report", rig, "--fail-on", "coulomb=60%", "-q").code == 6


@pytest.mark.usefixtures("here")
def test_results_of_other_settings_are_not_replaced_unasked(rig: Path, run: Run) -> None:
    assert run("batch-report", rig, "-q").code == 0
    before = Path("friction-drift/batch.json").read_bytes()
    answer = run("batch-report", rig, "-q", "--model", "coulomb")
    assert (answer.code, "friction-drift/batch.json" in answer.err) == (2, True), answer
    assert "made with other settings" in answer.err
    assert Path("friction-drift/batch.json").read_bytes() == before
    assert run("batch-report", rig, "-q", "--model", "coulomb", "--overwrite").code == 0
    assert Path("friction-drift/batch.json").read_bytes() != before
    (rig / "2026-03-08.npz").unlink()
    other = run("batch-report", rig, "-q", "--overwrite")
    assert "7 sessions of 1 arm: 0 computed, 7 known" in other.out


@pytest.mark.usefixtures("here")
def test_rebuild_keeps_the_old_ledger(rig: Path, run: Run) -> None:
    assert run("batch-report", rig / "2026-03-01.npz", "-q").code == 0
    answer = run("batch-report", rig / "2026-03-01.npz", "--rebuild")
    assert (answer.code, "1 computed, 0 known" in answer.out) == (0, True), answer
    assert "warning: the ledger that was there is kept as friction-drift/ledger-1.sqlite" in answer.err
    with closing(sqlite3.connect("friction-drift/ledger.sqlite")) as database:
        database.execute(f"PRAGMA user_version = {SCHEMA_VERSION - 1}")
    older = run("batch-report", rig / "2026-03-01.npz")
    assert (older.code, "kept as friction-drift/ledger-2.sqlite" in older.err) == (0, True), older
    Path("friction-drift/ledger.sqlite").write_text("no ledger at all, but some text")
    broken = run("batch-report", rig / "2026-03-01.npz")
    assert (broken.code, "--rebuild to move it aside" in broken.err) == (3, True), broken
    assert run("batch-report", rig / "2026-03-01.npz", "--rebuild", "-q").code == 0


def test_stopped_by_the_user_it_says_how_far_it_came(rig: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(_: LocalExecutor, work: Callable[[object], object], tasks: Iterable[object]) -> Iterator[object]:
        for number, task in enumerate(tasks):
            if number == 2:
                raise KeyboardInterrupt
            yield task, work(task)

    monkeypatch.setattr(LocalExecutor, "run", stopped)
    answer = run("batch-report", rig, "-o", "out")
    assert (answer.code, answer.out) == (130, "")
    assert f"stopped: 2 of {DAYS} new logs are finished; out/ledger.sqlite keeps them" in answer.err
