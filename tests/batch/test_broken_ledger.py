"""A ledger whose rows are broken or changed: each such session is named and computed anew, the others are not."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from friction_audit.batch.ledger_rows import SCHEMA_VERSION
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


def test_nothing_is_computed_anew_where_nothing_is_broken(rig: Path, batch: Batch, tmp_path: Path) -> None:
    first = batch(rig)
    to_schema_1(tmp_path)
    second = batch(rig)
    assert (second.new, second.warnings, repr(second.sessions)) == (0, (), repr(first.sessions))


@pytest.mark.parametrize(
    ("fault", "schema"),
    [
        (fault, schema)
        for fault in BROKEN
        for schema in (1, SCHEMA_VERSION)
        if (fault, schema) != ("twice the value", 1)
    ],
)
def test_a_broken_session_is_named_and_computed_anew(
    fault: str, schema: int, rig: Path, batch: Batch, tmp_path: Path
) -> None:
    first = batch(rig)
    if schema == 1:
        to_schema_1(tmp_path)
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


def to_schema_1(tmp_path: Path) -> None:
    """Make the ledger one of schema 1, which had no hashes."""
    with closing(sqlite3.connect(tmp_path / "out" / "ledger.sqlite")) as database:
        database.execute("ALTER TABLE sessions DROP COLUMN digest")
        database.execute("PRAGMA user_version = 1")
