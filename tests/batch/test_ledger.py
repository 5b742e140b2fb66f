"""What a ledger keeps, whole although runs are killed; of one whose rows are broken such sessions are computed anew."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import Fault, Worked
from friction_audit.batch.ledger import RESULTS_VERSION, SCHEMA_VERSION, BatchSettings, Ledger
from friction_audit.batch.run_batch import run_lock
from friction_audit.drift.session import SpeedCurve
from friction_audit.errors import InputError
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog
from friction_audit.preprocessing.interaction import Caution, quoted
from friction_audit.preprocessing.settings import TorqueSettings
from tests.batch.conftest import Batch, Inline
from tests.drift.made_sessions import make_joint, make_session

SETTINGS = BatchSettings()
KEY = SETTINGS.key()
LOG = LogFile(path="a.csv", place="/logs/a.csv", folders=("logs",), size=10, changed="7")
THIRD = 1.0 / 3.0
JOINTS = (
    replace(
        make_joint(1, THIRD, temperature=31.5, within={"coulomb_nm": Coefficient(value=0.0, low=-THIRD, high=1e308)}),
        coefficients={
            "coulomb_nm": Coefficient(value=THIRD, low=0.1 + 0.2, high=5e-324),
            "viscous_nms_per_rad": UNDETERMINED,
        },
        curve=SpeedCurve(speed_rad_s=(-THIRD, THIRD), torque_nm=(-0.3, 0.1 + 0.2), spread_nm=(0.0, 1e-17)),
        verdict="named",
        effects=("stribeck", "warm_up"),
    ),
    replace(make_joint(2, 0.0, speed=float("nan")), name="Gelenk ä", reason=(Caution("constant_position"),)),
)
SESSION = replace(
    make_session(0, JOINTS, start=1.7e9 + THIRD, robot="left"),
    path="a.csv",
    sha256="f00",
    warnings=(*quoted("one"), Caution(code="dq_late", joint=2, numbers={"joints": [2], "lags_s": [THIRD]})),
    damaged=True,
    kind="panda",
    named_by_serial=True,
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "out" / "ledger.sqlite"


def test_numbers_come_back_to_the_bit(path: Path) -> None:
    with Ledger(path) as ledger:
        ledger.save(LOG, SETTINGS, Worked(sha256="f00", sessions=(SESSION,)))
    with Ledger(path) as ledger:
        assert repr(ledger.known(["f00"], KEY)["f00"].sessions) == repr((SESSION,))
        assert ledger.known(["f00"], "other settings") == {}
        assert ledger.known([f"{n:x}" for n in range(2000)] + ["f00"], KEY).keys() == {"f00"}


def test_a_log_with_a_fault_that_may_pass_is_not_done(path: Path) -> None:
    passing = Fault(message="killed", topic="/r", lasting=False)
    with Ledger(path) as ledger:
        ledger.save(LOG, SETTINGS, Worked(sha256="f00", sessions=(SESSION,), faults=(passing,)))
        assert not ledger.is_done("f00", KEY)
        ledger.save(LOG, SETTINGS, Worked(sha256="f00", sessions=(SESSION,)))
        assert ledger.is_done("f00", KEY)
        assert not ledger.is_done("f00", "other settings")


def test_names_are_written_with_the_numbers(path: Path) -> None:
    named = replace(SESSION, path="b.csv", robot="R1", start_s=5.0)
    with Ledger(path) as ledger:
        ledger.save(LOG, SETTINGS, Worked(sha256="f00", sessions=(SESSION,)))
        ledger.name_sessions([named], KEY)
        assert repr(ledger.known(["f00"], KEY)["f00"].sessions) == repr((SESSION,))
    with closing(sqlite3.connect(path)) as opened:
        rows = opened.execute("SELECT * FROM friction").fetchall()
    assert rows[0] == ("R1", "1970-01-01 00:00:05", "b.csv", 1, "coulomb_nm", THIRD, 0.1 + 0.2, 5e-324)
    assert rows[1][4:] == ("viscous_nms_per_rad", None, None, None)


def test_a_transaction_that_breaks_leaves_nothing(path: Path) -> None:
    broken = replace(SESSION, joints=(JOINTS[0], object()))  # type: ignore[arg-type]
    with Ledger(path) as ledger:
        with pytest.raises(TypeError):
            ledger.save(LOG, SETTINGS, Worked(sha256="f00", sessions=(broken,)))
        assert ledger.known(["f00"], KEY) == {}
        assert ledger.known_hashes([LOG]) == {}


def database(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path)) as opened, opened:
        opened.execute(statement)


def newer_ledger(path: Path) -> None:
    with Ledger(path):
        pass
    database(path, f"PRAGMA user_version = {SCHEMA_VERSION + 1}")


def damaged_names(path: Path) -> None:
    with Ledger(path):
        pass
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE", b"CREATE \xbeABLE"))


FAULTY: dict[str, tuple[Callable[[Path], object], str]] = {
    "text": (lambda path: path.write_text("hello, this is a text " * 20), "no SQLite database, and so no ledger"),
    "other": (lambda path: database(path, "CREATE TABLE songs (title TEXT)"), "an SQLite database, but no ledger"),
    "newer": (newer_ledger, f"a ledger of schema {SCHEMA_VERSION + 1}; this friction-audit knows {SCHEMA_VERSION}"),
    "names": (damaged_names, "can't decode byte 0xbe .*; if the file is broken, choose another folder"),
    "folder": (lambda path: path.mkdir(), "cannot be opened"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_what_is_no_ledger_is_refused_and_left_alone(fault: str, path: Path) -> None:
    make, message = FAULTY[fault]
    path.parent.mkdir()
    make(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(InputError, match=message) as caught:
        Ledger(path)
    assert str(caught.value).startswith(str(path))
    assert before is None or path.read_bytes() == before


def test_settings_are_known_by_what_they_hold(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text("<robot/>")
    audit = replace(SETTINGS.audit, torque=TorqueSettings(urdf=urdf))
    with_arm = replace(SETTINGS, audit=audit)
    first = with_arm.key()
    assert first not in (KEY, "")
    assert BatchSettings().key() == KEY
    urdf.write_text("<robot name='other'/>")
    assert with_arm.key() != first
    assert f'"results": {RESULTS_VERSION}' in SETTINGS.text()


BROKEN: dict[str, str] = {
    "cut": "UPDATE arms SET content = '{' WHERE id = 1",
    "blob": "UPDATE arms SET content = x'00ff' WHERE id = 1",
    "no UTF-8": "UPDATE arms SET content = CAST(x'6aff' AS TEXT) WHERE id = 1",
    "another number": "UPDATE arms SET content = replace(content, '\"value\": 0.3', '\"value\": 0.6') WHERE id = 1",
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_session_is_named_and_computed_anew(fault: str, rig: Path, batch: Batch, tmp_path: Path) -> None:
    rig /= "2026-03-01.parquet"
    first = batch(rig)
    with closing(sqlite3.connect(tmp_path / "out" / "ledger.sqlite")) as opened, opened:
        (path,) = opened.execute("SELECT path FROM arms WHERE id = 1").fetchone()
        assert opened.execute(BROKEN[fault]).rowcount > 0
    executor = Inline()
    second = batch(rig, executor=executor)
    assert executor.taken == [Path(path).name]
    (warning,) = second.warnings
    assert warning.startswith(f"{path}: ")
    assert repr(second.sessions) == repr(first.sessions)
    assert batch(rig).warnings == ()


# Runs that are killed, and runs side by side: the ledger is whole, and nothing finished is done again.

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
    print(standing.new, len(gather(standing, BatchSettings(), ledger)[0]))
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
    log: Any = recordings[0]
    for number in range(LOGS):
        torque = log.tau_interaction * (1.0 + 0.01 * number)
        write_log(replace(log, tau_interaction=np.asfortranarray(torque)), folder / f"run{number}.npz")
    return folder


def test_killed_at_any_moment_nothing_finished_is_lost_or_done_again(many: Path, tmp_path: Path) -> None:
    rng, output, before = random.Random(6), tmp_path / "out", 0
    for kill in range(KILLS):
        target, begin = before + rng.randint(0, LOGS // KILLS - 1), time.monotonic()
        with start(many, output) as process:
            while finished(output) <= target and process.poll() is None:
                assert time.monotonic() < begin + PATIENCE_S
                time.sleep(rng.uniform(0.0, 0.05))
            process.send_signal(signal.SIGKILL)
        after = finished(output)
        assert after >= before, kill
        before = after
    assert 0 < before <= LOGS
    runs = [start(many, output) for _ in range(2)]  # on one ledger they share what is left
    new, sessions = zip(*(map(int, run.communicate(timeout=PATIENCE_S)[0].split()) for run in runs), strict=True)
    assert [run.returncode for run in runs] == [0, 0]
    assert (max(new), sessions) == (LOGS - before, (LOGS, LOGS))
    assert finished(output) == LOGS


def test_the_second_run_in_a_folder_knows_of_the_first(tmp_path: Path) -> None:
    with run_lock(tmp_path) as alone, run_lock(tmp_path) as also:
        assert (alone, also) == (True, False)
    with run_lock(tmp_path) as alone:
        assert alone
