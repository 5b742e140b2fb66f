"""Recorded <-> rows of the ledger's tables; NaN is NULL there, lists are JSON."""

import hashlib
import json
import math
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from friction_audit.batch.identity import Recorded
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.friction.history import UNDETERMINED, Coefficient

Row = tuple[Any, ...]
Stored = sqlite3.Row | Mapping[str, Any]

SESSION_COLUMNS = (
    "sha256", "settings", "topic", "path", "robot", "start_s", "start_from", "duration_s", "drive", "torque", "gravity",
    "inertia", "payload", "rate_hz", "temperature_c", "note", "kind", "told_robot", "told_by_serial", "told_start_s",
    "damaged", "warnings", "codes",
)  # fmt: skip
JOINT_COLUMNS = (
    "session", "joint", "name", "cycles", "moving_s", "speed_low_rad_s", "speed_median_rad_s", "speed_high_rad_s",
    "temperature_c", "reason", "verdict", "effects", "curve",
)  # fmt: skip
COEFFICIENT_COLUMNS = (
    "session", "joint", "coefficient", "value", "low", "high", "within_value", "within_low", "within_high",
)  # fmt: skip
# Columns of a session that are written anew with every manifest; nothing is read from them.
NAMED = {"path", "robot", "start_s", "start_from", "payload", "temperature_c", "note"}
CONTENT = tuple(column for column in SESSION_COLUMNS if column not in NAMED)


def insert(table: str, columns: Sequence[str]) -> str:
    """Return the statement that inserts a row, unless it is there already."""
    marks = ", ".join("?" * len(columns))
    return f"INSERT OR IGNORE INTO {table} ({', '.join(columns)}) VALUES ({marks})"  # noqa: S608 - names of this module


def session_row(recorded: Recorded, settings: str) -> Row:
    """Return the row of a session, its name and start as the log tells them."""
    session, conditions = recorded.session, recorded.session.conditions
    return (
        session.sha256, settings, recorded.topic, session.path, session.robot, session.start_s, session.start_from,
        session.duration_s, conditions.drive, conditions.torque, conditions.gravity, conditions.inertia,
        conditions.payload, conditions.rate_hz, session.temperature_c, session.note, recorded.kind, session.robot,
        recorded.named_by_serial, session.start_s, session.damaged, _list_text(session.warnings),
        _list_text(session.codes),
    )  # fmt: skip


def joint_rows(key: int, joints: Iterable[JointSummary]) -> Iterator[Row]:
    """Yield a row for each joint of a session."""
    for joint in joints:
        speeds = tuple(map(_number, joint.speed_rad_s))
        temperature = None if joint.temperature_c is None else _number(joint.temperature_c)
        yield (
            key, joint.joint, joint.name, joint.cycles, joint.moving_s, *speeds, temperature, joint.reason,
            joint.verdict, _list_text(joint.effects), _curve_text(joint.curve),
        )  # fmt: skip


def coefficient_rows(key: int, joints: Iterable[JointSummary]) -> Iterator[Row]:
    """Yield a row for each coefficient of each joint of a session."""
    for joint in joints:
        for name, estimate in joint.coefficients.items():
            within = joint.within.get(name, UNDETERMINED)
            numbers = (estimate.value, estimate.low, estimate.high, within.value, within.low, within.high)
            yield (key, joint.joint, name, *map(_number, numbers))


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
        conditions=Conditions(
            drive=row["drive"],
            torque=row["torque"],
            gravity=row["gravity"],
            inertia=row["inertia"],
            rate_hz=row["rate_hz"],
        ),
        joints=tuple(_joint_from(joint, coefficients.get(joint["joint"], ())) for joint in joints),
        warnings=tuple(json.loads(row["warnings"])),
        codes=tuple(json.loads(row["codes"])),
        damaged=bool(row["damaged"]),
    )
    return Recorded(session=session, topic=row["topic"], kind=row["kind"], named_by_serial=bool(row["told_by_serial"]))


def digest_of(row: Stored, joints: Iterable[Stored], coefficients: Iterable[Stored]) -> str:
    """Return the hash of all that is stored of a session, by which a changed or damaged row is known."""
    stored = [
        [row[column] for column in CONTENT],
        *([joint[column] for column in JOINT_COLUMNS[1:]] for joint in joints),
        *([one[column] for column in COEFFICIENT_COLUMNS[1:]] for one in coefficients),
    ]
    return hashlib.sha256(json.dumps(stored, default=repr).encode()).hexdigest()


def _joint_from(row: sqlite3.Row, coefficients: Sequence[sqlite3.Row]) -> JointSummary:
    return JointSummary(
        joint=row["joint"],
        name=row["name"],
        coefficients={one["coefficient"]: _coefficient(one, "") for one in coefficients},
        cycles=row["cycles"],
        moving_s=row["moving_s"],
        speed_rad_s=tuple(_or_nan(row[f"speed_{name}_rad_s"]) for name in ("low", "median", "high")),  # type: ignore[arg-type]
        temperature_c=row["temperature_c"],
        within={one["coefficient"]: _coefficient(one, "within_") for one in coefficients},
        curve=SpeedCurve(**json.loads(row["curve"])),
        reason=row["reason"],
        verdict=row["verdict"],
        effects=tuple(json.loads(row["effects"])),
    )


def _coefficient(row: sqlite3.Row, prefix: str) -> Coefficient:
    return Coefficient(**{name: _or_nan(row[f"{prefix}{name}"]) for name in ("value", "low", "high")})


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def _list_text(items: Sequence[str]) -> str:
    return json.dumps(list(items), ensure_ascii=False)


def _curve_text(curve: SpeedCurve) -> str:
    return json.dumps({f.name: list(getattr(curve, f.name)) for f in fields(curve)}, separators=(",", ":"))


APPLICATION_ID = 0x46414C47  # "FALG" in the head of the file: an SQLite database without it is not a ledger
SCHEMA_VERSION = 3  # in user_version; raised with every change below
TABLES = (
    "CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, text TEXT NOT NULL)",
    """CREATE TABLE IF NOT EXISTS files (
        place TEXT PRIMARY KEY, size INTEGER NOT NULL, changed TEXT NOT NULL, sha256 TEXT NOT NULL)""",
    "CREATE INDEX IF NOT EXISTS files_by_size ON files (size)",
    """CREATE TABLE IF NOT EXISTS sessions (
        id INTEGER PRIMARY KEY, sha256 TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL,
        path TEXT NOT NULL, robot TEXT NOT NULL, start_s REAL, start_from TEXT NOT NULL, duration_s REAL NOT NULL,
        drive TEXT NOT NULL, torque TEXT NOT NULL, gravity TEXT NOT NULL, inertia TEXT NOT NULL,
        payload TEXT NOT NULL, rate_hz REAL NOT NULL, temperature_c REAL, note TEXT NOT NULL,
        kind TEXT NOT NULL, told_robot TEXT NOT NULL, told_by_serial INTEGER NOT NULL, told_start_s REAL,
        damaged INTEGER NOT NULL, warnings TEXT NOT NULL, codes TEXT NOT NULL DEFAULT '[]',
        digest TEXT NOT NULL DEFAULT '', UNIQUE (sha256, settings, topic))""",
    "CREATE INDEX IF NOT EXISTS sessions_by_settings ON sessions (settings)",
    """CREATE TABLE IF NOT EXISTS joints (
        session INTEGER NOT NULL REFERENCES sessions (id), joint INTEGER NOT NULL, name TEXT NOT NULL,
        cycles INTEGER NOT NULL, moving_s REAL NOT NULL, speed_low_rad_s REAL, speed_median_rad_s REAL,
        speed_high_rad_s REAL, temperature_c REAL, reason TEXT NOT NULL, verdict TEXT, effects TEXT NOT NULL,
        curve TEXT NOT NULL, PRIMARY KEY (session, joint)) WITHOUT ROWID""",
    """CREATE TABLE IF NOT EXISTS coefficients (
        session INTEGER NOT NULL REFERENCES sessions (id), joint INTEGER NOT NULL, coefficient TEXT NOT NULL,
        value REAL, low REAL, high REAL, within_value REAL, within_low REAL, within_high REAL,
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
