"""The tables of a ledger, as any SQLite tool shows them; docs/commands/batch-report.md describes them."""

APPLICATION_ID = 0x46414C47
"""``FALG``, in the head of the file: an SQLite database without it is not a ledger."""
SCHEMA_VERSION = 2
"""In ``user_version``; raised with every change below."""

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
        damaged INTEGER NOT NULL, warnings TEXT NOT NULL,
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
