"""The sqlite3 storage of a ROS 2 bag: SQLite reads the list of topics, the messages come from the pages of their table.

For the layout of pages and records see https://www.sqlite.org/fileformat2.html.
"""

import mmap
import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, closing, suppress
from functools import cached_property
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.message_stream import LARGEST_MESSAGE, ZSTD, Block, Connection, MessageStream, Window
from friction_audit.joint_log import Bool, Int

_INTERIOR, _LEAF = (5, 12), (13, 8)  # pages of a table: their first byte, length of their header
_LOT_BYTES = 2 << 20  # of pages that are looked at together; with half of that it takes 1.4 times as long
_COLUMNS = ("topic_id", "timestamp", "data")
# What is known of rows of the table of messages: the record, how much of it is on its page, the content.
_PAGE, _ID, _BEGIN, _SIZE, _LOCAL, _TOPIC, _TIME, _START, _WIDTH, _IS_MESSAGE = range(10)
# Types of a value: nothing, integers, a float, 0 and 1 without a byte, two without use; then bytes and texts in turn.
_WIDTHS = np.array([0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0])
_ARE_INTEGERS = np.isin(np.arange(12), (1, 2, 3, 4, 5, 6, 8, 9))
_ZERO, _BYTES = 8, 12
_LARGEST_ID = 2**63 - 1
# The nearest message before and after a part of the log.
_OUTSIDE = (
    "SELECT (SELECT MAX(timestamp) FROM messages WHERE timestamp < ?1), "
    "(SELECT MIN(timestamp) FROM messages WHERE timestamp > ?2)"
)
_DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)  # of a broken database; the second if the message names a part


class _Pages:
    """The pages of a database on a map of its file; many places are looked at at once."""

    def __init__(self, content: mmap.mmap, page_bytes: int, columns: Sequence[str]) -> None:
        self.content, self._page_bytes, self._columns = content, page_bytes, columns
        self._usable, self._count = page_bytes - content[20], len(content) // page_bytes
        self._bytes = np.frombuffer(content, np.uint8)
        self._words = np.ndarray((len(content) - 7,), ">i8", content, strides=(1,))

    def in_tree(self, root: int) -> tuple[Int, Int] | None:
        """Return the leaf pages of a table in the order of ids, and bounds of their last ids, shape (n,) each.

        None if a page above them is broken.
        """
        level, bounds = np.array([root]), np.array([_LARGEST_ID])
        for _ in range(20):  # levels, as in SQLite
            if ((level < 1) | (level > self._count)).any() or np.bincount(level).max() > 1:
                break
            start = (level - 1) * self._page_bytes
            if (self._bytes[start[[0, -1]]] == _LEAF[0]).all():
                return level, bounds
            page, at, is_interior = self._cells(level, *_INTERIOR)
            if not is_interior.all():
                break
            last = np.cumsum(np.bincount(page, minlength=len(level)))
            level = np.insert(self.integers(at, 4), last, self.integers(start + 8, 4))
            bounds = np.insert(self._varints(at + 4)[0], last, bounds)
        return None

    def found(self) -> tuple[Int, Int]:
        """Return all leaf pages of messages and their last ids in order, without free pages: deleted messages."""
        free, trunk = set[int](), int.from_bytes(self.content[32:36], "big")
        while 0 < trunk <= self._count and trunk not in free:
            free.add(trunk)
            words = np.frombuffer(self.content, ">u4", self._page_bytes // 4, (trunk - 1) * self._page_bytes).tolist()
            trunk = words[0]
            free.update(words[2 : 2 + words[1]])
        ranges = list[tuple[int, ...]]()
        for rows, broken in self.lots(np.setdiff1d(np.arange(2, self._count + 1), np.fromiter(free, np.int64))):
            page, first, count = np.unique(rows[_PAGE], return_index=True, return_counts=True)
            ends = np.array([rows[_ID][first + count - 1], rows[_ID][first], page])
            others = np.append(broken, rows[_PAGE][rows[_IS_MESSAGE] == 0])
            ranges += map(tuple, ends[:, ~np.isin(page, others)].T.tolist())
        before, pages = -1, list[tuple[int, int]]()
        for last, earliest, number in sorted(ranges):  # by last ids: a page with wrong ids displaces one at most
            if earliest > before:
                before = last
                pages.append((number, last))
        numbers, bounds = np.array(pages, np.int64).reshape(-1, 2).T
        return numbers, bounds

    def lots(self, pages: Int) -> Iterator[tuple[Int, Int]]:
        """Yield the rows on leaf pages that are sound, many pages at a time, and the pages where something is not."""
        many = max(_LOT_BYTES // self._page_bytes, 1)
        for lot in (pages[first : first + many] for first in range(0, len(pages), many)):
            page, at, is_sound = self._cells(lot, *_LEAF)
            size, at = self._varints(at)
            ids, begin = self._varints(at)
            size = np.minimum(size, len(self.content))
            most, least = self._usable - 35, (self._usable - 12) * 32 // 255 - 23
            local = least + (size - least) % (self._usable - 4)
            local = np.where(size <= most, size, np.where(local <= most, local, least))
            *values, adds_up = self._values(begin, size, local)
            rows = np.array([lot[page], ids, begin, size, local, *values])
            wrong = ~adds_up | (begin + local > (lot[page] - 1) * self._page_bytes + self._usable - 4 * (local < size))
            wrong[1:] |= (page[1:] == page[:-1]) & (ids[1:] <= ids[:-1])
            is_sound[page[wrong]] = False
            yield rows[:, ~wrong] if wrong.any() else rows, lot[~is_sound]
            if hasattr(self.content, "madvise"):  # what was looked at would count as memory of the process
                self.content.madvise(mmap.MADV_DONTNEED)

    def record(self, begin: int, size: int, local: int) -> bytes:
        """Return a record, which may go on on other pages; what is cut off or too much is missing."""
        record, at = self.content[begin : begin + local], begin + local
        for _ in range(-(-(min(size, LARGEST_MESSAGE) - local) // (self._usable - 4))):
            number = int.from_bytes(self.content[at : at + 4], "big") or self._count + 2  # 0 is no page
            at = (number - 1) * self._page_bytes
            record += self.content[at + 4 : at + self._usable]
        return record[:size]

    def integers(self, at: Int, width: Int | int) -> Int:
        """Return signed big-endian numbers of up to eight bytes; any number where the file has ended."""
        word: Int = self._words[np.minimum(at + width - 8, len(self._words) - 1)]
        return word << 64 - 8 * width >> 64 - 8 * width

    def _varints(self, at: Int) -> tuple[Int, Int]:
        """Return numbers of up to eight bytes with seven bits each, and where they end."""
        value, end, more = np.zeros_like(at), at, np.ones(len(at), np.bool_)
        for _ in range(8):
            byte = self._bytes.take(end, mode="clip")
            value, end = np.where(more, value << 7 | byte & 0x7F, value), end + more
            more &= byte & 0x80 != 0
            if not more.any():
                break
        return value, end

    def _cells(self, pages: Int, kind: int, header: int) -> tuple[Int, Int, Bool]:
        """Return which page each cell is on and where it begins, and for each page whether it is of a kind."""
        start = (pages - 1) * self._page_bytes
        count = self.integers(start + 3, 2) & 0xFFFF
        is_sound = (self._bytes[start] == kind) & (header + 2 * count <= self._page_bytes)
        count[~is_sound] = 0
        page = np.repeat(np.arange(len(pages)), count)
        place = start[page] + header + 2 * (np.arange(len(page)) - np.repeat(np.cumsum(count) - count, count))
        return page, start[page] + (self.integers(place, 2) & 0xFFFF), is_sound

    def _values(self, begin: Int, size: Int, local: Int) -> tuple[Any, ...]:
        """Return topic, time, place and length of content of records, whether they are messages and add up."""
        header, at = self._varints(begin)
        end = place = begin + header
        values = dict[str, tuple[Int, Int, Int]]()
        for name in self._columns:
            kind, after = self._varints(at)
            kind, at = np.where(at < end, kind, 0), np.where(at < end, after, at)  # an added column may be missing
            width = np.minimum(np.where(kind < _BYTES, _WIDTHS.take(kind, mode="clip"), kind - _BYTES >> 1), size + 1)
            values[name], place = (kind, place, width), place + width
        *integers, (kind, start, width) = (values[name] for name in _COLUMNS)
        topic, time = (np.where(of < _ZERO, self.integers(at, wide), of - _ZERO) for of, at, wide in integers)
        is_topic, is_time = (_ARE_INTEGERS.take(of, mode="clip") for of, *_ in integers)
        are_local = np.all([at + wide <= begin + local for _, at, wide in integers], axis=0)
        is_message = is_topic & is_time & (kind >= _BYTES) & (kind % 2 == 0)
        return topic, time, start, width, is_message, (at == end) & (place - begin == size) & are_local


class Sqlite3Stream(MessageStream):
    """The messages in one sqlite3 storage file."""

    magic, kind = b"SQLite format 3\x00", "an SQLite file"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._merged: mmap.mmap | None = None
        with self._open() as file, ExitStack() as stack:
            header, log = (self.magic + file.read(84)).ljust(100, b"\0"), Path(f"{path}-wal")
            self._page_bytes = header[16] << 8 | header[17] << 16  # 1 stands for the largest
            pages = int.from_bytes(header[28:32], "big") if header[24:28] == header[92:96] else 0  # 0: not stated
            self._is_cut = self._bytes < pages * self._page_bytes
            if self._is_cut:
                self._note(self._bytes, "the file is cut off there", pages * self._page_bytes)
            elif log.is_file() and log.stat().st_size:  # SQLite would write next to the user's file
                folder = stack.enter_context(TemporaryDirectory(ignore_cleanup_errors=True))
                path = Path(copyfile(path, Path(folder, path.name)))
                copyfile(log, f"{path}-wal")
            try:
                with closing(self._connect(path)) as opened, path.open("rb") as merged:
                    if path != self._path:
                        self._merged = mmap.mmap(merged.fileno(), 0, access=mmap.ACCESS_READ)
                    self.connections = self._read_connections(opened)
            except _DATABASE_ERRORS as error:
                raise InputError(
                    f"{self._path}: the sqlite3 database cannot be read: {error}; nothing of it can be saved, since "
                    "the list of its topics is broken or cut off; copy it again from where it was recorded"
                ) from error

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        pages = self._pages()
        leaves, bounds = self._leaves
        ids = (0, _LARGEST_ID) if window is None or self._is_cut or self._merged else self._ids_in(window)
        begin, end = np.searchsorted(bounds, ids)
        for rows, broken in pages.lots(leaves[begin : end + 1]):
            if len(broken):
                self._note_malformed()
            for key in keys:
                own = rows[:, rows[_TOPIC] == key]
                if own.size and (window is None or window.keeps(own[_TIME].min(), own[_TIME].max()).any()):
                    yield from self._blocks_of(key, pages, own)

    def _blocks_of(self, key: int, pages: _Pages, rows: Int) -> Iterator[Block]:
        """Yield messages where they lie; one by one if some are on several pages, are compressed or are no messages."""
        is_plain = (
            rows[_IS_MESSAGE]
            & (rows[_LOCAL] == rows[_SIZE])
            & (pages.integers(rows[_START], 4) != int.from_bytes(ZSTD))
        )
        if is_plain.all():
            yield Block(key, rows[_TIME], pages.content, rows[_START], rows[_WIDTH])
            return
        many = max(LARGEST_MESSAGE // int(rows[_SIZE].max()), 1)
        for first in range(0, rows.shape[1], many):
            lot = rows[_BEGIN:, first : first + many].T.tolist()
            whole = [
                (time if is_message else None, record[start - begin :][:width])
                for begin, size, local, _, time, start, width, is_message in lot
                if len(record := pages.record(begin, size, local)) == size
            ]
            if len(whole) < len(lot):
                self._note_malformed()
            if block := self._block(key, whole):
                yield block

    @cached_property
    def _leaves(self) -> tuple[Int, Int]:
        """Pages with messages and bounds of their last ids; those that look so where the table is broken or cut."""
        pages = self._pages()
        if self._is_cut or (leaves := pages.in_tree(self._root)) is None:
            self._note_malformed()
            return pages.found()
        return leaves

    def _ids_in(self, window: Window) -> tuple[int, int]:
        """Return the first and the last id of the messages in a window, by the index of time stamps."""
        with suppress(*_DATABASE_ERRORS), closing(self._connect(self._path)) as database:
            query = f"{_OUTSIDE}, MIN(rowid), MAX(rowid) FROM messages WHERE timestamp BETWEEN ?1 AND ?2"
            *others, first, last = database.execute(query, (window.first, window.last)).fetchone()
            outside = [one for one in others if one is not None]
            window.keeps(outside, outside)
            return (first, last) if first is not None else (_LARGEST_ID, 0)
        return 0, _LARGEST_ID

    def _pages(self) -> _Pages:
        with self._open() as file:
            content = self._merged or mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        return _Pages(content, self._page_bytes, self._columns)

    def _note_malformed(self) -> None:
        if not self._is_cut:  # which has been noted
            self._note(None, "database disk image is malformed; the messages on whole pages were read")

    def _connect(self, path: Path) -> sqlite3.Connection:
        """Open without writing any file next to the user's; put a write-ahead log into a copy."""
        how = "?mode=ro&immutable=1" if path == self._path else ""
        database = sqlite3.connect(f"{path.resolve().as_uri()}{how}", uri=True)
        if self._is_cut:
            database.execute("PRAGMA writable_schema = ON")  # else SQLite refuses it
        database.execute("PRAGMA wal_checkpoint")
        database.text_factory = lambda text: text.decode(errors="replace")
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_MESSAGE)  # a table's definition can make larger texts
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
        count, counts = "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id", dict[int, int]()
        if len(topics) == 1:  # by the index of time stamps, without reading them
            count = "SELECT id, (SELECT COUNT(*) FROM messages) FROM topics"
        with suppress(*_DATABASE_ERRORS):
            counts = {} if self._is_cut else dict(database.execute(count).fetchall())
        counts = counts or Counter(one.key for one in self.blocks([key for key, *_ in topics]) for _ in one.log_time)
        return tuple(
            Connection(key, str(topic), str(kind), str(how), definitions.get(kind, ("", b"")), counts.get(key, 0))
            for key, topic, kind, how in topics
        )
