"""``batch-report`` from words to files and exit codes, also where files, names or the ledger are broken."""

import json
import os
import shutil
import socket
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.batch.executor import LocalExecutor
from friction_audit.batch.ledger import SCHEMA_VERSION
from friction_audit.cli.batch_report import RESULTS
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import read_log
from friction_audit.io.writers.write_log import write_log
from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.html.batch_page import OF_A_TEST
from friction_audit.simulation import BenchSettings, simulate
from tests.in_this_process import Run

DAYS, STEP, FEW = 8, 5, 4
LEDGER = Path("friction-drift/ledger.sqlite")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with folders of days of one joint, its friction 30 % higher from the sixth on."""
    folder = tmp_path_factory.mktemp("days")
    for rig, days, seconds, prefix in (("rig", DAYS, 20.0, ""), ("few", FEW, 15.0, "rig-")):
        for day in range(days):
            log: Any = simulate(BenchSettings(duration_s=seconds, rate_hz=200.0), seed=day).log
            torque = np.asfortranarray(log.tau_interaction * (1.3 if day >= STEP else 1.0))
            write_log(replace(log, tau_interaction=torque), folder / rig / f"{prefix}2026-03-{day + 1:02d}.npz")
    return folder


@pytest.fixture
def rig(written: Path, run: Run, tmp_path: Path) -> Path:  # noqa: ARG001 - the command runs in its folder
    shutil.copytree(written / "rig", tmp_path / "rig")
    return Path("rig")


@pytest.fixture
def few(written: Path, run: Run, tmp_path: Path, here: None) -> Path:  # noqa: ARG001 - they take effect by being there
    shutil.copytree(written / "few", tmp_path / "few")
    return Path("few")


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
    (folder / "mine.png").touch()
    assert run("batch-report", rig / "2026-03-01.npz", "-q", "--overwrite").code == 0
    left = {f"{kind.name}.png" for kind in figures_of("drift") if kind.name not in OF_A_TEST}
    assert {path.name for path in folder.iterdir()} == {"ledger.sqlite", *RESULTS, *left, "mine.png"}


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
    with closing(sqlite3.connect("friction-drift/ledger-1.sqlite")) as kept:
        assert kept.execute("SELECT COUNT(*) FROM arms").fetchone() == (1,)
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


def change(statement: str, *values: object) -> None:
    with closing(sqlite3.connect(LEDGER)) as database, database:
        assert database.execute(statement, values).rowcount > 0


def test_what_is_no_file_sinks_nothing(few: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    (few / "dangling.csv").symlink_to("absent.csv")
    (few / "loop.csv").symlink_to("loop.csv")
    os.mkfifo(few / "pipe.csv")
    os.mkfifo(few / "pipe2.csv")
    with closing(socket.socket(socket.AF_UNIX)) as end:
        end.bind(str(few / "socket.csv"))
    Path(os.fsdecode(bytes(few) + b"/bad\xff.csv")).write_text("time,q_1\n0,1\n1,2\n")
    shutil.copy(few / "rig-2026-03-01.npz", os.fsdecode(bytes(few) + b"/\xe4 2026-03-09.npz"))
    (few / "locked").mkdir()
    real = os.scandir

    def scandir(path: str = ".") -> object:
        if str(path).endswith("locked"):
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(os, "scandir", scandir)
    for _ in range(2):
        answer = run("batch-report", few, "--json", "-q")
        assert answer.code == 6, answer
        document = answer.document()
        assert len(document["sessions"]) == FEW
        failed = {Path(one["path"]).name: one["message"] for one in document["failed"]}
        assert set(failed) == {
            "dangling.csv", "loop.csv", "pipe.csv", "pipe2.csv", "socket.csv", "bad\\udcff.csv", "locked"
        }  # fmt: skip
        assert "a link to absent.csv" in failed["dangling.csv"]
        assert "a pipe or a device" in failed["pipe.csv"]
        assert "no column for a torque" in failed["bad\\udcff.csv"]
    assert run("batch-report", few / "dangling.csv", few / "rig-2026-03-01.npz", "-q", "-o", "other").code == 6


def test_a_broken_note_blocks_nothing(few: Path, run: Run) -> None:
    assert run("batch-report", few, "-q").code == 0
    for note in ("{", "[]", '{"request": 1}', "0" * 64 + " {}", b"\xff"):
        change("UPDATE meta SET value = ? WHERE key = 'reported'", note)
        answer = run("batch-report", few)
        assert (answer.code, "note on the last report is damaged" in answer.err) == (0, True), note
        assert f"0 computed, {FEW} known" in answer.out
    assert "damaged" not in run("batch-report", few).err


def test_a_ledger_that_was_not_closed_is_checked(few: Path, run: Run) -> None:
    assert run("batch-report", few, "-q").code == 0
    content = bytearray(LEDGER.read_bytes())
    content[8192:12288] = bytes(4096)  # a page of its own
    LEDGER.write_bytes(content)
    LEDGER.with_name("ledger.sqlite-wal").touch()
    answer = run("batch-report", few, "--overwrite")
    assert answer.code == 3, answer
    assert "--rebuild" in answer.err
    assert run("batch-report", few, "-q", "--rebuild").code == 0


def test_copies_are_one_line_and_the_name_like_the_others_stays(few: Path, run: Run) -> None:
    for number in range(6):
        shutil.copy2(few / "rig-2026-03-02.npz", few / f"a copy {'x' * number} 2026-03-{20 + number}.npz")
    answer = run("batch-report", few, "--json")
    starts = [session["start"][:10] for session in answer.document()["sessions"]]
    assert starts == [f"2026-03-{day + 1:02d}" for day in range(FEW)]
    assert len(answer.document()["warnings"]) == 1
    answer = run("batch-report", few)
    (line,) = [line for line in answer.err.splitlines() if "the same recording as" in line]
    assert "rig-2026-03-02.npz; and 3 more copies" in line


def test_a_damaged_log_is_a_session_and_named(few: Path, run: Run) -> None:
    write_log(read_log(few / "rig-2026-03-03.npz"), few / "rig-2026-03-09.csv")
    text = (few / "rig-2026-03-09.csv").read_text()
    (few / "rig-2026-03-09.csv").write_text(text[: text.rindex(",")])
    answer = run("batch-report", few)
    assert answer.code == 6
    said = "rig-2026-03-09.csv: damaged, part of it is left out; the rest counts as a session"
    assert said in answer.err
    assert said in Path("friction-drift/batch.html").read_text(encoding="utf-8")


def test_a_log_replaced_while_read_keeps_its_content(few: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A copy of equal size and times (``cp -p``) takes the place of a log after it was read, before it is hashed."""
    first, second = few / "rig-2026-03-01.npz", few / "rig-2026-03-02.npz"
    levels = {}
    for path in (first, second):
        levels[path] = run("batch-report", path, "-q", "--json", "-o", f"alone-{path.stem}").document()["sessions"][0]
    size = max(first.stat().st_size, second.stat().st_size)
    for path in (first, second):  # a zip archive may have a tail
        path.write_bytes(path.read_bytes().ljust(size, b"\0"))
    replaced: list[Path] = []

    def replace_then_hash(path: Path) -> str:
        if path.name == first.name and not replaced:
            replaced.append(path)
            times = first.stat()
            first.write_bytes(second.read_bytes())
            os.utime(first, ns=(times.st_atime_ns, times.st_mtime_ns))
        return sha256_of(path)

    monkeypatch.setattr("friction_audit.io.readers.sha256_of", replace_then_hash)
    found = run("batch-report", first, "-q", "--json").document()["sessions"][0]
    assert replaced
    expected = levels[second]["joints"][0]["coulomb_nm"]
    assert found["joints"][0]["coulomb_nm"] == expected


def test_a_limit_that_cannot_be_tested(few: Path, run: Run) -> None:
    (few / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    answer = run("batch-report", few, "-q", "--fail-on", "coulomb=0.01%")
    assert answer.code == 7, answer
    assert "cannot test:" in answer.out
    document = run("batch-report", few, "-q", "--json", "--fail-on", "joint9.coulomb=10%", "--overwrite")
    assert (document.code, len(document.document()["cannot_tell"])) == (7, 1)
    assert run("batch-report", few, "-q", "--fail-on", "coulomb=500%").code == 6
