"""``batch-report`` where files, names or the ledger are broken: what is sound is reported, the rest is named."""

import os
import shutil
import socket
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from friction_audit.io.files import sha256_of
from friction_audit.io.writers.write_log import write_log
from friction_audit.simulation import BenchSettings, simulate
from tests.cli.conftest import Run
from tests.in_this_process import in_this_process

DAYS = 4
LEDGER = Path("friction-drift/ledger.sqlite")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("days") / "rig"
    for day in range(DAYS):
        log = simulate(BenchSettings(duration_s=15.0, rate_hz=200.0), seed=day).log
        write_log(log, folder / f"rig-2026-03-{day + 1:02d}.npz")
    return folder


@pytest.fixture
def rig(written: Path, run: Run, tmp_path: Path, sketched: None) -> Iterator[Path]:  # noqa: ARG001 - it takes effect
    assert run("--version").code == 0
    shutil.copytree(written, tmp_path / "rig")
    with in_this_process():
        yield Path("rig")


def change(statement: str, *values: object) -> None:
    with closing(sqlite3.connect(LEDGER)) as database, database:
        assert database.execute(statement, values).rowcount > 0


def test_what_is_no_file_sinks_nothing(rig: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    (rig / "dangling.csv").symlink_to("absent.csv")
    (rig / "loop.csv").symlink_to("loop.csv")
    os.mkfifo(rig / "pipe.csv")
    os.mkfifo(rig / "pipe2.csv")
    with closing(socket.socket(socket.AF_UNIX)) as end:
        end.bind(str(rig / "socket.csv"))
    Path(os.fsdecode(bytes(rig) + b"/bad\xff.csv")).write_text("time,q_1\n0,1\n1,2\n")
    shutil.copy(rig / "rig-2026-03-01.npz", os.fsdecode(bytes(rig) + b"/\xe4 2026-03-09.npz"))
    (rig / "locked").mkdir()
    real = os.scandir

    def scandir(path: str = ".") -> object:
        if str(path).endswith("locked"):
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(os, "scandir", scandir)
    for _ in range(2):
        answer = run("batch-report", rig, "--json", "-q")
        assert answer.code == 6, answer
        document = answer.document()
        assert len(document["sessions"]) == DAYS
        failed = {Path(one["path"]).name: one["message"] for one in document["failed"]}
        assert set(failed) == {
            "dangling.csv", "loop.csv", "pipe.csv", "pipe2.csv", "socket.csv", "bad\\udcff.csv", "locked"
        }  # fmt: skip
        assert "a link to absent.csv" in failed["dangling.csv"]
        assert "a pipe or a device" in failed["pipe.csv"]
        assert "no column for a torque" in failed["bad\\udcff.csv"]
    assert run("batch-report", rig / "dangling.csv", rig / "rig-2026-03-01.npz", "-q", "-o", "other").code == 6


def test_a_broken_note_blocks_nothing(rig: Path, run: Run) -> None:
    assert run("batch-report", rig, "-q").code == 0
    for note in ("{", "[]", '{"request": 1}', "0" * 64 + " {}", b"\xff"):
        change("UPDATE meta SET value = ? WHERE key = 'reported'", note)
        answer = run("batch-report", rig)
        assert (answer.code, "note on the last report is damaged" in answer.err) == (0, True), note
        assert f"0 computed, {DAYS} known" in answer.out
    assert "damaged" not in run("batch-report", rig).err


def test_a_ledger_that_was_not_closed_is_checked(rig: Path, run: Run) -> None:
    assert run("batch-report", rig, "-q").code == 0
    content = bytearray(LEDGER.read_bytes())
    content[8192:12288] = bytes(4096)  # a page of its own
    LEDGER.write_bytes(content)
    LEDGER.with_name("ledger.sqlite-wal").touch()
    answer = run("batch-report", rig, "--overwrite")
    assert answer.code == 3, answer
    assert "--rebuild" in answer.err
    assert run("batch-report", rig, "-q", "--rebuild").code == 0


def test_copies_are_one_line_and_the_name_like_the_others_stays(rig: Path, run: Run) -> None:
    for number in range(6):
        shutil.copy2(rig / "rig-2026-03-02.npz", rig / f"a copy {'x' * number} 2026-03-{20 + number}.npz")
    answer = run("batch-report", rig, "--json")
    starts = [session["start"][:10] for session in answer.document()["sessions"]]
    assert starts == [f"2026-03-{day + 1:02d}" for day in range(DAYS)]
    assert len(answer.document()["warnings"]) == 1
    answer = run("batch-report", rig)
    (line,) = [line for line in answer.err.splitlines() if "the same recording as" in line]
    assert "rig-2026-03-02.npz; and 3 more copies" in line


def test_a_log_replaced_while_it_is_read_keeps_its_content(
    rig: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy of equal size and times (``cp -p``) takes the place of a log after it was read, before it is hashed."""
    first, second = rig / "rig-2026-03-01.npz", rig / "rig-2026-03-02.npz"
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

    monkeypatch.setattr("friction_audit.io.readers.read.sha256_of", replace_then_hash)
    found = run("batch-report", first, "-q", "--json").document()["sessions"][0]
    assert replaced
    expected = levels[second]["joints"][0]["coulomb_nm"]
    assert found["joints"][0]["coulomb_nm"] == expected


def test_a_limit_that_cannot_be_tested(rig: Path, run: Run) -> None:
    (rig / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    answer = run("batch-report", rig, "-q", "--fail-on", "coulomb=0.01%")
    assert answer.code == 7, answer
    assert "cannot test:" in answer.out
    document = run("batch-report", rig, "-q", "--json", "--fail-on", "joint9.coulomb=10%", "--overwrite")
    assert (document.code, len(document.document()["cannot_tell"])) == (7, 1)
    assert run("batch-report", rig, "-q", "--fail-on", "coulomb=500%").code == 6
