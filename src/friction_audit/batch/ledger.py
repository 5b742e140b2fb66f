"""Ledger: an SQLite file that keeps what came of every log, for ever, by its content and the settings.

Every log is one transaction, so that a run that is killed at any moment loses nothing that was finished, and runs side
by side on one ledger only find each other's work done.
"""

import hashlib
import json
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any, Self

from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import Fault, Worked
from friction_audit.batch.manifest import BatchSettings
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.errors import InputError, encodable
from friction_audit.friction.history import Coefficient
from friction_audit.preprocessing.interaction import Caution

APPLICATION_ID = 0x46414C47  # "FALG" in the head of the file: an SQLite database without it is not a ledger
SCHEMA_VERSION = 5  # in user_version; raised with every change below
# A session is kept whole as JSON, which alone is read back. The columns ``path``, ``robot`` and ``start_s`` are written
# anew with every manifest; they and the coefficients are for people who open the file.
TABLES = (
    "CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, text TEXT NOT NULL)",
    """CREATE TABLE IF NOT EXISTS files (
        place TEXT PRIMARY KEY, size INTEGER NOT NULL, changed TEXT NOT NULL, sha256 TEXT NOT NULL)""",
    "CREATE INDEX IF NOT EXISTS files_by_size ON files (size)",
    """CREATE TABLE IF NOT EXISTS sessions (
        id INTEGER PRIMARY KEY, sha256 TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL, path TEXT NOT NULL,
        robot TEXT NOT NULL, start_s REAL, content TEXT NOT NULL, digest TEXT NOT NULL,
        UNIQUE (sha256, settings, topic))""",
    "CREATE INDEX IF NOT EXISTS sessions_by_settings ON sessions (settings)",
    """CREATE TABLE IF NOT EXISTS coefficients (
        session INTEGER NOT NULL, joint INTEGER NOT NULL, coefficient TEXT NOT NULL, value REAL, low REAL, high REAL,
        PRIMARY KEY (session, joint, coefficient)) WITHOUT ROWID""",
    """CREATE TABLE IF NOT EXISTS failed (
        place TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL, sha256 TEXT NOT NULL, path TEXT NOT NULL,
        message TEXT NOT NULL, lasting INTEGER NOT NULL, detail TEXT NOT NULL,
        PRIMARY KEY (place, settings, topic)) WITHOUT ROWID""",
    "CREATE INDEX IF NOT EXISTS failed_by_content ON failed (sha256, settings)",
    """CREATE VIEW IF NOT EXISTS friction AS
        SELECT robot, datetime(start_s, 'unixepoch') AS start, path, joint, coefficient, value, low, high
        FROM sessions JOIN coefficients ON session = id ORDER BY robot, start_s, path, joint, coefficient""",
)
BUSY_S = 60.0  # to wait while another run writes
PARTS = ("", "-wal", "-shm")  # endings of the files that a ledger consists of while it is open
UNCLEAN = ("-wal", "-journal")  # what lies next to a ledger that is open or was not closed
AT_ONCE = 50  # keys per query: SQLite takes no more than a thousand, and rows take memory
OTHER_PLACE = "choose another folder with -o, or --rebuild to move it aside and compute again"


class Ledger:
    """The sessions that are known; the file is made if it is not there."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.older: Path | None = None  # where a ledger of an older schema is kept now, if there was one
        unclean = any(path.with_name(path.name + ending).exists() for ending in UNCLEAN)
        self._open()
        try:
            with self._worded():
                is_ledger = self._pragma("application_id") == APPLICATION_ID
                if is_ledger and self._pragma("user_version") < SCHEMA_VERSION:
                    # Its sessions are of older results, which are never asked for again.
                    self._database.close()
                    self.older = move_aside(path)
                    self._open()
                self._set_up()
                if unclean:
                    self._check()
        except BaseException:
            self._database.close()
            raise

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(self.path, timeout=BUSY_S, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise InputError(f"{self.path}: cannot be opened: {error}; choose another folder with -o") from error
        self._database.row_factory = sqlite3.Row
        # A broken row must not hide the others.
        self._database.text_factory = lambda content: content.decode("utf-8", "surrogateescape")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._database.close()  # nothing is written here that was not safe before

    def known_hash(self, log: LogFile) -> str | None:
        """Return the hash of a log's content if the log has not changed since it was last looked at."""
        query = "SELECT sha256 FROM files WHERE place = ? AND size = ? AND changed = ?"
        found = self._ask(query, (encodable(log.place), log.size, log.changed))
        return str(found[0]["sha256"]) if found else None

    def known_sizes(self) -> set[int]:
        """Return the sizes of all logs that were looked at; content of another size is new."""
        return {row["size"] for row in self._ask("SELECT DISTINCT size FROM files")}

    def remember(self, log: LogFile, sha256: str) -> None:
        """Keep the hash of a log's content."""
        values = (encodable(log.place), log.size, log.changed, sha256)
        with self._worded():
            self._database.execute("INSERT OR REPLACE INTO files VALUES (?, ?, ?, ?)", values)

    def is_done(self, sha256: str, settings: str) -> bool:
        """Return True if nothing new would come of a log."""
        where = "WHERE sha256 = :sha256 AND settings = :settings"
        query = f"""SELECT
            (EXISTS (SELECT 1 FROM sessions {where}) OR EXISTS (SELECT 1 FROM failed {where} AND lasting))
            AND NOT EXISTS (SELECT 1 FROM failed {where} AND NOT lasting)"""  # noqa: S608
        return bool(self._ask(query, {"sha256": sha256, "settings": settings})[0][0])

    def forget_broken(self, hashes: Iterable[str], settings: str) -> set[str]:
        """Remove the sessions whose stored content is not what was written; return the hashes of their logs."""
        stored = self._of_logs("sessions", hashes, settings)
        broken = {row["id"]: str(row["sha256"]) for row in stored if row["digest"] != _digest(row["content"])}
        unreadable = "typeof(message) <> 'text' OR typeof(topic) <> 'text' OR typeof(lasting) <> 'integer'"
        if broken or self._ask(f"SELECT 1 FROM failed WHERE {unreadable}"):  # noqa: S608 - a constant
            keys = [(key,) for key in broken]
            with self._transaction():
                self._database.execute(f"DELETE FROM failed WHERE {unreadable}")  # noqa: S608
                self._database.executemany("DELETE FROM coefficients WHERE session = ?", keys)
                self._database.executemany("DELETE FROM sessions WHERE id = ?", keys)
        return set(broken.values())

    def save(self, log: LogFile, settings: BatchSettings, worked: Worked) -> None:
        """Keep what came of a log, all of it or nothing."""
        key = settings.key()
        with self._transaction():
            self._database.execute("INSERT OR IGNORE INTO settings VALUES (?, ?)", (key, settings.text()))
            self._database.execute("DELETE FROM failed WHERE settings = ? AND place = ?", (key, encodable(log.place)))
            if worked.sha256:
                self._database.execute("DELETE FROM failed WHERE settings = ? AND sha256 = ?", (key, worked.sha256))
                self.remember(log, worked.sha256)
            for session in worked.sessions:
                self._save_session(session, key)
            for fault in worked.faults:
                own = (fault.topic, worked.sha256, log.path, fault.message, fault.lasting, fault.detail)
                values = (encodable(log.place), key, *own)
                self._database.execute("INSERT OR REPLACE INTO failed VALUES (?, ?, ?, ?, ?, ?, ?, ?)", values)

    def sessions(self, hashes: Iterable[str], settings: str) -> dict[str, tuple[Session, ...]]:
        """Return what is known of logs, by the hash of their content; of several arms in the order of their topics."""
        found: dict[str, tuple[Session, ...]] = defaultdict(tuple)
        for row in self._of_logs("sessions", hashes, settings):
            found[row["sha256"]] += (_session(json.loads(row["content"])),)
        return dict(found)

    def faults(self, hashes: Iterable[str], settings: str) -> dict[str, tuple[Fault, ...]]:
        """Return what is lastingly wrong with logs, by the hash of their content."""
        found: dict[str, dict[str, Fault]] = defaultdict(dict)
        for row in self._of_logs("failed", hashes, settings):
            if row["lasting"]:
                found[row["sha256"]][row["topic"]] = Fault(message=row["message"], topic=row["topic"])
        return {sha256: tuple(faults.values()) for sha256, faults in found.items()}

    def _of_logs(self, table: str, hashes: Iterable[str], settings: str) -> Iterator[sqlite3.Row]:
        """Yield the rows of logs, a few logs at a time; values never become part of a query."""
        every = tuple(dict.fromkeys(hashes))
        for first in range(0, len(every), AT_ONCE):
            some = every[first : first + AT_ONCE]
            where = f"settings = ? AND sha256 IN ({', '.join('?' * len(some))})"
            yield from self._ask(f"SELECT * FROM {table} WHERE {where} ORDER BY topic", (settings, *some))  # noqa: S608

    def name_sessions(self, named: Iterable[Session], settings: str) -> None:
        """Write which arm sessions are of, and when they were, with their numbers."""
        query = """UPDATE sessions SET path = :path, robot = :robot, start_s = :start
            WHERE sha256 = :sha256 AND settings = :settings AND topic = :topic
            AND (path, robot, start_s) IS NOT (:path, :robot, :start)"""
        values = [
            {"path": one.path, "robot": one.robot, "start": one.start_s, "sha256": one.sha256, "topic": one.topic}
            | {"settings": settings}
            for one in named
        ]
        with self._transaction():
            self._database.executemany(query, values)

    def note(self, key: str) -> str | None:
        """Return a note about the ledger as a whole."""
        found = self._ask("SELECT value FROM meta WHERE key = ?", (key,))
        return str(found[0]["value"]) if found else None

    def write_note(self, key: str, value: str) -> None:
        """Keep a note about the ledger as a whole."""
        with self._worded():
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
            for table in TABLES:
                self._database.execute(table)
            self._database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            self._database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")

    def _check(self) -> None:
        """Refuse a file in which SQLite finds faults."""
        said = [str(row[0]) for row in self._ask("PRAGMA quick_check(3)")]
        if said != ["ok"]:
            raise InputError(f"{self.path}: a damaged ledger ({'; '.join(said)}); {OTHER_PLACE}")

    def _pragma(self, name: str) -> int:
        return int(self._database.execute(f"PRAGMA {name}").fetchone()[0])

    def _save_session(self, session: Session, settings: str) -> None:
        content = json.dumps(asdict(session), default=list, ensure_ascii=False)
        names = (None, session.sha256, settings, session.topic, session.path, session.robot, session.start_s)
        query = "INSERT OR IGNORE INTO sessions VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"
        cursor = self._database.execute(query, (*names, content, _digest(content)))
        if cursor.rowcount:  # else another run was faster
            rows = [
                (cursor.lastrowid, joint.joint, name, one.value, one.low, one.high)
                for joint in session.joints
                for name, one in joint.coefficients.items()
            ]
            self._database.executemany("INSERT OR REPLACE INTO coefficients VALUES (?, ?, ?, ?, ?, ?)", rows)

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


def _digest(content: object) -> str:
    """Return the hash by which a changed or damaged session is known."""
    return hashlib.sha256(str(content).encode("utf-8", "surrogateescape")).hexdigest()


def _session(held: dict[str, Any]) -> Session:
    """Return what was kept, as the log says it."""
    held["warnings"] = tuple(one if isinstance(one, str) else Caution(**one) for one in held["warnings"])
    held |= {"codes": tuple(held["codes"]), "conditions": Conditions(**held["conditions"])}
    for joint in held["joints"]:
        joint |= {name: tuple(joint[name]) for name in ("speed_rad_s", "effects")}
        for key in ("coefficients", "within"):
            joint[key] = {name: Coefficient(**one) for name, one in joint[key].items()}
        joint["curve"] = SpeedCurve(**joint["curve"])
    held["joints"] = tuple(JointSummary(**joint) for joint in held["joints"])
    return Session(**held)
