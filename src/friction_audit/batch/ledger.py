"""Ledger: an SQLite file that keeps what came of every log, for ever, by its content and the settings.

Every log is one transaction, so that a run that is killed at any moment loses nothing that was finished, and runs side
by side on one ledger only find each other's work done.
"""

import hashlib
import json
import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from importlib.resources import files
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import Fault, Worked
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.errors import InputError, encodable
from friction_audit.friction.history import Coefficient
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import ReadOptions
from friction_audit.pipeline import AuditSettings
from friction_audit.preprocessing.interaction import Caution

if TYPE_CHECKING:
    from friction_audit.diagnosis.settings import DiagnosisSettings

RESULTS_VERSION = 18  # raised with every change after which the same log gives other numbers: ledgers compute anew
APPLICATION_ID = 0x46414C47  # "FALG" in the head of the file: an SQLite database without it is not a ledger
SCHEMA_VERSION = 7  # in user_version; raised with every change of ledger.sql
REMEMBER = "INSERT OR REPLACE INTO files VALUES (?, ?, ?, ?)"
BUSY_S = 60.0  # to wait while another run writes
PARTS = ("", "-wal", "-shm")  # endings of the files that a ledger consists of while it is open
UNCLEAN = ("-wal", "-journal")  # what lies next to a ledger that is open or was not closed
AT_ONCE = 50  # keys per query: SQLite takes no more than a thousand, and rows take memory
OTHER_PLACE = "choose another folder with -o, or --rebuild to move it aside and compute again"


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSettings:
    """What is done with each log of a batch."""

    audit: AuditSettings = field(default_factory=AuditSettings)  # the chain
    reading: ReadOptions = field(default_factory=ReadOptions)  # how logs are read
    diagnosis: "DiagnosisSettings | None" = None  # what is asked of a diagnosis, or None for none

    def text(self) -> str:
        """Return all that the numbers depend on, apart from the log, as JSON in a fixed order."""
        # An arm's URDF may be written again under its name: its content counts.
        return json.dumps(
            {"results": RESULTS_VERSION, **asdict(self)},
            sort_keys=True,
            default=lambda one: f"sha256 {sha256_of(one)}" if isinstance(one, Path) else str(one),
        )

    def key(self) -> str:
        """Return the fingerprint of the settings."""
        return hashlib.sha256(self.text().encode()).hexdigest()[:16]


class Ledger(AbstractContextManager["Ledger"]):
    """The sessions that are known; the file is made if it is not there."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.older: Path | None = None  # where a ledger of an older schema is kept now, if there was one
        unclean = any(path.with_name(path.name + ending).exists() for ending in UNCLEAN)
        self._open()
        try:
            is_ledger = self._ask("PRAGMA application_id")[0][0] == APPLICATION_ID
            if is_ledger and self._ask("PRAGMA user_version")[0][0] < SCHEMA_VERSION:
                self._database.close()  # its sessions are of older results, which are never asked for again
                self.older = move_aside(path)
                self._open()
            with self._whole():
                self._set_up(unclean=unclean)
        except BaseException:
            self._database.close()
            raise

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(self.path, timeout=BUSY_S, isolation_level="IMMEDIATE")
        except (OSError, sqlite3.Error) as error:
            raise InputError(f"{self.path}: cannot be opened: {error}; choose another folder with -o") from error
        self._database.row_factory = sqlite3.Row
        # A broken row must not hide the others.
        self._database.text_factory = lambda content: content.decode("utf-8", "surrogateescape")

    def __exit__(self, *_: object) -> None:
        self._database.close()  # nothing is written here that was not safe before

    def known_hashes(self, logs: Iterable[LogFile]) -> dict[str, str]:
        """Return the hashes of logs that have not changed since they were last looked at, by the places of the logs."""
        query = "SELECT sha256 FROM files WHERE place = ? AND size = ? AND changed = ?"
        found = {log.place: self._ask(query, (encodable(log.place), log.size, log.changed)) for log in logs}
        return {place: str(rows[0][0]) for place, rows in found.items() if rows}

    def hashes(self, logs: Sequence[LogFile]) -> dict[str, str]:
        """Return the hash of each log that is known or as large as another, by its place; workers hash the others."""
        known = self.known_hashes(logs)
        strange = [log for log in logs if log.place not in known and "://" not in log.place]
        sizes = {row["size"] for row in self._ask("SELECT DISTINCT size FROM files")}
        of_size = Counter(log.size for log in strange)
        familiar = [log for log in strange if log.size in sizes or of_size[log.size] > 1]
        with ThreadPoolExecutor(thread_name_prefix="sha256") as pool:
            for log, hashed in [(log, pool.submit(sha256_of, Path(log.place))) for log in familiar]:
                with suppress(OSError):  # the worker will say why
                    known[log.place] = hashed.result()
                    self._ask(REMEMBER, (encodable(log.place), log.size, log.changed, known[log.place]))
        return known

    def is_done(self, sha256: str, settings: str) -> bool:
        """Return True if nothing new would come of a log."""
        query = "SELECT COUNT(*) AND NOT TOTAL(again) FROM arms WHERE sha256 = ? AND settings = ?"
        return bool(self._ask(query, (sha256, settings))[0][0])

    def forget_broken(self, hashes: Iterable[str], settings: str) -> set[str]:
        """Remove what is not as it was written; return the hashes of the logs it came of."""
        stored = self._of_logs(hashes, settings)
        broken = {row["id"]: str(row["sha256"]) for row in stored if row["digest"] != digest_of(row["content"])}
        if broken:
            keys = [(key,) for key in broken]
            with self._whole():
                self._database.executemany("DELETE FROM coefficients WHERE arm = ?", keys)
                self._database.executemany("DELETE FROM arms WHERE id = ?", keys)
        return set(broken.values())

    def save(self, log: LogFile, settings: BatchSettings, worked: Worked) -> None:
        """Keep what came of a log, all of it or nothing."""
        key, place = settings.key(), encodable(log.place)
        with self._whole():
            self._database.execute("INSERT OR IGNORE INTO settings VALUES (?, ?)", (key, settings.text()))
            query = "DELETE FROM arms WHERE settings = ? AND sha256 IN (?, ?) AND message IS NOT NULL"
            self._database.execute(query, (key, worked.sha256, place))
            if worked.sha256:
                self._database.execute(REMEMBER, (place, log.size, log.changed, worked.sha256))
            every: tuple[Session | Fault, ...] = (*worked.sessions, *worked.faults)
            for one in every:
                self._save_arm(one, (worked.sha256 or place, key, one.topic, log.path))

    def known(self, hashes: Iterable[str], settings: str) -> dict[str, Worked]:
        """Return what lastingly came of logs, by the hash of their content; arms in the order of their topics."""
        found: dict[str, Worked] = {}
        for row in self._of_logs(hashes, settings):
            held, had = json.loads(row["content"]), found.get(row["sha256"], Worked(sha256=row["sha256"]))
            if "message" not in held:
                found[had.sha256] = replace(had, sessions=(*had.sessions, _session(held)))
            elif held["lasting"]:
                found[had.sha256] = replace(had, faults=(*had.faults, Fault(**held)))
        return found

    def _of_logs(self, hashes: Iterable[str], settings: str) -> Iterator[sqlite3.Row]:
        """Yield the rows of logs, a few logs at a time; values never become part of a query."""
        every = tuple(dict.fromkeys(hashes))
        for first in range(0, len(every), AT_ONCE):
            some = every[first : first + AT_ONCE]
            where = f"settings = ? AND sha256 IN ({', '.join('?' * len(some))})"
            yield from self._ask(f"SELECT * FROM arms WHERE {where} ORDER BY topic", (settings, *some))  # noqa: S608

    def name_sessions(self, named: Iterable[Session], settings: str) -> None:
        """Write which arm sessions are of, and when they were, with their numbers."""
        query = """UPDATE arms SET path = ?1, robot = ?2, start_s = ?3
            WHERE sha256 = ?4 AND settings = ?5 AND topic = ?6 AND (path, robot, start_s) IS NOT (?1, ?2, ?3)"""
        values = [(one.path, one.robot, one.start_s, one.sha256, settings, one.topic) for one in named]
        with self._whole():
            self._database.executemany(query, values)

    def note(self, key: str) -> str | None:
        """Return a note about the ledger as a whole."""
        return next((str(row[0]) for row in self._ask("SELECT value FROM meta WHERE key = ?", (key,))), None)

    def write_note(self, key: str, value: str) -> None:
        """Keep a note about the ledger as a whole."""
        self._ask("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))

    def _set_up(self, *, unclean: bool) -> None:
        """Make the tables of an empty file; refuse a file that is something else, or in which SQLite finds faults."""
        ((version,),) = self._ask("PRAGMA user_version")
        holds_tables = bool(self._ask("SELECT 1 FROM sqlite_master LIMIT 1"))
        if holds_tables and self._ask("PRAGMA application_id")[0][0] != APPLICATION_ID:
            raise InputError(f"{self.path}: an SQLite database, but no ledger; {OTHER_PLACE}")
        if version > SCHEMA_VERSION:
            raise InputError(
                f"{self.path}: a ledger of schema {version}; this friction-audit knows {SCHEMA_VERSION}; use the newer "
                "one that made it, or --rebuild to move it aside and compute again"
            )
        said = [str(row[0]) for row in self._ask("PRAGMA quick_check(3)")] if unclean else ["ok"]
        if said != ["ok"]:
            raise InputError(f"{self.path}: a damaged ledger ({'; '.join(said)}); {OTHER_PLACE}")
        self._database.execute("PRAGMA journal_mode = WAL")
        self._database.execute("PRAGMA synchronous = NORMAL")
        if version == SCHEMA_VERSION:
            return
        with self._whole():
            self._database.execute("BEGIN IMMEDIATE")
            for statement in files(__package__).joinpath("ledger.sql").read_text(encoding="utf-8").split(";"):
                self._database.execute(statement)
            self._database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            self._database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")

    def _save_arm(self, one: Session | Fault, names: tuple[str, ...]) -> None:
        content = json.dumps(asdict(one), default=list, ensure_ascii=False)
        columns: tuple[object, ...] = (
            ("", None, one.message, not one.lasting)
            if isinstance(one, Fault)
            else (one.robot, one.start_s, None, False)
        )
        query = "INSERT OR IGNORE INTO arms VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
        cursor = self._database.execute(query, (*names, *columns, content, digest_of(content)))
        if cursor.rowcount and isinstance(one, Session):  # else another run was faster
            pairs = [(joint.joint, *pair) for joint in one.joints for pair in joint.coefficients.items()]
            rows = [(cursor.lastrowid, joint, name, c.value, c.low, c.high) for joint, name, c in pairs]
            self._database.executemany("INSERT OR REPLACE INTO coefficients VALUES (?, ?, ?, ?, ?, ?)", rows)

    def _ask(self, query: str, values: tuple[object, ...] = ()) -> list[sqlite3.Row]:
        with self._whole():
            return self._database.execute(query, values).fetchall()

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """Commit what is written in a ``with`` block, or nothing of it; turn an error of SQLite into an InputError."""
        try:
            with self._database:
                yield
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:  # the latter from damaged names of tables
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


def digest_of(content: object) -> str:
    """Return the hash by which changed or damaged content is known."""
    return hashlib.sha256(str(content).encode("utf-8", "surrogateescape")).hexdigest()


def _session(held: dict[str, Any]) -> Session:
    """Return what was kept, as the log says it."""
    held |= {"codes": tuple(held["codes"]), "conditions": Conditions(**held["conditions"])}
    held["warnings"] = tuple(Caution(**one) for one in held["warnings"])
    for joint in held["joints"]:
        joint |= {name: tuple(joint[name]) for name in ("speed_rad_s", "effects")}
        for key in ("coefficients", "within"):
            joint[key] = {name: Coefficient(**one) for name, one in joint[key].items()}
        joint |= {"curve": SpeedCurve(**joint["curve"]), "reason": tuple(Caution(**one) for one in joint["reason"])}
    held["joints"] = tuple(JointSummary(**joint) for joint in held["joints"])
    return Session(**held)
