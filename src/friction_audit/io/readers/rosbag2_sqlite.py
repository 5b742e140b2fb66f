"""The sqlite3 storage of a ROS 2 bag, also where pages are broken or cut off."""

import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Any

from friction_audit.errors import InputError
from friction_audit.io.readers.decompress import UnpackError, unpack
from friction_audit.io.readers.message_stream import Block, Connection, Damage, Window, block_of_payloads, open_log
from friction_audit.io.readers.sqlite_recovery import (
    HEADER_BYTES,
    LARGEST_PAGE,
    SQLITE_MAGIC,
    rebuild_tree,
    stated_bytes,
)

# What sqlite3 raises on a broken database; the second where the name of a broken thing is part of the message.
_DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_MESSAGES_PER_BLOCK = 1024  # larger ones wake the garbage collector, which doubles the time
_LARGEST_MESSAGE = 1 << 20  # the state of a thousand joints takes 50 kB; a message of a gigabyte is a bomb [byte]
# One lost page of the tree is missed by up to 7 000 messages; after more in a row, the rest is lost.
_MOST_BROKEN_IDS = 10_000
_LAST_ID = 2**63 - 1

Row = tuple[int, int, bytes]  # id, time stamp and content of a message


class Sqlite3Stream:
    """The messages in one sqlite3 storage file."""

    def __init__(self, path: Path, database: Path | None = None) -> None:
        """Read topics, definitions and message counts; ``database`` is a copy that can be opened of a cut-off file.

        InputError if this is no sqlite3 storage of a ROS 2 bag, or too little of it is left.
        """
        self._path = path
        self._database = database or path
        self._damage: dict[str, Damage] = {}
        self._last_sound = _LAST_ID
        with open_log(path) as file:
            header = file.read(HEADER_BYTES)
        if not header.startswith(SQLITE_MAGIC):
            raise InputError(
                f"{path}: {'does not begin as an SQLite file' if header else 'is empty'}; expected the sqlite3 storage "
                "of a ROS 2 bag; check the file's type and that it was copied whole"
            )
        self._bytes = path.stat().st_size
        if database is not None:
            self._note("the file is cut off there", self._bytes, stated_bytes(header))
        try:
            if database is not None:
                query = "SELECT CAST(rootpage AS INTEGER) FROM sqlite_master WHERE type = 'table' AND name = 'messages'"
                with closing(self._connect()) as opened, database.open("r+b") as file:
                    rebuild_tree(file, header, *(opened.execute(query).fetchone() or (0,)))
            with closing(self._connect()) as opened:
                self.connections = self._read_connections(opened)
        except _DATABASE_ERRORS as error:
            raise self._broken(error) from error

    @property
    def damage(self) -> tuple[Damage, ...]:
        """What was found broken so far."""
        return tuple(self._damage.values())

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some topics, one topic after the other."""
        try:
            with closing(self._connect()) as database:
                if self._database != self._path:
                    window = None  # where a file is cut off, its index is broken too
                ids = (0, _LAST_ID) if window is None else _ids_in(database, window)
                for key in keys:
                    for rows in self._rows(database, key, *ids):
                        if (block := self._block(key, rows)) is not None:
                            yield block
        except _DATABASE_ERRORS as error:
            raise self._broken(error) from error

    def _rows(self, database: sqlite3.Connection, key: int, first: int, last: int) -> Iterator[list[Row]]:
        """Yield id, time and content of the messages of a topic; those on broken pages are left out."""
        query = "SELECT rowid, timestamp, data FROM messages WHERE topic_id = ? AND rowid BETWEEN ? AND ?"
        try:
            cursor = database.execute(query, (key, first, min(last, self._last_sound)))
            while rows := cursor.fetchmany(_MESSAGES_PER_BLOCK):
                yield rows
                first = rows[-1][0] + 1
        except _DATABASE_ERRORS:
            walk = self._walk(database, "timestamp, CASE topic_id WHEN ? THEN data END", first, last, key)
            found = ((row, time, data) for row, topic, time, data in walk if topic == key)
            while rows := list(islice(found, _MESSAGES_PER_BLOCK)):
                yield rows

    def _walk(
        self, database: sqlite3.Connection, columns: str, at: int, last: int, *values: object
    ) -> Iterator[tuple[Any, ...]]:
        """Yield id, topic and these columns of each message that can be read, going on by id after each that cannot."""
        query = f"SELECT rowid, topic_id, {columns} FROM messages WHERE rowid BETWEEN ? AND ? ORDER BY rowid"  # noqa: S608
        broken = 0
        while broken < _MOST_BROKEN_IDS:
            try:
                for row in database.execute(query, (*values, at, min(last, self._last_sound))):
                    if row[0] < at:  # on a broken page ids may run back, and the walk would not end
                        raise sqlite3.DatabaseError("ids run back")
                    yield row
                    at, broken = row[0] + 1, 0
            except _DATABASE_ERRORS as error:
                at, broken = at + 1, broken + 1
                if self._database == self._path:
                    self._note(f"{error}; the messages on whole pages were read")
            else:
                return
        self._last_sound = at - broken - 1

    def _block(self, key: int, rows: Sequence[Row]) -> Block | None:
        """Join messages; what is no time stamp with bytes, or cannot be decompressed, is left out."""
        try:
            if not rows[0][2].startswith(_ZSTD_MAGIC):
                return block_of_payloads(key, [time for _, time, _ in rows], [data for _, _, data in rows])
        except (TypeError, AttributeError, ValueError, OverflowError):
            pass  # the rows are looked at one by one
        sound = [(time, own) for _, time, data in rows if isinstance(time, int) and (own := _message(data)) is not None]
        if len(sound) < len(rows):
            self._note("messages without time stamp or bytes, or with broken compression, were left out")
        return block_of_payloads(key, *zip(*sound, strict=True)) if sound else None

    def _connect(self) -> sqlite3.Connection:
        """Open without writing any file next to it, unless a journal of its own must be taken into account."""
        journal = self._path.with_name(f"{self._path.name}-wal")
        immutable = "" if journal.exists() and journal.stat().st_size else "&immutable=1"
        database = sqlite3.connect(f"{self._database.resolve().as_uri()}?mode=ro{immutable}", uri=True)
        database.text_factory = lambda text: text.decode(errors="replace")
        # No message is larger than its file, unless an expression in the table's definition makes it.
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(max(self._bytes, LARGEST_PAGE), _LARGEST_MESSAGE))
        return database

    def _note(self, reason: str, byte: int | None = None, whole: int | None = None) -> None:
        self._damage[reason] = Damage(byte, whole or self._bytes, reason)

    def _broken(self, error: Exception | str) -> InputError:
        return InputError(
            f"{self._path}: the sqlite3 database cannot be read: {error}; nothing of it can be saved, since the list "
            "of its topics is broken or cut off; copy it again from where it was recorded"
        )

    def _read_connections(self, database: sqlite3.Connection) -> tuple[Connection, ...]:
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if missing := {"topics", "messages"} - tables:
            raise InputError(
                f"{self._path}: no table {' and no table '.join(sorted(missing))}; expected the sqlite3 storage of a "
                f"ROS 2 bag; tables are {', '.join(sorted(tables)) or 'none'}"
            )
        definitions: dict[str, tuple[str, str]] = {}
        if "message_definitions" in tables:
            query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            definitions = {name: (language, text) for name, language, text in database.execute(query)}
        topics = database.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
        counts = self._count_messages(database, [key for key, *_ in topics])
        connections = []
        for key, topic, typename, encoding in topics:
            language, text = definitions.get(typename, ("", ""))
            connections.append(
                Connection(
                    key=key,
                    topic=str(topic),
                    type=str(typename),
                    encoding=str(encoding),
                    definition=str(text).encode(),
                    definition_format=str(language),
                    messages=counts.get(key, 0),
                )
            )
        return tuple(connections)

    def _count_messages(self, database: sqlite3.Connection, keys: Sequence[int]) -> Mapping[int, int]:
        """Count the messages of each topic; of a single one by the index of time stamps, without reading them."""
        try:
            if len(keys) == 1:
                return {keys[0]: database.execute("SELECT COUNT(*) FROM messages").fetchone()[0]}
            return dict(database.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id").fetchall())
        except _DATABASE_ERRORS:
            return Counter(topic for _, topic, _ in self._walk(database, "NULL", 0, _LAST_ID))


def _ids_in(database: sqlite3.Connection, window: Window) -> tuple[int, int]:
    """Return the first and the last id of the messages in a window, by the index of time stamps."""
    earliest, latest, first, last = database.execute(
        "SELECT (SELECT MIN(timestamp) FROM messages), (SELECT MAX(timestamp) FROM messages), MIN(rowid), MAX(rowid) "
        "FROM messages WHERE timestamp BETWEEN ? AND ?",
        (window.first, window.last),
    ).fetchone()
    if earliest is not None:
        window.before |= earliest < window.first
        window.after |= latest > window.last
        window.latest = max(window.latest, latest)
    return (1, 0) if first is None else (first, last)


def _message(data: object) -> bytes | None:
    """Return a message, decompressed if it was compressed by itself, or None if that cannot be done.

    No CDR message begins with the four bytes that every zstd frame begins with.
    """
    if not isinstance(data, bytes) or not data.startswith(_ZSTD_MAGIC):
        return data if isinstance(data, bytes) else None
    from zstandard import ZstdError, frame_content_size

    try:
        size = frame_content_size(data)
        return unpack("zstd", data, _LARGEST_MESSAGE if size < 0 else size, cut=size < 0)
    except (UnpackError, ZstdError):
        return None
