"""ROS 1 bags -> Recording, also from bags that were never closed or break off; headers are parsed by rosbags."""

import re
import struct
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.message_stream import (
    Block,
    BlockCollector,
    BrokenError,
    Connection,
    Heads,
    MessageStream,
    Window,
    bound_of,
)
from friction_audit.io.readers.messages import read_messages, topics_of

_MESSAGE, _BAG_HEADER, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 4, 5, 6, 7
_LARGEST_HEADER = 1 << 24  # a header names a topic, a time and a size; definitions are in the data [byte]
_LENGTH = struct.Struct("<I")
_TIME = struct.Struct("<II")
_NANOSECONDS = 10**9


class Chunk(NamedTuple):
    """Where a chunk and its data begin, the data's length, compression and length when decompressed [byte]."""

    record: int
    offset: int
    size: int
    compression: str
    claimed: int
    unfinished: bool  # its end is missing, which has been noted


class Rosbag1Stream(MessageStream):
    """The messages in a ROS 1 bag of version 2.0, walked from its start: bags may lack the index at the end."""

    magic, kind = b"#ROSBAG V2.0\n", "a ROS 1 bag of version 2.0"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._connections: dict[int, dict[str, bytes]] = {}
        self._times: dict[int, tuple[int, int]] = {}
        self._counts, self._chunks = Counter[int](), list[Chunk]()
        self._uncounted = 0  # of the chunks, the last ones, which no index follows
        with self._open() as file:
            self._survey(file)
        if self.damage or self._uncounted or not self._connections:
            counted = self._chunks[: len(self._chunks) - self._uncounted]
            for chunk, data in self._unpacked():  # connections are in the chunks themselves, too
                for block in self._find_messages(chunk, data, None):
                    self._counts[block.key] += 0 if chunk in counted else len(block)
        self._refuse_without(self._connections, "message")
        self.connections = tuple(
            Connection(
                key,
                header["topic"].decode(errors="replace"),
                header.get("type", b"").decode(errors="replace").replace("/", "/msg/", 1),
                "ros1",
                ("ros1msg", header.get("message_definition", b"")),
                self._counts[key],
            )
            for key, header in self._connections.items()
        )

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        for chunk, data in self._unpacked(window):
            yield from self._find_messages(chunk, data, keys)

    def _unpacked(self, window: Window | None = None) -> Iterator[tuple[Chunk, bytes]]:
        """Yield the chunks whose records can be decompressed."""
        with self._open() as file:
            for chunk in self._chunks:
                if window and not window.keeps(*self._times.get(chunk.record, (1, 0))).any():
                    continue
                file.seek(chunk.offset)
                packed = file.read(chunk.size)
                data = self._unpack(chunk.offset, chunk.compression, packed, chunk.claimed, cut=chunk.unfinished)
                if data is not None:
                    yield chunk, data

    def _survey(self, file: BinaryIO) -> None:
        """Walk over the file's records without reading the chunks' content; index records hold the counts."""
        while (offset := file.tell()) < self._bytes:
            try:
                kind, header, size = _read_header(file)
                start = file.tell()
                self._survey_record(file, kind, header, (offset, start, size))
            except BrokenError as error:
                self._note(offset, str(error))
                return
            file.seek(start + size)

    def _survey_record(
        self, file: BinaryIO, kind: int, header: Mapping[str, bytes], place: tuple[int, int, int]
    ) -> None:
        record, start, size = place
        left = self._bytes - start
        if kind == _BAG_HEADER and header.get("encryptor"):
            raise InputError(f"{self._path}: the bag is encrypted ({header['encryptor'].decode()}); decrypt it first")
        if kind == _CHUNK:  # the last one of a bag that was never closed has length 0, and may go on to the file's end
            unfinished = size > left or (size == 0 and left > 0)
            packed = left if unfinished else size
            compression = header.get("compression", b"none").decode(errors="replace")
            claimed = bound_of(packed) if unfinished else _number(header, "size")
            self._chunks.append(Chunk(record, start, packed, compression, claimed, unfinished))
            self._uncounted += 1
            if unfinished:
                raise BrokenError("the last chunk has no end")
        elif size > left:
            raise BrokenError("a record is cut off")
        elif kind == _CONNECTION:
            self._learn(kind, header, file.read(size))
        elif kind == _INDEX:
            self._counts[_number(header, "conn")] += _number(header, "count")
            self._uncounted = 0
        elif kind == _CHUNK_INFO:
            place_of_chunk = int.from_bytes(header.get("chunk_pos", b""), "little")
            first, last = (_TIME.unpack(_field(header, name, _TIME.size)) for name in ("start_time", "end_time"))
            self._times[place_of_chunk] = first[0] * _NANOSECONDS + first[1], last[0] * _NANOSECONDS + last[1]

    def _find_messages(self, chunk: Chunk, data: bytes, keys: Collection[int] | None) -> list[Block]:
        """Find the messages of some connections (None for all) in the records of a chunk, and learn its connections."""
        collector, position = BlockCollector(data, keys), 0
        heads: Heads | None = None
        try:
            while position < len(data):
                match = heads.pattern.match(data, position) if heads and heads.pattern else None
                if heads is None or match is None:  # no message, or a message whose head looks different
                    stream = BytesIO(data)
                    stream.seek(position)
                    kind, header, size = _read_header(stream)
                    start = stream.tell()
                    if start + size > len(data):
                        raise BrokenError("a record in a chunk is cut off or broken")  # noqa: TRY301
                    if kind == _MESSAGE:
                        heads = _heads_like(data[position:start])
                    else:
                        self._learn(kind, header, data[start : start + size])
                        position = start + size
                    continue
                key, sec, nsec, size = struct.unpack("<4I", match["conn"] + match["time"] + match["length"])
                if match.end() + size > len(data):
                    raise BrokenError("a message runs over the end of its chunk")  # noqa: TRY301
                position += collector.add(key, sec * _NANOSECONDS + nsec, match.end(), size, heads)
        except BrokenError as error:
            if not chunk.unfinished:
                self._note(chunk.offset, str(error))
        return collector.finish()

    def _learn(self, kind: int, header: Mapping[str, bytes], data: bytes) -> None:
        """Note a connection; the definition of one that is in several places is that of the file's own record."""
        if kind == _CONNECTION and "topic" in header:
            _, described, _ = _read_header(BytesIO(_LENGTH.pack(len(data)) + data + bytes(_LENGTH.size)))
            self._connections.setdefault(_number(header, "conn"), described | {"topic": header["topic"]})


def _read_header(file: BinaryIO) -> tuple[int, dict[str, bytes], int]:
    """Read a record up to its data; returns its kind, the header's fields and the length of the data."""
    from rosbags.rosbag1.reader import Header, ReaderError

    try:
        start = file.tell()
        claimed = int.from_bytes(file.read(_LENGTH.size), "little")
        if claimed > _LARGEST_HEADER:
            raise BrokenError(f"a record's header claims {claimed} bytes")
        file.seek(start)
        header = Header.read(file)
        return (header.get("op") or b"\x00")[0], header, int(_LENGTH.unpack(file.read(_LENGTH.size))[0])
    except (ReaderError, UnicodeDecodeError, struct.error, OSError) as error:
        raise BrokenError("a record is cut off, or its header is broken") from error


def _field(header: Mapping[str, bytes], name: str, size: int = _LENGTH.size) -> bytes:
    value = header.get(name, b"")
    if len(value) != size:
        raise BrokenError(f"a record's header has no {name}")
    return value


def _number(header: Mapping[str, bytes], name: str) -> int:
    return int.from_bytes(_field(header, name), "little")


def _heads_like(head: bytes) -> Heads:
    """Learn from one message record up to its payload what others look like; writers differ in the order of fields."""
    conn, time = head.find(b"\x09\0\0\0conn=") + 9, head.find(b"\x0d\0\0\0time=") + 9  # each with its length
    end = len(head) - _LENGTH.size
    if min(conn, time) < 9 or conn + 4 > end or time + 8 > end:  # noqa: PLR2004
        raise BrokenError("a message record has no connection or no time")
    text, copied = b"", 0
    for name, begin, stop in sorted(((b"conn", conn, conn + 4), (b"time", time, time + 8)), key=itemgetter(1)):
        text += re.escape(head[copied:begin]) + b"(?P<%b>.{%d})" % (name, stop - begin)
        copied = stop
    text += re.escape(head[copied:end]) + b"(?P<length>.{4})"
    constant = (slice(time), slice(time + 8, len(head)))
    pattern = re.compile(text, re.DOTALL)
    return Heads(len(head), constant, time, lambda one: one.view("<u4").astype(np.int64) @ (_NANOSECONDS, 1), pattern)


read, topics = partial(read_messages, Rosbag1Stream), partial(topics_of, Rosbag1Stream)
