"""A ledger whose rows are broken or changed: each such session is named and computed anew, the others are not."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.batch.conftest import Batch, Inline

BROKEN: dict[str, str] = {
    "curve": "UPDATE joints SET curve = '{' WHERE session = 1",
    "warnings": "UPDATE sessions SET warnings = '[1' WHERE id = 1",
    "text": "UPDATE coefficients SET value = 'much' WHERE session = 1",
    "blob": "UPDATE coefficients SET value = x'00ff' WHERE session = 1",
    "infinite": "UPDATE sessions SET told_start_s = 9e999 WHERE id = 1",
    "no UTF-8": "UPDATE joints SET name = CAST(x'6aff' AS TEXT) WHERE session = 1",
    "half gone": "DELETE FROM coefficients WHERE session = 1 AND coefficient = 'coulomb_nm'",
    "twice the value": "UPDATE coefficients SET value = 2 * value WHERE session = 1",
    "of another session": "UPDATE joints SET session = 77 WHERE session = 1",
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_session_is_named_and_computed_anew(fault: str, rig: Path, batch: Batch, tmp_path: Path) -> None:
    first = batch(rig)
    with closing(sqlite3.connect(tmp_path / "out" / "ledger.sqlite")) as database, database:
        (path,) = database.execute("SELECT path FROM sessions WHERE id = 1").fetchone()
        assert database.execute(BROKEN[fault]).rowcount > 0
    executor = Inline()
    second = batch(rig, executor=executor)
    assert executor.taken == [Path(path).name]
    (warning,) = second.warnings
    assert warning.startswith(f"{path}: ")
    assert repr(second.sessions) == repr(first.sessions)
    assert batch(rig).warnings == ()


@pytest.mark.parametrize(("schema", "absent"), [(1, ("digest", "codes")), (2, ("codes",))])
def test_a_ledger_of_an_older_schema_is_opened(
    schema: int, absent: tuple[str, ...], rig: Path, batch: Batch, tmp_path: Path
) -> None:
    first = batch(rig)
    with closing(sqlite3.connect(tmp_path / "out" / "ledger.sqlite")) as database:
        for column in absent:
            database.execute(f"ALTER TABLE sessions DROP COLUMN {column}")
        database.execute(f"PRAGMA user_version = {schema}")
    second = batch(rig)
    assert repr(second.sessions) == repr(first.sessions)
    assert schema > 1 or second.new == 4  # without a digest, nothing is known of them
