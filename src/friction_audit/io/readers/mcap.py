"""MCAP files -> Recording: ROS 2 (CDR), ROS 1, JSON and protobuf messages, also from files that break off."""

import struct
from collections.abc import Collection, Iterator
from contextlib import suppress
from functools import partial
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from zlib import crc32

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.message_kinds import LATEST_TIME_NS
from friction_audit.io.readers.message_stream import (
    LARGEST_CHUNK,
    Block,
    BlockCollector,
    Connection,
    MessageStream,
    Window,
    block_of_payloads,
    open_log,
)
from friction_audit.io.readers.messages import read_messages, topics_of

if TYPE_CHECKING:
    from mcap.records import Channel, Chunk, Schema

MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA = 3, 4, 5, 6, 12  # opcodes of records
# What the mcap library raises on a record that is not what its opcode says.
_BROKEN = (struct.error, UnicodeDecodeError, EOFError, OverflowError)
# Opcode -> length of the footer and of the end of the data section: another length is a broken record.
_END_LENGTHS = {2: 20, 15: 4}
_CHUNK_TIMES = struct.Struct("<QQ")
_RECORD_START = struct.Struct("<BQ")
_MESSAGE_TIME = struct.Struct("<HIQ")  # channel, sequence, log time
_MESSAGE_HEADER = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log_time", "<u8"), ("sent", "<u8")]
)
_MESSAGE_FIELDS_BYTES = _MESSAGE_HEADER.itemsize - _RECORD_START.size
_LOOSE_MESSAGES_PER_BLOCK = 8192


class McapStream(MessageStream):
    """The messages in one MCAP file.

    The records are walked one after another, which needs neither an index nor a footer; the messages within a chunk
    are found here too, and not by the mcap library, since that is where the time would go.
    """

    def __init__(self, path: Path) -> None:
        """Find the channels, from the summary at the end or, where that is missing, by reading everything once."""
        super().__init__(path)
        self._cut_chunk: int | None = None
        self._channels: dict[int, Channel] = {}
        self._schemas: dict[int, Schema] = {}
        self._counts: dict[int, int] = {}
        with open_log(path) as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise InputError(
                    f"{path}: {'is empty' if not self._bytes else 'does not begin as an MCAP file'}; "
                    "expected the bytes 89 4D 43 41 50 30 0D 0A; check the file's type and that it was copied whole"
                )
            is_whole = self._read_summary(file)
        if not is_whole:
            self._scan()
            if self._damage and not self._channels:
                raise InputError(
                    f"{path}: breaks off at byte {min(map(int, self._damage))} of {self._bytes} before the first whole "
                    "chunk; no message can be saved; copy it again or record again"
                )
        self.connections = tuple(map(self._connection, self._channels.values()))

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some channels, chunk by chunk; chunks outside the window are passed over."""
        loose: dict[int, tuple[list[int], list[bytes]]] = {key: ([], []) for key in keys}
        for opcode, offset, record in self._records(window):
            if opcode == _CHUNK:
                data = self._decompress(record, offset)
                blocks, broken = ([], "") if data is None else _find_messages(data, loose.keys())
                if broken:
                    self._note(offset, broken)
                yield from blocks
            elif opcode == _MESSAGE and record.channel_id in loose:
                times, payloads = loose[record.channel_id]
                times.append(record.log_time & LATEST_TIME_NS)
                payloads.append(record.data)
                if len(payloads) == _LOOSE_MESSAGES_PER_BLOCK:
                    yield block_of_payloads(record.channel_id, times, payloads)
                    loose[record.channel_id] = ([], [])
        for key, (times, payloads) in loose.items():
            if payloads:
                yield block_of_payloads(key, times, payloads)

    def _records(self, window: Window | None = None) -> Iterator[tuple[int, int, Any]]:
        """Yield opcode, offset and content of chunks, and of what lies outside chunks; up to a break.

        Index records are passed over unread: the stream reader of the mcap library spends half its time on them.
        """
        with open_log(self._path) as file:
            offset = len(MAGIC)
            while True:
                file.seek(offset)
                start = file.read(_RECORD_START.size)
                if len(start) < _RECORD_START.size:
                    return self._note(offset, "it ends without the closing records")
                opcode, length = _RECORD_START.unpack(start)
                if length == _END_LENGTHS.get(opcode):
                    return None
                if offset + _RECORD_START.size + length > self._bytes:
                    yield from self._begun_record(opcode, offset, file)
                    return None
                if opcode != _CHUNK or window is None or not window.leaves_out(_times_of_chunk(file)):
                    yield from self._whole_record(opcode, offset, file, length)
                offset += _RECORD_START.size + length

    def _whole_record(self, opcode: int, offset: int, file: BinaryIO, length: int) -> Iterator[tuple[int, int, Any]]:
        try:
            if opcode in (_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK):
                yield opcode, offset, _parse(opcode, file.read(length))
            elif opcode == _METADATA:
                self.notes = {**self.notes, **_parse(opcode, file.read(length)).metadata}
        except _BROKEN as error:
            self._note(offset, f"a record is broken: {error}")

    def _begun_record(self, opcode: int, offset: int, file: BinaryIO) -> Iterator[tuple[int, int, Any]]:
        """Yield a chunk that the end of the file cuts; its checksum, which is over all of it, says nothing then."""
        if opcode != _CHUNK:
            return self._note(offset, "a record is cut off")
        with suppress(*_BROKEN):  # where it is cut before its first message
            chunk = _parse(_CHUNK, file.read(LARGEST_CHUNK))
            self._cut_chunk = offset
            yield _CHUNK, offset, chunk
        return self._note(offset, "the last chunk is cut off; its whole messages were read without its checksum")

    def _decompress(self, chunk: "Chunk", offset: int) -> bytes | None:
        """Return the records of a chunk, or None if it is damaged."""
        cut = offset == self._cut_chunk
        data = self._unpack(offset, chunk.compression, chunk.data, chunk.uncompressed_size, cut=cut)
        if data is not None and not cut and chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
            self._note(offset, "a chunk has another checksum than its header says")
            return None
        return data

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
        self._counts = dict(summary.statistics.channel_message_counts)
        self._channels, self._schemas = summary.channels, summary.schemas
        return sum(self._counts.values()) == summary.statistics.message_count

    def _scan(self) -> None:
        """Read the whole file for its channels and the number of their messages."""
        self._channels, self._schemas, self._counts = {}, {}, {}
        for opcode, offset, record in self._records():
            if opcode == _CHUNK:
                self._scan_chunk(self._decompress(record, offset) or b"", offset)
            elif opcode == _MESSAGE:
                self._counts[record.channel_id] = self._counts.get(record.channel_id, 0) + 1
            else:
                self._learn(opcode, record)

    def _scan_chunk(self, data: bytes, offset: int) -> None:
        position = 0
        while position + _RECORD_START.size <= len(data):
            opcode, length = _RECORD_START.unpack_from(data, position)
            position += _RECORD_START.size
            if opcode in (_SCHEMA, _CHANNEL) and position + length <= len(data):
                try:
                    self._learn(opcode, _parse(opcode, data[position : position + length]))
                except _BROKEN as error:
                    self._note(offset, f"a record is broken: {error}")
            position += length
        for block in _find_messages(data, None)[0]:
            self._counts[block.key] = self._counts.get(block.key, 0) + len(block)

    def _learn(self, opcode: int, record: Any) -> None:  # noqa: ANN401
        known: dict[int, Any] = self._channels if opcode == _CHANNEL else self._schemas
        known[record.id] = record

    def _connection(self, channel: "Channel") -> Connection:
        schema = self._schemas.get(channel.schema_id)
        encoding, name = channel.message_encoding, schema.name if schema else ""
        if encoding == "ros1" and "/msg/" not in name:  # as rosbags spells ROS types
            name = name.replace("/", "/msg/", 1)
        return Connection(
            key=channel.id,
            topic=channel.topic,
            type=name,
            encoding=encoding,
            definition=schema.data if schema else b"",
            definition_format=schema.encoding if schema else "",
            messages=self._counts.get(channel.id, 0),
        )


def _times_of_chunk(file: BinaryIO) -> tuple[int, int]:
    """Return log times of the first and last message of the chunk that begins here, and go back there. [ns]"""
    times = file.read(_CHUNK_TIMES.size)
    file.seek(-len(times), SEEK_CUR)
    first, last = _CHUNK_TIMES.unpack(times.ljust(_CHUNK_TIMES.size, b"\xff"))
    return first, last


def _parse(opcode: int, content: bytes) -> Any:  # noqa: ANN401
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import EndOfFile
    from mcap.records import Channel, Chunk, Message, Metadata, Schema

    stream = ReadDataStream(BytesIO(content))
    kinds: dict[int, Any] = {_CHUNK: Chunk, _SCHEMA: Schema, _CHANNEL: Channel, _METADATA: Metadata}
    try:
        return Message.read(stream, len(content)) if opcode == _MESSAGE else kinds[opcode].read(stream)
    except EndOfFile as error:
        raise EOFError("it ends early") from error  # without a text of its own in the library


def _find_messages(data: bytes, keys: Collection[int] | None) -> tuple[list[Block], str]:
    """Find the messages of some channels (None for all) in the records of a chunk, and what is wrong with it."""
    collector, position = BlockCollector(data, keys), 0
    while position + _RECORD_START.size <= len(data):
        opcode, length = _RECORD_START.unpack_from(data, position)
        taken, stride = 1, _RECORD_START.size + length
        if opcode == _MESSAGE:
            if length < _MESSAGE_FIELDS_BYTES or position + stride > len(data):
                break
            channel, _, log_time = _MESSAGE_TIME.unpack_from(data, position + _RECORD_START.size)
            start, size = position + _MESSAGE_HEADER.itemsize, length - _MESSAGE_FIELDS_BYTES
            taken = collector.add(
                channel, log_time & LATEST_TIME_NS, start, size, partial(_run, data, position, length)
            )
        position += taken * stride
    return collector.finish(), "" if position == len(data) else "a message runs over the end of its chunk"


def _run(data: bytes, position: int, length: int) -> Block:
    """View the messages from here on that are as long as the first one and of its channel."""
    stride = _RECORD_START.size + length
    count = (len(data) - position) // stride
    heads = np.ndarray((count,), _MESSAGE_HEADER, data, offset=position, strides=(stride,))
    same = (heads["length"] == length) & (heads["opcode"] == _MESSAGE) & (heads["channel"] == heads["channel"][0])
    run = count if same.all() else int(same.argmin())
    start = position + _MESSAGE_HEADER.itemsize + stride * np.arange(run, dtype=np.int64)
    size = np.full(run, length - _MESSAGE_FIELDS_BYTES, np.int64)
    return Block(int(heads["channel"][0]), heads["log_time"][:run].astype(np.int64), data, start, size)


read, topics = partial(read_messages, McapStream), partial(topics_of, McapStream)


def recognises(path: Path) -> bool:
    """Return True if the file begins as MCAP does."""
    return starts_with(path, MAGIC)
