"""Ledger: an SQLite file that keeps what came of every log, for ever, by its content and the settings.

Every log is one transaction, so that a run that is killed at any moment loses nothing that was finished, and runs side
by side on one ledger only find each other's work done.
"""

import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Self

from friction_audit.batch import ledger_rows as rows
from friction_audit.batch.find_logs import LogFile, as_text
from friction_audit.batch.identity import Fault, Recorded, Worked
from friction_audit.batch.ledger_rows import APPLICATION_ID, SCHEMA_VERSION
from friction_audit.batch.manifest import BatchSettings
from friction_audit.drift.session import Session
from friction_audit.errors import InputError

BUSY_S = 60.0  # to wait while another run writes
PARTS = ("", "-wal", "-shm")  # endings of the files that a ledger consists of while it is open
UNCLEAN = ("-wal", "-journal")  # what lies next to a ledger that is open or was not closed
AT_ONCE = 50  # keys per query: SQLite takes no more than a thousand, and rows take memory
OTHER_PLACE = "choose another folder with -o, or --rebuild to move it aside and compute again"


class Ledger:
    """The sessions that are known.

    Args:
        path: The file, made if it is not there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        unclean = any(path.with_name(path.name + ending).exists() for ending in UNCLEAN)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise InputError(f"{path}: cannot be made or opened: {error}; choose another folder with -o") from error
        self._database.row_factory = sqlite3.Row
        # A broken row must not hide the others.
        self._database.text_factory = lambda content: content.decode("utf-8", "surrogateescape")
        try:
            with self._worded():
                self._set_up()
                if unclean:
                    self._check()
        except BaseException:
            self._database.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; nothing is written here that was not safe before."""
        self._database.close()

    def known_hash(self, log: LogFile) -> str | None:
        """Return the hash of a log's content if the log has not changed since it was last looked at."""
        query = "SELECT sha256 FROM files WHERE place = ? AND size = ? AND changed = ?"
        found = self._ask(query, (as_text(log.place), log.size, log.changed))
        return str(found[0]["sha256"]) if found else None

    def known_sizes(self) -> set[int]:
        """Return the sizes of all logs that were looked at; content of another size is new."""
        return {row["size"] for row in self._ask("SELECT DISTINCT size FROM files")}

    def remember(self, log: LogFile, sha256: str) -> None:
        """Keep the hash of a log's content."""
        with self._transaction():
            self._remember(log, sha256)

    def is_done(self, sha256: str, settings: str) -> bool:
        """Return True if nothing new would come of a log."""
        where = "WHERE sha256 = :sha256 AND settings = :settings"
        query = f"""SELECT
            (EXISTS (SELECT 1 FROM sessions {where}) OR EXISTS (SELECT 1 FROM failed {where} AND lasting))
            AND NOT EXISTS (SELECT 1 FROM failed {where} AND NOT lasting)"""  # noqa: S608
        return bool(self._ask(query, {"sha256": sha256, "settings": settings})[0][0])

    def forget_broken(self, hashes: Iterable[str], settings: str) -> set[str]:
        """Remove the sessions whose stored content is not what was written; return the hashes of their logs."""
        broken: dict[int, str] = {}
        for some in _in_lots(dict.fromkeys(hashes)):
            for row, joints, coefficients in self._stored(some, settings):
                if row["digest"] != rows.digest_of(row, joints, coefficients):
                    broken[row["id"]] = row["sha256"]
        unreadable = "typeof(message) <> 'text' OR typeof(topic) <> 'text' OR typeof(lasting) <> 'integer'"
        if broken or self._ask(f"SELECT 1 FROM failed WHERE {unreadable}"):  # noqa: S608 - a constant
            with self._transaction():
                self._database.execute(f"DELETE FROM failed WHERE {unreadable}")  # noqa: S608
                for key in broken:
                    self._forget_rows(key)
                    self._database.execute("DELETE FROM sessions WHERE id = ?", (key,))
        return set(broken.values())

    def save(self, log: LogFile, settings: BatchSettings, worked: Worked) -> None:
        """Keep what came of a log, all of it or nothing."""
        key = settings.key()
        with self._transaction():
            self._database.execute("INSERT OR IGNORE INTO settings VALUES (?, ?)", (key, settings.text()))
            self._database.execute("DELETE FROM failed WHERE settings = ? AND place = ?", (key, as_text(log.place)))
            if worked.sha256:
                self._database.execute("DELETE FROM failed WHERE settings = ? AND sha256 = ?", (key, worked.sha256))
                self._remember(log, worked.sha256)
            for recorded in worked.recorded:
                self._save_session(recorded, key)
            for fault in worked.faults:
                self._save_fault(log, key, worked.sha256, fault)

    def recorded(self, hashes: Iterable[str], settings: str) -> dict[str, tuple[Recorded, ...]]:
        """Return what is known of logs, by the hash of their content; of several arms in the order of their topics."""
        found: dict[str, tuple[Recorded, ...]] = {}
        for some in _in_lots(dict.fromkeys(hashes)):
            for row, joints, coefficients in self._stored(some, settings):
                of_joint: dict[int, list[sqlite3.Row]] = defaultdict(list)
                for one in coefficients:
                    of_joint[one["joint"]].append(one)
                recorded = rows.recorded_from(row, joints, of_joint)
                found[row["sha256"]] = (*found.get(row["sha256"], ()), recorded)
        return found

    def _stored(
        self, hashes: tuple[str, ...], settings: str
    ) -> Iterator[tuple[sqlite3.Row, list[sqlite3.Row], list[sqlite3.Row]]]:
        """Yield the row of each session of some logs with those of its joints and coefficients, by topic."""
        chosen = f"FROM sessions WHERE settings = ? AND sha256 IN ({_marks(hashes)})"
        joints = self._by_session("joints", chosen, settings, hashes)
        coefficients = self._by_session("coefficients", chosen, settings, hashes)
        for row in self._ask(f"SELECT * {chosen} ORDER BY topic", (settings, *hashes)):
            yield row, joints[row["id"]], coefficients[row["id"]]

    def faults(self, hashes: Iterable[str], settings: str) -> dict[str, tuple[Fault, ...]]:
        """Return what is lastingly wrong with logs, by the hash of their content."""
        found: dict[str, dict[str, Fault]] = defaultdict(dict)
        for some in _in_lots(dict.fromkeys(hashes)):
            query = f"SELECT * FROM failed WHERE settings = ? AND sha256 IN ({_marks(some)}) AND lasting ORDER BY topic"  # noqa: S608
            for row in self._ask(query, (settings, *some)):
                found[row["sha256"]][row["topic"]] = Fault(message=row["message"], topic=row["topic"])
        return {sha256: tuple(faults.values()) for sha256, faults in found.items()}

    def name_sessions(self, named: Iterable[tuple[Session, str]], settings: str) -> None:
        """Write which arm sessions are of, and when they were, with their numbers; each with its topic."""
        query = """UPDATE sessions SET path = :path, robot = :robot, start_s = :start_s, start_from = :start_from,
            payload = :payload, temperature_c = :temperature_c, note = :note
            WHERE sha256 = :sha256 AND settings = :settings AND topic = :topic AND (path, robot, start_s, start_from,
            payload, temperature_c, note)
            IS NOT (:path, :robot, :start_s, :start_from, :payload, :temperature_c, :note)"""
        own = ("path", "robot", "start_s", "start_from", "temperature_c", "note", "sha256")
        values = [
            {name: getattr(session, name) for name in own}
            | {"payload": session.conditions.payload, "settings": settings, "topic": topic}
            for session, topic in named
        ]
        with self._transaction():
            self._database.executemany(query, values)

    def note(self, key: str) -> str | None:
        """Return a note about the ledger as a whole."""
        found = self._ask("SELECT value FROM meta WHERE key = ?", (key,))
        return str(found[0]["value"]) if found else None

    def write_note(self, key: str, value: str) -> None:
        """Keep a note about the ledger as a whole."""
        with self._transaction():
            self._database.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))

    def _set_up(self) -> None:
        """Make the tables of an empty file; refuse a file that is something else."""
        version = self._pragma("user_version")
        holds_tables = bool(self._ask("SELECT 1 FROM sqlite_master LIMIT 1"))
        if holds_tables and self._pragma("application_id") != APPLICATION_ID:
            raise InputError(f"{self.path}: an SQLite database, but no ledger; {OTHER_PLACE}")
        if version > SCHEMA_VERSION:
            raise InputError(
                f"{self.path}: a ledger of schema {version}; this friction-audit knows {SCHEMA_VERSION}; use the newer "
                "one that made it, or --rebuild to move it aside and compute again"
            )
        self._database.execute("PRAGMA journal_mode = WAL")
        self._database.execute("PRAGMA synchronous = NORMAL")
        if version == SCHEMA_VERSION:
            return
        with self._transaction():
            for table in rows.TABLES:
                self._database.execute(table)
            held = {column["name"] for column in self._ask("PRAGMA table_info(sessions)")}
            for name, default in (("digest", "''"), ("codes", "'[]'")):
                if name not in held:
                    # An older schema: its sessions are of older results, which are never asked for again.
                    self._database.execute(f"ALTER TABLE sessions ADD COLUMN {name} TEXT NOT NULL DEFAULT {default}")
                    self._database.execute("DELETE FROM meta WHERE key = 'reported'")
            self._database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            self._database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")

    def _forget_rows(self, key: int) -> None:
        for table in ("joints", "coefficients"):
            self._database.execute(f"DELETE FROM {table} WHERE session = ?", (key,))  # noqa: S608 - names from here

    def _check(self) -> None:
        """Refuse a file in which SQLite finds faults."""
        said = [str(row[0]) for row in self._ask("PRAGMA quick_check(3)")]
        if said != ["ok"]:
            raise InputError(f"{self.path}: a damaged ledger ({'; '.join(said)}); {OTHER_PLACE}")

    def _pragma(self, name: str) -> int:
        return int(self._database.execute(f"PRAGMA {name}").fetchone()[0])

    def _save_session(self, recorded: Recorded, settings: str) -> None:
        cursor = self._database.execute(rows.insert("sessions"), rows.session_row(recorded, settings))
        if cursor.rowcount == 0:
            return  # another run was faster
        key, joints = cursor.lastrowid, recorded.session.joints
        assert key is not None
        self._forget_rows(key)  # those of a session that was lost, which had this number
        self._database.executemany(rows.insert("joints"), rows.joint_rows(key, joints))
        self._database.executemany(rows.insert("coefficients"), rows.coefficient_rows(key, joints))
        for row, *parts in self._stored((recorded.session.sha256,), settings):
            if row["id"] == key:
                digest = rows.digest_of(row, *parts)
                self._database.execute("UPDATE sessions SET digest = ? WHERE id = ?", (digest, key))

    def _save_fault(self, log: LogFile, settings: str, sha256: str, fault: Fault) -> None:
        place, path = as_text(log.place), log.path
        values = (place, settings, fault.topic, sha256, path, fault.message, fault.lasting, fault.detail)
        self._database.execute("INSERT OR REPLACE INTO failed VALUES (?, ?, ?, ?, ?, ?, ?, ?)", values)

    def _remember(self, log: LogFile, sha256: str) -> None:
        values = (as_text(log.place), log.size, log.changed, sha256)
        self._database.execute("INSERT OR REPLACE INTO files VALUES (?, ?, ?, ?)", values)

    def _by_session(
        self, table: str, chosen: str, settings: str, hashes: tuple[str, ...]
    ) -> Mapping[int, list[sqlite3.Row]]:
        found: dict[int, list[sqlite3.Row]] = defaultdict(list)
        query = f"SELECT * FROM {table} WHERE session IN (SELECT id {chosen}) ORDER BY session, joint"  # noqa: S608
        for row in self._ask(query, (settings, *hashes)):
            found[row["session"]].append(row)
        return found

    def _ask(self, query: str, values: tuple[object, ...] | dict[str, object] = ()) -> list[sqlite3.Row]:
        with self._worded():
            return self._database.execute(query, values).fetchall()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        with self._worded():
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                self._database.rollback()
                raise
            self._database.commit()

    @contextmanager
    def _worded(self) -> Iterator[None]:
        """Turn an error of SQLite into an InputError."""
        try:
            yield
        except sqlite3.DatabaseError as error:
            if getattr(error, "sqlite_errorname", "") == "SQLITE_NOTADB":
                raise InputError(f"{self.path}: no SQLite database, and so no ledger; {OTHER_PLACE}") from error
            raise InputError(
                f"{self.path}: {error}; check that its folder can be written to, is not full and lies on a disk of "
                f"this machine; if the file is broken, {OTHER_PLACE}"
            ) from error


def move_aside(path: Path) -> Path | None:
    """Give a ledger another name, so that a new one can be begun; return that name, or None if there was none."""
    if not path.exists():
        return None
    names = (path.with_name(f"{path.stem}-{number}{path.suffix}") for number in count(1))
    target = next(name for name in names if not name.exists())
    try:
        for ending in PARTS:  # what has not been copied from the log of changes yet goes with it
            part = path.with_name(path.name + ending)
            if part.exists():
                part.rename(target.with_name(target.name + ending))
    except OSError as error:
        raise InputError(f"{path}: cannot be moved aside: {error.strerror}; check the folder's permissions") from error
    return target


def _marks(keys: tuple[str, ...]) -> str:
    return ", ".join("?" * len(keys))  # values never become part of a query


def _in_lots(keys: Iterable[str]) -> Iterator[tuple[str, ...]]:
    every = tuple(keys)
    for first in range(0, len(every), AT_ONCE):
        yield every[first : first + AT_ONCE]
