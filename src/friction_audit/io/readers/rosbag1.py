"""ROS 1 bags -> Recording, also from bags that were never closed or break off."""

import re
import struct
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.message_stream import (
    Block,
    BlockCollector,
    Connection,
    MessageStream,
    Window,
    bound_of,
    open_log,
)
from friction_audit.io.readers.messages import read_messages, topics_of

_MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG_HEADER, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 4, 5, 6, 7
_LARGEST_HEADER = 1 << 24  # a header names a topic, a time and a size; definitions are in the data [byte]
_LENGTH = struct.Struct("<I")
_TIME = struct.Struct("<II")
_NANOSECONDS = 10**9


class BrokenRecordError(Exception):
    """The bag has no whole record here."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """Where a chunk and its data begin, the data's length, compression and length when decompressed [byte].

    ``unfinished`` is True if its end is missing, which has been noted.
    """

    record: int
    offset: int
    size: int
    compression: str
    claimed: int
    unfinished: bool = False


class Rosbag1Stream(MessageStream):
    """The messages in a ROS 1 bag of version 2.0.

    The records are walked from the start of the file instead of through the index at its end: that reads bags that
    were never closed, and finds equally long messages by the row.
    """

    def __init__(self, path: Path) -> None:
        """Find chunks and connections; InputError if this is no such bag, or nothing in it is whole."""
        super().__init__(path)
        self._connections: dict[int, dict[str, bytes]] = {}
        self._counts: dict[int, int] = {}
        self._chunks: list[Chunk] = []
        self._times: dict[int, tuple[int, int]] = {}
        self._uncounted: list[Chunk] = []
        with open_log(path) as file:
            _check_magic(path, file.readline(64), self._bytes)
            self._survey(file)
        if self._damage or self._uncounted or not self._connections:
            self._search_chunks()
        if self._damage and not self._connections:
            raise InputError(
                f"{path}: breaks off at byte {min(map(int, self._damage))} of {self._bytes} before the first whole "
                "message; nothing can be saved; copy it again or record again"
            )
        self.connections = tuple(
            Connection(
                key=key,
                topic=header["topic"].decode(errors="replace"),
                type=header.get("type", b"").decode(errors="replace").replace("/", "/msg/", 1),
                encoding="ros1",
                definition=header.get("message_definition", b""),
                definition_format="ros1msg",
                messages=self._counts.get(key, 0),
            )
            for key, header in self._connections.items()
        )

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some connections, chunk by chunk; chunks outside the window are passed over."""
        with open_log(self._path) as file:
            for chunk in self._chunks:
                if window and chunk.record in self._times and window.leaves_out(self._times[chunk.record]):
                    continue
                data = self._decompress(file, chunk)
                if data is None:
                    continue
                blocks, _, broken = _find_messages(data, keys)
                if broken and not chunk.unfinished:
                    self._note(chunk.offset, broken)
                yield from blocks

    def _survey(self, file: BinaryIO) -> None:
        """Walk over the file's records without reading the chunks' content; index records hold the counts."""
        while (offset := file.tell()) < self._bytes:
            try:
                header, size = _read_header(file)
                start = file.tell()
                self._survey_record(file, header, (offset, start), size)
            except BrokenRecordError as error:
                self._note(offset, str(error))
                return
            file.seek(start + size)

    def _survey_record(self, file: BinaryIO, header: Mapping[str, bytes], place: tuple[int, int], size: int) -> None:
        kind = (header.get("op") or b"\x00")[0]
        if kind == _BAG_HEADER and "encryptor" in header and header["encryptor"]:
            raise InputError(f"{self._path}: the bag is encrypted ({header['encryptor'].decode()}); decrypt it first")
        if kind == _CHUNK:
            self._survey_chunk(header, place, size)
        elif place[1] + size > self._bytes:
            raise BrokenRecordError("a record is cut off")
        elif kind == _CONNECTION:
            _learn_connection(header, file.read(size), self._connections)
        elif kind == _INDEX:
            key = _number(header, "conn")
            self._counts[key] = self._counts.get(key, 0) + _number(header, "count")
            self._uncounted = []
        elif kind == _CHUNK_INFO:
            place_of_chunk = int.from_bytes(header.get("chunk_pos", b""), "little")
            self._times[place_of_chunk] = _time(header, "start_time"), _time(header, "end_time")

    def _survey_chunk(self, header: Mapping[str, bytes], place: tuple[int, int], size: int) -> None:
        """Note a chunk; the last one of a bag that was never closed has length 0, and may go on to the file's end."""
        left = self._bytes - place[1]
        unfinished = size > left or (size == 0 and left > 0)
        packed = left if unfinished else size
        compression = header.get("compression", b"none").decode(errors="replace")
        claimed = bound_of(packed) if unfinished else _number(header, "size")
        chunk = Chunk(*place, packed, compression, claimed, unfinished)
        self._chunks.append(chunk)
        self._uncounted.append(chunk)
        if unfinished:
            raise BrokenRecordError("the last chunk has no end")

    def _search_chunks(self) -> None:
        """Find connections in the chunks themselves, and count the messages of chunks that have no index."""
        uncounted = set(self._uncounted)
        with open_log(self._path) as file:
            for chunk in self._chunks:
                data = self._decompress(file, chunk)
                if data is None:
                    continue
                blocks, connections, _ = _find_messages(data, None)
                self._connections = {**connections, **self._connections}
                for block in blocks if chunk in uncounted else ():
                    self._counts[block.key] = self._counts.get(block.key, 0) + len(block)

    def _decompress(self, file: BinaryIO, chunk: Chunk) -> bytes | None:
        """Return the records of a chunk, or None if it is damaged."""
        file.seek(chunk.offset)
        packed = file.read(chunk.size)
        return self._unpack(chunk.offset, chunk.compression, packed, chunk.claimed, cut=chunk.unfinished)


def _check_magic(path: Path, first_line: bytes, size: int) -> None:
    if first_line == _MAGIC:
        return
    if not size:
        raise InputError(f"{path}: is empty; expected a ROS 1 bag; check that it was copied whole")
    if first_line.startswith(b"#ROSBAG V1"):
        raise InputError(f"{path}: is a ROS bag of version 1; expected 2.0; convert it with `rosbag fix`")
    raise InputError(f"{path}: does not begin with '#ROSBAG V2.0'; expected a ROS 1 bag; check the file's type")


def _read_header(file: BinaryIO) -> tuple[dict[str, bytes], int]:
    """Read a record up to its data; returns the header's fields and the length of the data."""

    def read(size: int) -> bytes:
        if len(data := file.read(size)) < size:
            raise BrokenRecordError("a record is cut off")
        return data

    (size,) = _LENGTH.unpack(read(_LENGTH.size))
    if size > _LARGEST_HEADER:
        raise BrokenRecordError(f"a record's header claims {size} bytes")
    header = _parse_header(read(size))
    return header, int(_LENGTH.unpack(read(_LENGTH.size))[0])


def _parse_header(header: bytes) -> dict[str, bytes]:
    fields: dict[str, bytes] = {}
    position = 0
    while position < len(header):
        if position + _LENGTH.size > len(header):
            raise BrokenRecordError("a record's header is broken")
        (size,) = _LENGTH.unpack_from(header, position)
        position += _LENGTH.size
        name, equals, value = header[position : position + size].partition(b"=")
        if not equals or position + size > len(header):
            raise BrokenRecordError("a record's header is broken")
        fields[name.decode(errors="replace")] = value
        position += size
    return fields


def _field(header: Mapping[str, bytes], name: str, form: struct.Struct) -> tuple[int, ...]:
    value = header.get(name, b"")
    if len(value) != form.size:
        raise BrokenRecordError(f"a record's header has no {name}")
    return form.unpack(value)


def _number(header: Mapping[str, bytes], name: str) -> int:
    return _field(header, name, _LENGTH)[0]


def _time(header: Mapping[str, bytes], name: str) -> int:
    seconds, nanoseconds = _field(header, name, _TIME)
    return seconds * _NANOSECONDS + nanoseconds


class MessageHead:
    """What message records look like up to their payload; writers differ in the order of the header's fields."""

    def __init__(self, head: bytes) -> None:
        """Learn it from one record, given up to its payload."""
        widths = {b"conn": _LENGTH.size, b"time": _TIME.size}
        end = len(head) - _LENGTH.size
        offsets: dict[bytes, int] = {}
        position, copied, pattern = _LENGTH.size, 0, b""
        while position < end:
            (size,) = _LENGTH.unpack_from(head, position)
            name, _, value = head[position + _LENGTH.size : position + _LENGTH.size + size].partition(b"=")
            position += _LENGTH.size + size
            if widths.get(name) == len(value):
                offsets[name] = position - len(value)
                pattern += re.escape(head[copied : offsets[name]]) + b"(?P<%b>.{%d})" % (name, len(value))
                copied = position
        if missing := widths.keys() - offsets.keys():
            raise BrokenRecordError(f"a message record has no {b' and no '.join(sorted(missing)).decode()}")
        self.pattern = re.compile(pattern + re.escape(head[copied:end]) + b"(?P<length>.{4})", re.DOTALL)
        conn, time = offsets[b"conn"], offsets[b"time"]
        names, places = ["conn", "sec", "nsec", "length"], [conn, time, time + 4, end]
        self.record = np.dtype({"names": names, "formats": ["<u4"] * 4, "offsets": places, "itemsize": len(head)})
        # The bytes that all messages share.
        self.fixed = np.setdiff1d(np.arange(len(head)), np.add.outer(places, np.arange(4)))

    def unpack(self, match: re.Match[bytes]) -> tuple[int, int, int]:
        """Return connection, time [ns] and length of the payload [byte]."""
        (conn,), (sec, nsec) = _LENGTH.unpack(match["conn"]), _TIME.unpack(match["time"])
        return conn, sec * _NANOSECONDS + nsec, _LENGTH.unpack(match["length"])[0]


Connections = dict[int, dict[str, bytes]]


def _find_messages(data: bytes, keys: Collection[int] | None) -> tuple[list[Block], Connections, str]:
    """Find the messages of some connections (None for all) in the records of a chunk.

    Returns also the descriptions of connections in the chunk, and what is wrong with it.
    """
    collector, connections, broken = BlockCollector(data, keys), Connections(), ""
    head: MessageHead | None = None
    position = 0
    try:
        while position < len(data):
            match = head.pattern.match(data, position) if head else None
            if head is None or match is None:  # no message, or a message whose head looks different
                header, start, following = _record_at(data, position)
                if header["op"][0] == _MESSAGE:
                    head = MessageHead(data[position:start])
                else:
                    _learn_connection(header, data[start:following], connections)
                    position = following
                continue
            key, log_time, size = head.unpack(match)
            if match.end() + size > len(data):
                raise BrokenRecordError("a message runs over the end of its chunk")  # noqa: TRY301
            taken = collector.add(key, log_time, match.end(), size, partial(_run, data, position, head, size))
            position += taken * (head.record.itemsize + size)
    except BrokenRecordError as error:
        broken = str(error)
    return collector.finish(), connections, broken


def _run(data: bytes, position: int, head: MessageHead, size: int) -> Block:
    """View the messages from here on that are as long as the first one and of its connection."""
    width = head.record.itemsize
    stride = width + size
    count = (len(data) - position) // stride
    values = np.ndarray((count,), head.record, data, offset=position, strides=(stride,))
    rows = np.ndarray((count, width), np.uint8, data, offset=position, strides=(stride, 1))
    same = (values["length"] == size) & (values["conn"] == values["conn"][0])
    same &= (rows[:, head.fixed] == rows[0, head.fixed]).all(axis=1)
    run = count if same.all() else int(same.argmin())
    start = position + width + stride * np.arange(run, dtype=np.int64)
    log_time = values["sec"][:run].astype(np.int64) * _NANOSECONDS + values["nsec"][:run]
    return Block(int(values["conn"][0]), log_time, data, start, np.full(run, size, np.int64))


def _record_at(data: bytes, position: int) -> tuple[dict[str, bytes], int, int]:
    """Parse the record at an offset; returns its header and where its data starts and ends."""
    try:
        (header_size,) = _LENGTH.unpack_from(data, position)
        header = _parse_header(data[position + 4 : position + 4 + header_size])
        start = position + 4 + header_size + 4
        following = start + int(_LENGTH.unpack_from(data, start - 4)[0])
    except struct.error as error:
        raise BrokenRecordError("a record is cut off") from error
    if following > len(data) or not header.get("op"):
        raise BrokenRecordError("a record in a chunk is cut off or broken")
    return header, start, following


def _learn_connection(header: Mapping[str, bytes], data: bytes, connections: dict[int, dict[str, bytes]]) -> None:
    if header["op"][0] == _CONNECTION and "topic" in header:
        connections[_number(header, "conn")] = {**_parse_header(data), "topic": header["topic"]}


def recognises(path: Path) -> bool:
    """Return True if the file begins as a ROS 1 bag does."""
    return starts_with(path, b"#ROSBAG V")


read, topics = partial(read_messages, Rosbag1Stream), partial(topics_of, Rosbag1Stream)
