"""MCAP files -> Recording: ROS 2 (CDR), ROS 1, JSON and protobuf messages, also from files that break off."""

import struct
from collections import Counter
from collections.abc import Collection, Iterator
from functools import partial
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

from friction_audit.io.readers.joint_states import LATEST_TIME_NS
from friction_audit.io.readers.message_stream import Block, BlockCollector, Connection, Heads, MessageStream, Window
from friction_audit.io.readers.messages import read_messages, topics_of

_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA = 3, 4, 5, 6, 12  # opcodes of records
_LOOSE = (_SCHEMA, _CHANNEL, _MESSAGE, _METADATA)  # outside of chunks; the others are indices and the like
# What the mcap library raises on a record that is not what its opcode says.
_BROKEN = (struct.error, UnicodeDecodeError, EOFError, OverflowError)
# Opcode -> length of the footer and of the end of the data section: another length is a broken record.
_END_LENGTHS = {2: 20, 15: 4}
_CHUNK_TIMES = struct.Struct("<QQ")
_RECORD_START = struct.Struct("<BQ")
_MESSAGE_TIME = struct.Struct("<HIQ")  # channel, sequence, log time; the time of publication follows
# Of opcode, length and channel; sequence and times differ.
_HEADS = Heads(width=31, constant=(slice(11),), clock=15, in_ns=lambda clock: clock.view("<i8")[:, 0] & LATEST_TIME_NS)
_LOOSE_BYTES = 1 << 20


class McapStream(MessageStream):
    """The messages in one MCAP file; to walk the records here needs no index, and saves most of the library's time."""

    magic, kind = b"\x89MCAP0\r\n", "an MCAP file"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with self._open() as file:
            is_whole = self._read_summary(file)
        if not is_whole:  # everything is read once, to find the channels
            self._channels, self._schemas, self._counts = dict[int, Any](), dict[int, Any](), Counter[int]()
            for block in self.blocks(None):
                self._counts[block.key] += len(block)
            self._refuse_without(self._channels, "chunk")
        self.connections = tuple(map(self._connection, self._channels.values()))

    def blocks(self, keys: Collection[int] | None, window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some channels, or of all that are found, but for chunks outside the window."""
        for offset, data in self._records(window):
            collector, position = BlockCollector(data, keys), 0
            while position + _RECORD_START.size <= len(data):
                opcode, length = _RECORD_START.unpack_from(data, position)
                start, following = position + _HEADS.width, position + _RECORD_START.size + length
                if following > len(data):
                    break
                if opcode == _MESSAGE and start <= following:
                    channel, _, time = _MESSAGE_TIME.unpack_from(data, position + _RECORD_START.size)
                    position += collector.add(channel, time & LATEST_TIME_NS, start, following - start, _HEADS)
                    continue
                if opcode == _MESSAGE:
                    self._note(offset, "a record is broken: it ends early")
                elif opcode == _METADATA or keys is None:
                    self._learn(opcode, offset, data[position + _RECORD_START.size : following])
                position = following
            if position != len(data):
                self._note(offset, "a message runs over the end of its chunk")
            yield from self._decompressed(collector.finish())

    def _records(self, window: Window | None) -> Iterator[tuple[int, bytes]]:
        """Yield offset and records of each chunk, and those between chunks; up to a break. Indices are not read."""
        offset, loose, begin = len(self.magic), bytearray(), 0
        with self._open() as file:
            while True:
                file.seek(offset)
                start = file.read(_RECORD_START.size)
                opcode, length = _RECORD_START.unpack(start) if len(start) == _RECORD_START.size else (None, 0)
                is_cut = offset + _RECORD_START.size + length > self._bytes
                is_end = is_cut or length == _END_LENGTHS.get(opcode)
                if opcode in _LOOSE and not is_cut:
                    begin = begin if loose else offset
                    loose += start + file.read(length)
                if loose and (is_end or opcode == _CHUNK or len(loose) > _LOOSE_BYTES):
                    yield begin, bytes(loose)
                    loose.clear()
                reason = "it ends without the closing records" if opcode is None else "a record is cut off"
                if opcode == _CHUNK and (is_cut or window is None or window.keeps(*_times_of_chunk(file)).any()):
                    reason = "the last chunk is cut off; its whole messages were read without its checksum"
                    yield from self._records_of_chunk(file, offset, length, cut=is_cut)
                if is_cut:
                    self._note(offset, reason)
                if is_end:
                    return
                offset += _RECORD_START.size + length

    def _records_of_chunk(self, file: BinaryIO, offset: int, length: int, *, cut: bool) -> Iterator[tuple[int, bytes]]:
        """Yield offset and records of a chunk, nothing if it is damaged; of a cut one the checksum says nothing."""
        try:
            chunk = _parse(_CHUNK, file.read(min(length, self.largest_chunk) if cut else length))
        except _BROKEN as error:  # of a cut one: before its first message
            return self._note(offset, f"a record is broken: {error}")
        data = self._unpack(offset, chunk.compression, chunk.data, chunk.uncompressed_size, cut=cut)
        if data is None:
            return None
        if not cut and chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
            return self._note(offset, "a chunk has another checksum than its header says")
        yield offset, data
        return None

    def _read_summary(self, file: BinaryIO) -> bool:
        """Read channels and message counts from the end of the file; False if they are not all there."""
        from mcap.exceptions import McapError
        from mcap.reader import SeekingReader

        file.seek(0)
        try:
            summary = SeekingReader(file, record_size_limit=self._bytes).get_summary()
        except (McapError, OSError, ValueError, MemoryError, *_BROKEN):
            return False  # a file without a sound end is read from its beginning instead
        if summary is None or summary.statistics is None or summary.statistics.channel_count != len(summary.channels):
            return False
        self._counts = Counter(summary.statistics.channel_message_counts)
        self._channels, self._schemas = summary.channels, summary.schemas
        return self._counts.total() == summary.statistics.message_count

    def _learn(self, opcode: int, offset: int, content: bytes) -> None:
        try:
            record: Any = _parse(opcode, content) if opcode in (_SCHEMA, _CHANNEL, _METADATA) else None
        except _BROKEN as error:
            return self._note(offset, f"a record is broken: {error}")
        if opcode == _METADATA:
            self.notes = {**self.notes, **record.metadata}
        elif record:
            (self._channels if opcode == _CHANNEL else self._schemas)[record.id] = record
        return None

    def _connection(self, channel: Any) -> Connection:  # noqa: ANN401 - a record of mcap
        schema = self._schemas.get(channel.schema_id)
        encoding, name = channel.message_encoding, schema.name if schema else ""
        if encoding == "ros1" and "/msg/" not in name:  # as rosbags spells ROS types
            name = name.replace("/", "/msg/", 1)
        definition = (schema.encoding, schema.data) if schema else ("", b"")
        return Connection(channel.id, channel.topic, name, encoding, definition, self._counts[channel.id])


def _times_of_chunk(file: BinaryIO) -> tuple[int, int]:
    """Return log times of the first and last message of the chunk that begins here, and go back there. [ns]"""
    times = file.read(_CHUNK_TIMES.size)
    file.seek(-len(times), SEEK_CUR)
    first, last = _CHUNK_TIMES.unpack(times.ljust(_CHUNK_TIMES.size, b"\xff"))
    return first, last


def _parse(opcode: int, content: bytes) -> Any:  # noqa: ANN401
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import EndOfFile
    from mcap.records import Channel, Chunk, Metadata, Schema

    kinds: dict[int, Any] = {_CHUNK: Chunk, _SCHEMA: Schema, _CHANNEL: Channel, _METADATA: Metadata}
    try:
        return kinds[opcode].read(ReadDataStream(BytesIO(content)))
    except EndOfFile as error:
        raise EOFError("it ends early") from error  # without a text of its own in the library


read, topics = partial(read_messages, McapStream), partial(topics_of, McapStream)
