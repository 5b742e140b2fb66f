"""Recorded <-> rows of the ledger's tables; NaN is NULL there, lists are JSON."""

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from friction_audit.batch.identity import Recorded
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.preprocessing.interaction import Caution

Row = dict[str, Any]
CAUTION = ("code", "joint", "numbers")

APPLICATION_ID = 0x46414C47  # "FALG" in the head of the file: an SQLite database without it is not a ledger
SCHEMA_VERSION = 3  # in user_version; raised with every change below
COLUMNS = {
    "sessions": """sha256 TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL,
        path TEXT NOT NULL, robot TEXT NOT NULL, start_s REAL, start_from TEXT NOT NULL, duration_s REAL NOT NULL,
        drive TEXT NOT NULL, torque TEXT NOT NULL, gravity TEXT NOT NULL, inertia TEXT NOT NULL,
        payload TEXT NOT NULL, rate_hz REAL NOT NULL, temperature_c REAL, note TEXT NOT NULL,
        kind TEXT NOT NULL, told_robot TEXT NOT NULL, told_by_serial INTEGER NOT NULL, told_start_s REAL,
        damaged INTEGER NOT NULL, warnings TEXT NOT NULL, codes TEXT NOT NULL DEFAULT '[]'""",
    "joints": """session INTEGER NOT NULL REFERENCES sessions (id), joint INTEGER NOT NULL, name TEXT NOT NULL,
        cycles INTEGER NOT NULL, moving_s REAL NOT NULL, speed_low_rad_s REAL, speed_median_rad_s REAL,
        speed_high_rad_s REAL, temperature_c REAL, reason TEXT NOT NULL, verdict TEXT, effects TEXT NOT NULL,
        curve TEXT NOT NULL""",
    "coefficients": """session INTEGER NOT NULL REFERENCES sessions (id), joint INTEGER NOT NULL,
        coefficient TEXT NOT NULL, value REAL, low REAL, high REAL, within_value REAL, within_low REAL,
        within_high REAL""",
}
NAMES = {table: [column.split()[0] for column in columns.split(",")] for table, columns in COLUMNS.items()}
# Columns of a session that are written anew with every manifest; nothing is read from them.
NAMED = {"path", "robot", "start_s", "start_from", "payload", "temperature_c", "note"}
TABLES = (
    "CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, text TEXT NOT NULL)",
    """CREATE TABLE IF NOT EXISTS files (
        place TEXT PRIMARY KEY, size INTEGER NOT NULL, changed TEXT NOT NULL, sha256 TEXT NOT NULL)""",
    "CREATE INDEX IF NOT EXISTS files_by_size ON files (size)",
    f"""CREATE TABLE IF NOT EXISTS sessions (
        id INTEGER PRIMARY KEY, {COLUMNS["sessions"]},
        digest TEXT NOT NULL DEFAULT '', UNIQUE (sha256, settings, topic))""",
    "CREATE INDEX IF NOT EXISTS sessions_by_settings ON sessions (settings)",
    f"CREATE TABLE IF NOT EXISTS joints ({COLUMNS['joints']}, PRIMARY KEY (session, joint)) WITHOUT ROWID",
    f"""CREATE TABLE IF NOT EXISTS coefficients (
        {COLUMNS["coefficients"]}, PRIMARY KEY (session, joint, coefficient)) WITHOUT ROWID""",
    """CREATE TABLE IF NOT EXISTS failed (
        place TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL, sha256 TEXT NOT NULL, path TEXT NOT NULL,
        message TEXT NOT NULL, lasting INTEGER NOT NULL, detail TEXT NOT NULL,
        PRIMARY KEY (place, settings, topic)) WITHOUT ROWID""",
    "CREATE INDEX IF NOT EXISTS failed_by_content ON failed (sha256, settings)",
    """CREATE VIEW IF NOT EXISTS friction AS
        SELECT robot, datetime(start_s, 'unixepoch') AS start, path, joint, coefficient, value, low, high
        FROM sessions JOIN coefficients ON session = id ORDER BY robot, start_s, path, joint, coefficient""",
)


def insert(table: str) -> str:
    """Return the statement that inserts a row, unless it is there already."""
    names = NAMES[table]
    return f"INSERT OR IGNORE INTO {table} ({', '.join(names)}) VALUES (:{', :'.join(names)})"  # noqa: S608 - constants


def session_row(recorded: Recorded, settings: str) -> Row:
    """Return the row of a session, its name and start as the log tells them."""
    session, keys = recorded.session, {"settings": settings, "topic": recorded.topic, "kind": recorded.kind}
    known = {"told_robot": session.robot, "told_by_serial": recorded.named_by_serial, "told_start_s": session.start_s}
    lists = {name: _json(getattr(session, name)) for name in ("warnings", "codes")}
    return _held(session) | _held(session.conditions) | keys | known | lists


def joint_rows(key: int, joints: Iterable[JointSummary]) -> Iterator[Row]:
    """Yield a row for each joint of a session."""
    for joint in joints:
        speeds = zip(("speed_low_rad_s", "speed_median_rad_s", "speed_high_rad_s"), joint.speed_rad_s, strict=True)
        curve = {name: list(numbers) for name, numbers in _held(joint.curve).items()}
        lists = {"effects": _json(joint.effects), "curve": json.dumps(curve, separators=(",", ":"))}
        yield _held(joint) | dict(speeds) | lists | {"session": key}


def coefficient_rows(key: int, joints: Iterable[JointSummary]) -> Iterator[Row]:
    """Yield a row for each coefficient of each joint of a session."""
    for joint in joints:
        for name, estimate in joint.coefficients.items():
            within = {f"within_{part}": value for part, value in _held(joint.within.get(name, UNDETERMINED)).items()}
            yield _held(estimate) | within | {"session": key, "joint": joint.joint, "coefficient": name}


def recorded_from(
    row: sqlite3.Row, joints: Iterable[sqlite3.Row], coefficients: Mapping[int, Sequence[sqlite3.Row]]
) -> Recorded:
    """Return what the rows of a session say, as the log tells it."""
    session = Session(
        path=row["path"],
        sha256=row["sha256"],
        robot=row["told_robot"],
        start_s=row["told_start_s"],
        start_from="nothing" if row["told_start_s"] is None else "log",
        duration_s=row["duration_s"],
        conditions=Conditions(**{name: row[name] for name in ("drive", "torque", "gravity", "inertia", "rate_hz")}),
        joints=tuple(_joint_from(joint, coefficients.get(joint["joint"], ())) for joint in joints),
        warnings=tuple(
            one if isinstance(one, str) else Caution(**dict(zip(CAUTION, one, strict=True)))
            for one in json.loads(row["warnings"])
        ),
        codes=tuple(json.loads(row["codes"])),
        damaged=bool(row["damaged"]),
    )
    return Recorded(session=session, topic=row["topic"], kind=row["kind"], named_by_serial=bool(row["told_by_serial"]))


def digest_of(row: sqlite3.Row, joints: Iterable[sqlite3.Row], coefficients: Iterable[sqlite3.Row]) -> str:
    """Return the hash of all that is stored of a session, by which a changed or damaged row is known."""
    stored = [
        [row[column] for column in NAMES["sessions"] if column not in NAMED],
        *([joint[column] for column in NAMES["joints"][1:]] for joint in joints),
        *([one[column] for column in NAMES["coefficients"][1:]] for one in coefficients),
    ]
    return hashlib.sha256(json.dumps(stored, default=repr).encode()).hexdigest()


def _joint_from(row: sqlite3.Row, coefficients: Sequence[sqlite3.Row]) -> JointSummary:
    plain = ("joint", "name", "cycles", "moving_s", "temperature_c", "reason", "verdict")
    low, median, high = (_or_nan(row[f"speed_{name}_rad_s"]) for name in ("low", "median", "high"))
    return JointSummary(
        **{name: row[name] for name in plain},
        speed_rad_s=(low, median, high),
        coefficients={one["coefficient"]: _coefficient(one, "") for one in coefficients},
        within={one["coefficient"]: _coefficient(one, "within_") for one in coefficients},
        curve=SpeedCurve(**json.loads(row["curve"])),
        effects=tuple(json.loads(row["effects"])),
    )


def _coefficient(row: sqlite3.Row, prefix: str) -> Coefficient:
    return Coefficient(**{name: _or_nan(row[f"{prefix}{name}"]) for name in ("value", "low", "high")})


def _held(record: Any) -> Row:  # noqa: ANN401 - any dataclass
    return {one.name: getattr(record, one.name) for one in fields(record)}


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def _json(items: Sequence[str | Caution]) -> str:
    plain = [one if isinstance(one, str) else [getattr(one, name) for name in CAUTION] for one in items]
    return json.dumps(plain, ensure_ascii=False)
