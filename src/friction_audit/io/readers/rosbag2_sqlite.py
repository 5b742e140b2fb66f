"""The sqlite3 storage of a ROS 2 bag; where pages are broken or cut off, without SQLite from the leaf pages.

For the layout of pages and records see https://www.sqlite.org/fileformat2.html.
"""

import re
import sqlite3
import struct
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from functools import cached_property, partial
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.message_stream import (
    LARGEST_MESSAGE,
    ZSTD_MAGIC,
    Block,
    Connection,
    MessageStream,
    Window,
)

_HEADER_BYTES, _LARGEST_PAGE = 100, 65_536
_VARINT = rb"[\x80-\xff]{0,7}[\0-\x7f]"
# Length and id of a message, length of its header, type of the id, of topic_id and timestamp, and of the data.
_MESSAGE = re.compile(
    b"(%b)(%b)([\x05-\x0c])\\0([\1-\6\x08\x09])([\1-\6\x08\x09])(%b)" % (_VARINT, _VARINT, _VARINT), re.DOTALL
)
_INTEGERS = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8, 8: 0, 9: 0}  # type of an integer -> its bytes; 8 means 0, 9 means 1


class _Leaves:
    """The messages on the leaf pages of a database."""

    def __init__(self, path: Path, header: bytes, page_bytes: int) -> None:
        self._pages = np.memmap(path, np.uint8, "r", shape=(path.stat().st_size // page_bytes, page_bytes))
        self._usable = page_bytes - header[20]
        self._numbers = list(self._in_order(int.from_bytes(header[32:36], "big")))

    def messages(self) -> Iterator[tuple[int, int, int, bytes]]:
        """Yield id, topic, time stamp and content."""
        for page in map(self._page, self._numbers):
            for cell in _messages_on(page):
                record, first = self._record(page, cell), cell[3][0]
                second = first + _INTEGERS[cell[4][0]]
                third = second + _INTEGERS[cell[5][0]]
                if len(record) == _number(cell[1]) == third + (_number(cell[6]) - 12) // 2:
                    topic = int.from_bytes(record[first:second], "big", signed=True) + (cell[4] == b"\x09")
                    time = int.from_bytes(record[second:third], "big", signed=True)
                    yield _number(cell[2]), topic, time, record[third:]

    def _page(self, number: int) -> bytes:
        return self._pages[number - 1].tobytes() if 0 < number <= len(self._pages) else b""

    def _in_order(self, trunk: int) -> Iterator[int]:
        """Yield the leaf pages of the table of messages in the order of ids, without free pages: deleted messages."""
        free, count = set[int](), len(self._pages)
        while 0 < trunk <= count and trunk not in free:
            free.add(trunk)
            trunk, listed, *numbers = struct.unpack(f">{self._pages.shape[1] // 4}I", self._page(trunk))
            free.update(numbers[:listed])
        pages = ((number, _messages_on(self._page(number))) for number in range(1, count + 1) if number not in free)
        ids = (([_number(cell[2]) for cell in cells], number) for number, cells in pages)
        sound = [(own[-1], own[0], n) for own, n in ids if own and all(one < other for one, other in pairwise(own))]
        before = -1
        for last, first, number in sorted(sound):  # by last ids, so that a page with wrong ids displaces one at most
            if first > before:
                before = last
                yield number

    def _record(self, page: bytes, cell: re.Match[bytes]) -> bytes:
        """Return a record, of which a page may hold the beginning; what is cut off is missing."""
        size, start, most, room = _number(cell[1]), cell.end(2), self._usable - 35, self._usable - 4
        least = (self._usable - 12) * 32 // 255 - 23
        local = least + (size - least) % room if size > most else size
        local = local if local <= most else least
        record, following = page[start : start + local], page[start + local : start + local + 4]
        for _ in range(-(-(min(size, LARGEST_MESSAGE) - local) // room)):
            more = self._page(int.from_bytes(following, "big"))
            record, following = record + more[4 : self._usable], more[:4]
        return record[:size]


def _number(varint: bytes) -> int:
    number = 0
    for byte in varint:
        number = number << 7 | byte & 0x7F
    return number


def _messages_on(page: bytes) -> list[re.Match[bytes]]:
    """Return the cells of a leaf page of messages; none if it is another, or a cell is no message."""
    places = page[8 : 8 + 2 * int.from_bytes(page[3:5], "big")] if page.startswith(b"\x0d") else b""
    cells = [_MESSAGE.match(page, place) for (place,) in struct.iter_unpack(">H", places)]
    return [cell for cell in cells if cell] if all(cells) else []


# What sqlite3 raises on a broken database; the second where the name of a broken thing is part of the message.
_DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)
_UTF_8 = 1  # of the encodings of texts: in another one, a blob is not the same as a text
_MESSAGES_PER_BLOCK = 1024  # from leaf pages; larger ones wake the garbage collector, which doubles the time
_FEWEST = 16  # messages that are read at a time
_MOST_RANGES = 4096  # of ids: where these are far apart, a range holds many of them
_LAST_ID = 2**63 - 1

# The next messages of a topic: one by one; and, which leaves the interpreter to the thread that decodes, joined to one
# result. The size is 0 where a message has no bytes (which SQLite sorts after texts and numbers) or no time.
_ONE_BY_ONE = (
    "SELECT rowid, timestamp, data FROM messages WHERE topic_id = ? AND rowid BETWEEN ? AND ? ORDER BY rowid LIMIT ?"
)
_JOINED = """
SELECT MAX(id), COUNT(*), MIN(size), CAST(GROUP_CONCAT(data, '') AS BLOB), GROUP_CONCAT(timestamp) FROM (
    SELECT rowid AS id, timestamp, data,
           LENGTH(data) * (data >= x'' AND CAST(timestamp AS INTEGER) = timestamp) AS size
    FROM messages WHERE topic_id = ? AND rowid BETWEEN ? AND ? ORDER BY id LIMIT ?
)"""

Row = tuple[int, int, bytes]  # id, time stamp and content of a message


class Sqlite3Stream(MessageStream):
    """The messages in one sqlite3 storage file."""

    magic, kind = b"SQLite format 3\x00", "an SQLite file"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with self._open() as file:
            self._header = self.magic + file.read(_HEADER_BYTES - len(self.magic))
        is_stated = len(self._header) == _HEADER_BYTES and self._header[24:28] == self._header[92:96]
        page = int.from_bytes(self._header[16:18], "big")
        self._page_bytes = _LARGEST_PAGE if page == 1 else page
        whole = self._page_bytes * int.from_bytes(self._header[28:32], "big") if is_stated else 0
        self._is_cut = self._bytes < whole
        if self._is_cut:
            self._note(self._bytes, "the file is cut off there", whole)
        try:
            with closing(self._connect()) as opened:
                self.connections = self._read_connections(opened)
        except _DATABASE_ERRORS as error:
            raise self._broken(error) from error

    @cached_property
    def _leaves(self) -> _Leaves:
        return _Leaves(self._path, self._header, self._page_bytes)

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some topics, one topic after the other."""
        try:
            with closing(self._connect()) as database:
                # Where a file is cut off, its index is broken too.
                ids = (0, _LAST_ID) if window is None or self._is_cut else _ids_in(database, window)
                for key in keys:
                    yield from self._on_leaves(key, *ids) if self._is_cut else self._in_tree(database, key, *ids)
        except _DATABASE_ERRORS as error:
            raise self._broken(error) from error

    def _in_tree(self, database: sqlite3.Connection, key: int, first: int, last: int) -> Iterator[Block]:
        """Yield the messages of a topic; those on broken pages are left out.

        SQLite gives the interpreter away: every other range of ids is read in a thread, by a connection of its own.
        """
        many = _FEWEST
        try:
            with closing(self._connect()) as other, ThreadPoolExecutor(max_workers=1) as pool:
                last = min(database.execute("SELECT MAX(rowid) FROM messages").fetchone()[0] or 0, last)
                while first <= last:
                    middle = first + max(many, (last - first) // _MOST_RANGES)
                    end = min(2 * middle - first - 1, last)
                    coming = pool.submit(list, self._lots(other, key, middle, end, many))
                    for lots in (partial(self._lots, database, key, first, min(middle - 1, last), many), coming.result):
                        for latest, block in lots():
                            first = latest + 1
                            if block is not None:
                                many = max(LARGEST_MESSAGE // int(block.size.max() + 1), _FEWEST)
                                yield block
        except _DATABASE_ERRORS as error:
            self._note(None, f"{error}; the messages on whole pages were read")
            yield from self._on_leaves(key, first, last)

    def _lots(
        self, database: sqlite3.Connection, key: int, first: int, last: int, many: int
    ) -> Iterator[tuple[int, Block | None]]:
        """Yield the messages of a topic, so many at a time, with the last id that was looked at."""
        while first <= last:
            lot = (key, first, last, many)
            latest, block = _joined(database, lot) if self._header[59] == _UTF_8 else (last, None)
            if block is None:
                rows = database.execute(_ONE_BY_ONE, lot).fetchall()
                latest, block = (rows[-1][0], self._block(key, rows)) if rows else (last, None)
            yield latest, block
            first = latest + 1

    def _on_leaves(self, key: int, first: int, last: int) -> Iterator[Block]:
        found = (one for one in self._leaves.messages() if one[1] == key and first <= one[0] <= last)
        while rows := [(row, time, data) for row, _, time, data in islice(found, _MESSAGES_PER_BLOCK)]:
            if block := self._block(key, rows):
                yield block

    def _connect(self) -> sqlite3.Connection:
        """Open without writing any file next to it, unless a journal of its own must be taken into account."""
        journal = self._path.with_name(f"{self._path.name}-wal")
        immutable = "" if journal.exists() and journal.stat().st_size else "&immutable=1"
        file = f"{self._path.resolve().as_uri()}?mode=ro{immutable}"
        database = sqlite3.connect(file, uri=True, check_same_thread=False)  # one thread after the other reads a block
        if self._is_cut:
            database.execute("PRAGMA writable_schema = ON")  # else SQLite refuses it
        database.text_factory = lambda text: text.decode(errors="replace")
        # No message is larger than its file, unless an expression in the table's definition makes it.
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(max(self._bytes, _LARGEST_PAGE), LARGEST_MESSAGE))
        return database

    def _broken(self, error: Exception | str) -> InputError:
        return InputError(
            f"{self._path}: the sqlite3 database cannot be read: {error}; nothing of it can be saved, since the list "
            "of its topics is broken or cut off; copy it again from where it was recorded"
        )

    def _read_connections(self, database: sqlite3.Connection) -> tuple[Connection, ...]:
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if missing := {"topics", "messages"} - tables:
            there = ", ".join(sorted(tables)) or "none"
            what = f"no table {' and no table '.join(sorted(missing))}; tables are {there}"
            raise InputError(f"{self._path}: {what}; expected the sqlite3 storage of a ROS 2 bag; choose another file")
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        known = database.execute(query) if "message_definitions" in tables else ()
        definitions = {name: (str(language), str(text).encode()) for name, language, text in known}
        topics = database.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
        counts = self._count_messages(database, [key for key, *_ in topics])
        return tuple(
            Connection(key, str(topic), str(kind), str(how), definitions.get(kind, ("", b"")), counts.get(key, 0))
            for key, topic, kind, how in topics
        )

    def _count_messages(self, database: sqlite3.Connection, keys: Sequence[int]) -> Mapping[int, int]:
        """Count the messages of each topic; of a single one by the index of time stamps, without reading them."""
        with suppress(*_DATABASE_ERRORS):
            if len(keys) == 1 and not self._is_cut:
                return {keys[0]: database.execute("SELECT COUNT(*) FROM messages").fetchone()[0]}
            if not self._is_cut:
                return dict(database.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id").fetchall())
        return Counter(topic for _, topic, *_ in self._leaves.messages())


def _joined(database: sqlite3.Connection, lot: tuple[int, ...]) -> tuple[int, Block | None]:
    """Return the last id of the next messages, and these, joined within SQLite; None where not all are equally long."""
    with suppress(sqlite3.DataError):  # together they are larger than a message may be
        last, count, size, data, times = database.execute(_JOINED, lot).fetchone()
        if size and len(data) == count * size and not data.startswith(ZSTD_MAGIC):
            log_time = np.fromstring(times, np.int64, sep=",")
            if len(log_time) == count:  # else some have none
                return last, Block(lot[0], log_time, data, size * np.arange(count), np.full(count, size))
    return 0, None


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
