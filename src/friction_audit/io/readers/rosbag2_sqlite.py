"""The sqlite3 storage of a ROS 2 bag: SQLite reads the list of topics, the messages come from the pages of their table.

For the layout of pages and records see https://www.sqlite.org/fileformat2.html.
"""

import mmap
import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from functools import cached_property
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

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
from friction_audit.joint_log import Bool, Int

_HEADER_BYTES, _LARGEST_PAGE = 100, 65_536
_INTERIOR, _LEAF = (5, 12), (13, 8)  # pages of a table: their first byte, length of their header
_DEEPEST = 20  # levels of a tree, as in SQLite
_LOT_BYTES = 1 << 20  # of pages that are looked at together, and of records that are joined together
_COLUMNS = ("topic_id", "timestamp", "data")
# Types of a value: nothing, integers, a float, 0 and 1 without a byte, two without use; then bytes and texts in turn.
_WIDTHS = np.array([0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0])
_ARE_INTEGERS = np.isin(np.arange(12), (1, 2, 3, 4, 5, 6, 8, 9))
_ZERO, _BYTES = 8, 12
_ZSTD = int.from_bytes(ZSTD_MAGIC, "big")
# What sqlite3 raises on a broken database; the second where the name of a broken thing is part of the message.
_DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)


class _Numbers:
    """Numbers at many places of some bytes at once; before the first place are eight other bytes."""

    def __init__(self, buffer: bytes | mmap.mmap) -> None:
        self.buffer, self._bytes = buffer, np.frombuffer(buffer, np.uint8)
        self._words = np.ndarray((len(buffer) - 7,), ">i8", buffer, strides=(1,))

    def signed(self, at: Int, width: Int | int) -> Int:
        """Return big-endian numbers of up to eight bytes."""
        word: Int = self._words[np.minimum(at + width - 8, len(self._words) - 1)]
        return word << 64 - 8 * width >> 64 - 8 * width

    def unsigned(self, at: Int, width: int) -> Int:
        """Return big-endian numbers of up to four bytes."""
        return self.signed(at, width) & ((1 << 8 * width) - 1)

    def varints(self, at: Int) -> tuple[Int, Int]:
        """Return numbers of up to eight bytes with seven bits each, and where they end."""
        value, end, more = np.zeros_like(at), at, np.ones(len(at), np.bool_)
        for _ in range(8):
            byte = self._bytes.take(end, mode="clip")
            value, end = np.where(more, value << 7 | byte & 0x7F, value), end + more
            more &= byte & 0x80 != 0
            if not more.any():
                break
        return value, end


class _Rows(NamedTuple):
    """Rows of the table of messages, an array of each value; places are those in the bytes of some numbers."""

    page: Int  # number of its page
    id: Int
    begin: Int  # where the record begins
    size: Int  # length of the record [byte]
    local: Int  # how much of it is on its page [byte]
    topic: Int  # -1 where other pages hold it
    time: Int  # [ns]
    start: Int  # where the content begins
    width: Int  # length of the content [byte]
    is_message: Bool  # False where the time is no integer, or the content no bytes
    is_sound: Bool  # False where the values do not add up to the record

    def take(self, chosen: Bool) -> "_Rows":
        return self if chosen.all() else _Rows._make(array[chosen] for array in self)


class _Pages:
    """The pages of a database on a map of its file."""

    def __init__(self, content: mmap.mmap, page_bytes: int, columns: Sequence[str]) -> None:
        self._map, self._numbers, self._page_bytes, self._columns = content, _Numbers(content), page_bytes, columns
        self._usable, self._count = page_bytes - content[20], len(content) // page_bytes

    def in_tree(self, root: int) -> Int | None:
        """Return the leaf pages of a table in the order of ids; None if a page above them is broken."""
        level = np.array([root])
        for _ in range(_DEEPEST):
            if ((level < 1) | (level > self._count)).any() or np.bincount(level).max() > 1:
                return None
            if {self._map[self._starts(level[end])] for end in (0, -1)} == {_LEAF[0]}:
                return level
            page, at, is_interior = self._cells(level, *_INTERIOR)
            if not is_interior.all():
                return None
            last = self._numbers.unsigned(self._starts(level) + 8, 4)
            level = np.insert(self._numbers.unsigned(at, 4), np.cumsum(np.bincount(page, minlength=len(level))), last)
        return None

    def found(self) -> Int:
        """Return all leaf pages of messages in the order of ids, without free pages: deleted messages."""
        free, trunk = set[int](), int.from_bytes(self._map[32:36], "big")
        while 0 < trunk <= self._count and trunk not in free:
            free.add(trunk)
            words = np.frombuffer(self._map, ">u4", self._page_bytes // 4, self._starts(trunk)).tolist()
            trunk = words[0]
            free.update(words[2 : 2 + words[1]])
        ranges = list[tuple[int, int, int]]()
        for rows, _ in self.lots(np.setdiff1d(np.arange(2, self._count + 1), np.fromiter(free, np.int64))):
            page, first, count = np.unique(rows.page, return_index=True, return_counts=True)
            is_whole = ~np.isin(page, rows.page[~rows.is_message])
            ends = np.array([rows.id[first + count - 1], rows.id[first], page])
            ranges += map(tuple, ends[:, is_whole].T.tolist())
        before, pages = -1, list[int]()
        for last, earliest, number in sorted(ranges):  # by last ids: a page with wrong ids displaces one at most
            if earliest > before:
                before = last
                pages.append(number)
        return np.array(pages, np.int64)

    def lots(self, pages: Int) -> Iterator[tuple[_Rows, bool]]:
        """Yield the rows on leaf pages, many pages at a time, and whether all are sound; the others are left out."""
        many = max(_LOT_BYTES // self._page_bytes, 1)
        for lot in (pages[first : first + many] for first in range(0, len(pages), many)):
            page, at, is_sound = self._cells(lot, *_LEAF)
            size, at = self._numbers.varints(at)
            ids, begin = self._numbers.varints(at)
            size = np.minimum(size, len(self._map))
            most, least = self._usable - 35, (self._usable - 12) * 32 // 255 - 23
            local = least + (size - least) % (self._usable - 4)
            local = np.where(size <= most, size, np.where(local <= most, local, least))
            rows = _Rows(lot[page], ids, begin, size, local, *self._values(self._numbers, begin, size, local))
            end = self._starts(rows.page) + self._usable - 4 * (local < size)
            wrong = ~rows.is_sound | (begin + local > end)
            wrong[1:] |= (page[1:] == page[:-1]) & (ids[1:] <= ids[:-1])
            is_sound[page[wrong]] = False
            yield rows.take(is_sound[page]), bool(is_sound.all())
            if hasattr(self._map, "madvise"):  # what was looked at would count as memory of the process
                self._map.madvise(mmap.MADV_DONTNEED)

    def joined(self, rows: _Rows) -> tuple[_Numbers, _Rows]:
        """Join records that go on on other pages; without those that miss a page or are too large."""
        if (rows.local == rows.size).all():
            return self._numbers, rows
        records = list(map(self._record, rows.begin.tolist(), rows.size.tolist(), rows.local.tolist()))
        there = np.array(list(map(len, records)))
        data, begin = _Numbers(b"".join([bytes(8), *records])), 8 + np.cumsum(there) - there
        whole = _Rows(rows.page, rows.id, begin, rows.size, there, *self._values(data, begin, rows.size, there))
        return data, whole.take(whole.is_sound & (there == rows.size))

    def _record(self, begin: int, size: int, local: int) -> bytes:
        """Return a record; what is cut off is missing."""
        record, at = self._map[begin : begin + local], begin + local
        for _ in range(-(-(min(size, LARGEST_MESSAGE) - local) // (self._usable - 4))):
            at = self._starts(int.from_bytes(self._map[at : at + 4], "big") or self._count + 2)
            record += self._map[at + 4 : at + self._usable]
        return record[:size]

    def _starts(self, pages: Any) -> Any:  # noqa: ANN401 - one or many
        return (pages - 1) * self._page_bytes

    def _cells(self, pages: Int, kind: int, header: int) -> tuple[Int, Int, Bool]:
        """Return which page each cell is on and where it begins, and for each page whether it is of a kind."""
        start = self._starts(pages)
        count = self._numbers.unsigned(start + 3, 2)
        is_sound = (self._numbers.unsigned(start, 1) == kind) & (header + 2 * count <= self._page_bytes)
        count[~is_sound] = 0
        page = np.repeat(np.arange(len(pages)), count)
        place = start[page] + header + 2 * (np.arange(len(page)) - np.repeat(np.cumsum(count) - count, count))
        return page, start[page] + self._numbers.unsigned(place, 2), is_sound

    def _values(self, data: _Numbers, begin: Int, size: Int, local: Int) -> tuple[Any, ...]:
        """Return topic, time, place and length of content of records, whether they are messages, and whether sound."""
        header, at = data.varints(begin)
        end = place = begin + header
        values = dict[str, tuple[Int, ...]]()
        for name in self._columns:
            kind, after = data.varints(at)
            kind, at = np.where(at < end, kind, 0), np.where(at < end, after, at)  # an added column may be missing
            width = np.minimum(np.where(kind < _BYTES, _WIDTHS.take(kind, mode="clip"), kind - _BYTES >> 1), size + 1)
            values[name], place = (kind, place, width), place + width
        *integers, (kind, start, width) = (values[name] for name in _COLUMNS)
        is_topic, is_time = (_ARE_INTEGERS.take(of, mode="clip") for of, *_ in integers)
        topic, time = (np.where(of < _ZERO, data.signed(at, wide), of - _ZERO) for of, at, wide in integers)
        topic = np.where(is_topic & (sum(values["topic_id"][1:]) <= begin + local), topic, -1)
        is_message = is_topic & is_time & (kind >= _BYTES) & (kind % 2 == 0)
        return topic, time, start, width, is_message, (at == end) & (place - begin == size)


class Sqlite3Stream(MessageStream):
    """The messages in one sqlite3 storage file."""

    magic, kind = b"SQLite format 3\x00", "an SQLite file"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with self._open() as file:
            header = self.magic + file.read(_HEADER_BYTES - len(self.magic))
        is_stated = len(header) == _HEADER_BYTES and header[24:28] == header[92:96]
        page = int.from_bytes(header[16:18], "big")
        self._page_bytes = _LARGEST_PAGE if page == 1 else page
        whole = self._page_bytes * int.from_bytes(header[28:32], "big") if is_stated else 0
        self._is_cut = self._bytes < whole
        if self._is_cut:
            self._note(self._bytes, "the file is cut off there", whole)
        self._merged: mmap.mmap | None = None  # with what is in a write-ahead log
        log = path.with_name(f"{path.name}-wal")
        try:
            with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                if not self._is_cut and log.is_file() and log.stat().st_size:
                    path = self._merge(log, Path(folder) / path.name)
                with closing(self._connect(path)) as opened:
                    self.connections = self._read_connections(opened)
        except _DATABASE_ERRORS as error:
            raise InputError(
                f"{self._path}: the sqlite3 database cannot be read: {error}; nothing of it can be saved, since the "
                "list of its topics is broken or cut off; copy it again from where it was recorded"
            ) from error

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        pages = self._pages()
        for rows, is_sound in pages.lots(self._leaves):
            if not is_sound:
                self._note_malformed()
            is_unknown = (rows.topic < 0) & (rows.local < rows.size)
            for key in keys:
                own = rows.take((rows.topic == key) | is_unknown)
                if len(own.id) and (window is None or window.keeps(own.time.min(), own.time.max()).any()):
                    lots = np.cumsum(own.size) // _LOT_BYTES
                    for lot in np.unique(lots):
                        yield from self._blocks_of(key, pages, own.take(lots == lot))

    def _blocks_of(self, key: int, pages: _Pages, own: _Rows) -> Iterator[Block]:
        data, rows = pages.joined(own)
        if len(rows.id) < len(own.id):
            self._note_malformed()
        rows = rows.take(rows.topic == key)
        plain = Block(key, rows.time, data.buffer, rows.start, rows.width)
        is_plain = rows.is_message & (data.unsigned(rows.start, 4) != _ZSTD)
        times = (
            time if fits else None for time, fits in zip(rows.time.tolist(), rows.is_message.tolist(), strict=True)
        )
        block = plain if is_plain.all() else self._block(key, list(zip(times, plain.payloads(), strict=True)))
        if block:
            yield block

    @cached_property
    def _leaves(self) -> Int:
        """The pages with messages; where the file is cut off or the table is broken, those that look like it."""
        pages = self._pages()
        leaves = None if self._is_cut else pages.in_tree(self._root)
        if leaves is None:
            self._note_malformed()
            leaves = pages.found()
        return leaves

    def _pages(self) -> _Pages:
        with self._open() as file:
            content = self._merged or mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        return _Pages(content, self._page_bytes, self._columns)

    def _note_malformed(self) -> None:
        if not self._is_cut:  # which has been noted
            self._note(None, "database disk image is malformed; the messages on whole pages were read")

    def _merge(self, log: Path, copy: Path) -> Path:
        """Copy the database to where SQLite may write, and put what its write-ahead log holds into the copy."""
        try:
            copyfile(self._path, copy)
            copyfile(log, f"{copy}-wal")
            with closing(sqlite3.connect(copy)) as database:
                database.execute("PRAGMA wal_checkpoint")
            with copy.open("rb") as file:
                self._merged = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            what = f"cannot be copied with its write-ahead log ({error}); set TMPDIR to a larger place"
            raise InputError(f"{self._path}: {what}") from error
        return copy

    def _connect(self, path: Path) -> sqlite3.Connection:
        """Open without writing any file next to it."""
        database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
        if self._is_cut:
            database.execute("PRAGMA writable_schema = ON")  # else SQLite refuses it
        database.text_factory = lambda text: text.decode(errors="replace")
        # No text is larger than the file, unless an expression in the table's definition makes it.
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(max(self._bytes, _LARGEST_PAGE), LARGEST_MESSAGE))
        return database

    def _read_connections(self, database: sqlite3.Connection) -> tuple[Connection, ...]:
        tables = dict(database.execute("SELECT name, rootpage FROM sqlite_master WHERE type = 'table'"))
        if missing := {"topics", "messages"} - tables.keys():
            there = ", ".join(sorted(tables)) or "none"
            what = f"no table {' and no table '.join(sorted(missing))}; tables are {there}"
            raise InputError(f"{self._path}: {what}; expected the sqlite3 storage of a ROS 2 bag; choose another file")
        database.execute("SELECT topic_id, timestamp, data FROM messages LIMIT 0")  # says which one is missing
        self._columns = [name.lower() for _, name, *_ in database.execute("PRAGMA table_xinfo(messages)")]
        self._root = tables["messages"]
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
        single = "SELECT id, (SELECT COUNT(*) FROM messages) FROM topics"
        several = "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"
        with suppress(*_DATABASE_ERRORS):
            if not self._is_cut:
                return dict(database.execute(single if len(keys) == 1 else several).fetchall())
        counts = Counter[int]()
        for block in self.blocks(keys):
            counts[block.key] += len(block)
        return counts
