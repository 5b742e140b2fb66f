"""Runs that are killed, and runs side by side: the ledger is whole, and nothing finished is done again."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from friction_audit.batch.run_batch import run_lock
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog

KILLS = int(os.environ.get("FRICTION_AUDIT_KILLS", "2"))
"""FRICTION_AUDIT_KILLS=10 takes a minute on a machine with nothing else to do."""
LOGS = 8 * KILLS
PATIENCE_S = 120.0

RUN = """
import sys
from pathlib import Path
from friction_audit.batch.find_logs import find_logs
from friction_audit.batch.ledger import BatchSettings, Ledger
from friction_audit.batch.executor import LocalExecutor
from friction_audit.batch.run_batch import catch_up, gather, run_lock

logs, folder = find_logs([sys.argv[1]], {}), Path(sys.argv[2])
folder.mkdir(exist_ok=True)
with run_lock(folder) as alone, Ledger(folder / "ledger.sqlite") as ledger, LocalExecutor(workers=1) as executor:
    standing = catch_up(logs, BatchSettings(), ledger, executor, lambda *_: None, backwards=not alone)
    print(standing.new, len(gather(standing, BatchSettings(), ledger).sessions))
"""


def start(logs: Path, output: Path) -> "subprocess.Popen[str]":
    return subprocess.Popen([sys.executable, "-c", RUN, str(logs), str(output)], stdout=subprocess.PIPE, text=True)


def finished(output: Path) -> int:
    """Return how many sessions the ledger holds, each with all its rows."""
    path = output / "ledger.sqlite"
    if not path.exists():
        return 0
    with closing(sqlite3.connect(path, timeout=30.0, isolation_level=None)) as database:
        database.execute("BEGIN")  # A run goes on writing beside: all that is counted is counted at one moment.
        if not database.execute("SELECT 1 FROM sqlite_master WHERE name = 'coefficients'").fetchone():
            return 0
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        tables = ("arms WHERE message IS NULL", "coefficients")
        sessions, pairs = (database.execute(f"SELECT COUNT(*) FROM {table}").fetchone()[0] for table in tables)
    assert pairs == 2 * sessions
    return int(sessions)


@pytest.fixture(scope="module")
def many(recordings: tuple[JointLog, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of many logs."""
    folder = tmp_path_factory.mktemp("many")
    log = recordings[0]
    assert log.tau_interaction is not None
    for number in range(LOGS):
        torque = log.tau_interaction * (1.0 + 0.01 * number)
        write_log(replace(log, tau_interaction=np.asfortranarray(torque)), folder / f"run{number}.npz")
    return folder


def test_killed_at_any_moment_nothing_finished_is_lost_or_done_again(many: Path, tmp_path: Path) -> None:
    moments, output, before = random.Random(6), tmp_path / "out", 0
    for kill in range(KILLS):
        target, begin = before + moments.randint(0, LOGS // KILLS - 1), time.monotonic()
        with start(many, output) as process:
            while finished(output) <= target and process.poll() is None:
                assert time.monotonic() < begin + PATIENCE_S
                time.sleep(moments.uniform(0.0, 0.05))
            process.send_signal(signal.SIGKILL)
        after = finished(output)
        assert after >= before, kill
        before = after
    assert 0 < before <= LOGS
    out, _ = start(many, output).communicate(timeout=PATIENCE_S)
    assert [int(number) for number in out.split()] == [LOGS - before, LOGS]
    assert finished(output) == LOGS


def test_two_runs_on_one_ledger_share_the_work(many: Path, tmp_path: Path) -> None:
    runs = [start(many, tmp_path / "out") for _ in range(2)]
    for run in runs:
        out, _ = run.communicate(timeout=PATIENCE_S)
        assert run.returncode == 0
        assert out.split()[1] == str(LOGS)
    assert finished(tmp_path / "out") == LOGS


def test_the_second_run_in_a_folder_knows_of_the_first(tmp_path: Path) -> None:
    with run_lock(tmp_path) as alone:
        assert alone
        with run_lock(tmp_path) as also:
            assert not also
    with run_lock(tmp_path) as alone:
        assert alone
