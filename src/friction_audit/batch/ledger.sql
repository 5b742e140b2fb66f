-- What came of an arm of a log, a session or a fault, is kept whole as JSON, which alone is read back. The other columns
-- are for people who open the file. A log that could not be read has its place as its hash.
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, text TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS files (
    place TEXT PRIMARY KEY, size INTEGER NOT NULL, changed TEXT NOT NULL, sha256 TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS files_by_size ON files (size);
CREATE TABLE IF NOT EXISTS arms (
    id INTEGER PRIMARY KEY, sha256 TEXT NOT NULL, settings TEXT NOT NULL, topic TEXT NOT NULL, path TEXT NOT NULL,
    robot TEXT NOT NULL, start_s REAL, message TEXT, again INTEGER NOT NULL, content TEXT NOT NULL,
    digest TEXT NOT NULL, UNIQUE (sha256, settings, topic));
CREATE TABLE IF NOT EXISTS coefficients (
    arm INTEGER NOT NULL, joint INTEGER NOT NULL, coefficient TEXT NOT NULL, value REAL, low REAL, high REAL,
    PRIMARY KEY (arm, joint, coefficient)) WITHOUT ROWID;
CREATE VIEW IF NOT EXISTS friction AS
    SELECT robot, datetime(start_s, 'unixepoch') AS start, path, joint, coefficient, value, low, high
    FROM arms JOIN coefficients ON arm = id ORDER BY robot, start_s, path, joint, coefficient;
