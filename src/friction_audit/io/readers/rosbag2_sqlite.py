"""The sqlite3 storage of a ROS 2 bag, also where pages are broken or cut off.

Of a file that is cut off a copy is made that SQLite opens, with the tree of the messages' table made anew; for the
layout of pages and records see https://www.sqlite.org/fileformat2.html.
"""

import re
import shutil
import sqlite3
import struct
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from functools import reduce
from io import SEEK_END
from itertools import count, islice, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO

from friction_audit.errors import InputError
from friction_audit.io.readers.message_stream import (
    Block,
    BrokenError,
    Connection,
    MessageStream,
    Window,
    block_of_payloads,
    open_log,
    unpack,
)

SQLITE_MAGIC = b"SQLite format 3\x00"
HEADER_BYTES, LARGEST_PAGE = 100, 65_536
_PAGES = slice(28, 32)
_LOCK_BYTE = 1 << 30  # its page is never used
_VARINT = rb"[\x80-\xff]{0,7}[\0-\x7f]"
# Length and id of a message, length of its header, type of the id, of topic_id and timestamp, and of the data.
_MESSAGE = re.compile(_VARINT + b"(" + _VARINT + rb")[\x05-\x0c]\0[\1-\6\x08\x09]{2}" + _VARINT, re.DOTALL)


def stated_bytes(header: bytes) -> int:
    """Return how long an SQLite file is by its header, 0 if the header does not say."""
    page = int.from_bytes(header[16:18], "big")
    stated = len(header) == HEADER_BYTES and header[24:28] == header[92:96]
    return (LARGEST_PAGE if page == 1 else page) * int.from_bytes(header[_PAGES], "big") if stated else 0


def copy_of_cut(path: Path, stack: ExitStack) -> Path | None:
    """Return a copy of a database that is cut off, its header corrected; None if whole.

    SQLite refuses a file that is shorter than its header says; of the copy it refuses the missing pages alone.
    """
    with open_log(path) as file:
        header = file.read(HEADER_BYTES)
    size, stated = path.stat().st_size, stated_bytes(header)
    if not header.startswith(SQLITE_MAGIC) or size >= stated:
        return None
    page = stated // int.from_bytes(header[_PAGES], "big")
    copy = Path(stack.enter_context(TemporaryDirectory())) / path.name
    try:
        shutil.copyfile(path, copy)
        with copy.open("r+b") as file:
            file.truncate(size // page * page)
            file.seek(_PAGES.start)
            file.write(bytes(4))  # SQLite then goes by the size of the file
    except OSError as error:
        raise InputError(
            f"{path}: is cut off, and there is no room in {copy.parent} for the copy from which it is saved "
            f"({error.strerror}); set TMPDIR to a larger place"
        ) from error
    return copy


def rebuild_tree(file: BinaryIO, header: bytes, root: int) -> None:
    """Write the interior pages of the table of messages anew, over those of its leaf pages that are there.

    SQLite begins an interior page when there are hundreds of leaf pages already, so that it may lie after the cut.
    """
    size = stated_bytes(header) // int.from_bytes(header[_PAGES], "big")
    pages = file.seek(0, SEEK_END) // size
    usable = size - header[20]
    most = (usable - 12) // (12 + 2)  # a header, and for each cell its place of two bytes
    level = _leaves(file, size, pages, root, int.from_bytes(header[32:36], "big"))
    spare = (number for number in count(pages + 1) if number != _LOCK_BYTE // size + 1)
    while len(level) > 1:
        groups, parents = -(-len(level) // most), []
        for begin, end in pairwise([len(level) * group // groups for group in range(groups + 1)]):
            *left, (last, right) = level[begin:end]
            keys = ([key >> shift & 0x7F | (shift > 0) << 7 for shift in range(49, -1, -7)] for key, _ in left)
            cells = b"".join(struct.pack(">I8B", child, *key) for (_, child), key in zip(left, keys, strict=True))
            start = usable - len(cells)
            head = struct.pack(f">BHHHBI{len(left)}H", 5, 0, len(left), start, 0, right, *range(start, usable, 12))
            parents.append((last, root if groups == 1 else next(spare)))
            file.seek((parents[-1][1] - 1) * size)
            file.write((head.ljust(start, b"\0") + cells).ljust(size, b"\0"))
        level = parents


def _leaves(file: BinaryIO, size: int, pages: int, root: int, trunk: int) -> list[tuple[int, int]]:
    """Return the last id and the number of each leaf page of the table of messages, unless the root is one."""

    def page(number: int) -> bytes:
        file.seek((number - 1) * size)
        return file.read(size)

    if not 1 < root <= pages or _ids_on(page(root)):
        return []
    free: set[int] = set()
    while 0 < trunk <= pages and trunk not in free:  # the list of free pages, which may hold deleted messages
        free.add(trunk)
        trunk, listed, *numbers = struct.unpack(f">{size // 4}I", page(trunk))
        free.update(number for number in numbers[:listed] if number <= pages)
    found = ((*ids, number) for number in range(1, pages + 1) if number not in free and (ids := _ids_on(page(number))))
    leaves = [(-1, 0)]
    for last, first, number in sorted(found):  # by their last id, so that a page with wrong ids displaces one at most
        if first > leaves[-1][0]:
            leaves.append((last, number))
    return leaves[1:]


def _ids_on(page: bytes) -> tuple[int, int] | None:
    """Return the last and the first id on a leaf page of messages; None if it is another, or a cell is no message."""
    places = page[8 : 8 + 2 * int.from_bytes(page[3:5], "big")] if page.startswith(b"\x0d") else b""
    cells = [_MESSAGE.match(page, place) for (place,) in struct.iter_unpack(">H", places)]
    ids = [reduce(lambda number, byte: number << 7 | byte & 0x7F, cell[1], 0) for cell in cells if cell]
    sound = 0 < len(ids) == len(cells) and all(first < second for first, second in pairwise(ids))
    return (ids[-1], ids[0]) if sound else None


# What sqlite3 raises on a broken database; the second where the name of a broken thing is part of the message.
_DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_MESSAGES_PER_BLOCK = 1024  # larger ones wake the garbage collector, which doubles the time
_LARGEST_MESSAGE = 1 << 20  # the state of a thousand joints takes 50 kB; a message of a gigabyte is a bomb [byte]
# One lost page of the tree is missed by up to 7 000 messages; after more in a row, the rest is lost.
_MOST_BROKEN_IDS = 10_000
_LAST_ID = 2**63 - 1

Row = tuple[int, int, bytes]  # id, time stamp and content of a message


class Sqlite3Stream(MessageStream):
    """The messages in one sqlite3 storage file."""

    def __init__(self, path: Path, database: Path | None = None) -> None:
        """Read topics, definitions and message counts; ``database`` is a copy that can be opened of a cut-off file."""
        super().__init__(path)
        self._database = database or path
        self._last_sound = _LAST_ID
        with open_log(path, SQLITE_MAGIC, "an SQLite file") as file:
            header = SQLITE_MAGIC + file.read(HEADER_BYTES - len(SQLITE_MAGIC))
        if database is not None:
            self._note(self._bytes, "the file is cut off there", stated_bytes(header))
        try:
            if database is not None:
                query = "SELECT CAST(rootpage AS INTEGER) FROM sqlite_master WHERE type = 'table' AND name = 'messages'"
                with closing(self._connect()) as opened, database.open("r+b") as file:
                    rebuild_tree(file, header, *(opened.execute(query).fetchone() or (0,)))
            with closing(self._connect()) as opened:
                self.connections = self._read_connections(opened)
        except _DATABASE_ERRORS as error:
            raise self._broken(error) from error

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
                    self._note(None, f"{error}; the messages on whole pages were read")
            else:
                return
        self._last_sound = at - broken - 1

    def _block(self, key: int, rows: Sequence[Row]) -> Block | None:
        """Join messages; what is no time stamp with bytes, or cannot be decompressed, is left out."""
        with suppress(TypeError, AttributeError, ValueError, OverflowError):  # the rows are then looked at one by one
            if not rows[0][2].startswith(_ZSTD_MAGIC):
                return block_of_payloads(key, [time for _, time, _ in rows], [data for _, _, data in rows])
        sound = [(time, own) for _, time, data in rows if isinstance(time, int) and (own := _message(data)) is not None]
        if len(sound) < len(rows):
            self._note(None, "messages without time stamp or bytes, or with broken compression, were left out")
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
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        known = database.execute(query) if "message_definitions" in tables else ()
        definitions = {name: (str(language), str(text).encode()) for name, language, text in known}
        topics = database.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
        counts = self._count_messages(database, [key for key, *_ in topics])
        return tuple(
            Connection(
                key=key,
                topic=str(topic),
                type=str(typename),
                encoding=str(encoding),
                messages=counts.get(key, 0),
                definition=definitions.get(typename, ("", b"")),
            )
            for key, topic, typename, encoding in topics
        )

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
    """Return a message, decompressed if it was compressed: no CDR message begins as zstd does. None if it is broken."""
    if not isinstance(data, bytes) or not data.startswith(_ZSTD_MAGIC):
        return data if isinstance(data, bytes) else None
    from zstandard import ZstdError, frame_content_size

    try:
        size = frame_content_size(data)
        return unpack("zstd", data, _LARGEST_MESSAGE if size < 0 else size, cut=size < 0)
    except (BrokenError, ZstdError):
        return None
