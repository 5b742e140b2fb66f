"""Messages as containers hand them over: decompressed, in blocks."""

import re
from abc import abstractmethod
from bz2 import BZ2Decompressor
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from io import BytesIO
from math import inf
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from friction_audit.errors import InputError
from friction_audit.joint_log import Bool, Int

# Joint states that are all zero are packed 36 times (7 joints, zstd) to 1 000 times (1 000 joints), bombs 25 000 times.
MOST_TIMES_PACKED = 4000
_SMALLEST_BOUND = 1 << 20  # below it the ratio is not checked [byte]
# Recorders close a chunk after 0.75 to 16 MB; a larger one would have to lie in memory as a whole. [byte]
LARGEST_CHUNK = 256 << 20
LARGEST_MESSAGE = 1 << 20  # the state of a thousand joints takes 50 kB; a message of a gigabyte is a bomb [byte]
ZSTD = b"\x28\xb5\x2f\xfd"  # what it begins with


class BrokenError(Exception):
    """A part of a file is not what it claims to be: a definition, a record, packed data, a payload."""


def bound_of(packed_bytes: int) -> int:
    """Return how large data can be at most that were packed into so many bytes."""
    return max(_SMALLEST_BOUND, MOST_TIMES_PACKED * packed_bytes)


def unpack(compression: str, packed: bytes, claimed: int, *, cut: bool = False) -> bytes:
    """Decompress data up to the size that a header claims, BrokenError if they have another; of ``cut`` data all."""
    if compression in ("none", ""):
        return packed
    most = min(bound_of(len(packed)), LARGEST_CHUNK)
    if claimed > most and not cut:
        raise BrokenError(f"{len(packed)} bytes claim to hold {claimed}, expected at most {most}")
    try:
        data = _decompress(compression, packed, min(claimed, most))
    except (OSError, EOFError, ValueError, RuntimeError, MemoryError) as error:
        raise BrokenError(str(error) or "not enough memory") from error
    if len(data) != claimed and not cut:
        held = "more" if len(data) > claimed else f"only {len(data)}"
        raise BrokenError(f"{len(packed)} bytes claim to hold {claimed} bytes, and hold {held}")
    return data


def _decompress(compression: str, packed: bytes, limit: int) -> bytes:
    """Decompress as far as it goes, up to one byte more than the limit."""
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
    from zstandard import ZstdDecompressor, ZstdError, frame_content_size

    if compression != "zstd":
        if compression not in ("bz2", "lz4"):
            raise ValueError(f"unknown compression {compression!r}")
        made = BZ2Decompressor() if compression == "bz2" else LZ4FrameDecompressor()
        return bytes(made.decompress(packed, max_length=limit + 1))
    with suppress(ZstdError):  # the stream says what is wrong; it reads cut frames too, and takes 1.3 times as long
        if frame_content_size(packed) == limit:
            return ZstdDecompressor().decompress(packed, max_output_size=limit)
    try:
        with ZstdDecompressor().stream_reader(BytesIO(packed)) as stream:
            return stream.read(limit + 1)
    except ZstdError as error:
        raise ValueError(str(error)) from error


_SHORTEST_RUN = 16  # a shorter run of equally long messages means that topics alternate: no more runs are looked for


@dataclass(frozen=True, slots=True)
class Connection:
    """One publisher's stream in a file; several connections may share a topic."""

    key: int  # what the container calls it, unique in the stream
    topic: str  # topic name, with its leading slash if the file has one
    type: str  # message type, package/msg/Name for ROS
    encoding: str  # how payloads are serialised: "ros1", "cdr", "json", "protobuf" or something else
    # Language ("ros2msg", "ros2idl", "protobuf"...) and text of the definition in the file, empty if it has none.
    definition: tuple[str, bytes] = ("", b"")
    messages: int = 0  # number of messages


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """Consecutive messages of one connection: payloads as ranges of one buffer."""

    key: int  # key of the connection
    log_time: Int  # time at which each message was recorded, shape (n,) [ns]
    buffer: Any  # bytes that hold all payloads, or a map of a file
    start: Int  # offset of each payload in the buffer, shape (n,)
    size: Int  # length of each payload, shape (n,) [byte]

    def __len__(self) -> int:
        return len(self.log_time)

    def payloads(self) -> Iterator[bytes]:
        """Yield all payloads."""
        for start, size in zip(self.start.tolist(), self.size.tolist(), strict=True):
            yield self.buffer[start : start + size]


@dataclass(slots=True)
class Window:
    """A part of a log by the time of recording, and what was left out on either side of it."""

    first: float  # log time of its start [ns]
    last: float  # log time of its end [ns]
    before: bool = False  # true if messages before it were left out
    after: bool = False  # true if messages after it were left out
    latest: float = -inf  # latest log time of the messages left out before it [ns]

    def keeps(self, first: ArrayLike, last: ArrayLike) -> Bool:
        """Return which stretches of log time reach inside, and note what does not; one that runs back is kept."""
        first, last = np.atleast_1d(first), np.atleast_1d(last)
        earlier, later = (first <= last) & (last < self.first), (first <= last) & (first > self.last)
        self.after |= bool(later.any())
        if earlier.any():
            self.before, self.latest = True, max(self.latest, float(last[earlier].max()))
        return ~(earlier | later)


class MessageStream(AbstractContextManager["MessageStream"]):
    """An open container of messages."""

    magic, kind = b"", ""  # what a file begins with, and what it then is
    largest_chunk = LARGEST_CHUNK
    connections: tuple[Connection, ...]  # in the file
    is_lasting = True  # False if what it reads is deleted when it is closed
    stated: Mapping[str, int] = {}  # number of messages of each topic that a file next to it states
    notes: Mapping[str, str] = {}  # what the file says of its own by name; complete once all blocks have been read

    def __init__(self, path: Path) -> None:
        """Open the file; InputError if nothing in it can be read."""
        self._path, self._bytes = path, path.stat().st_size
        # What was found broken: file and place, or reason -> where and why, and the byte up to which it was sound.
        self.damage: dict[tuple[Path, int | str], tuple[str, int | None]] = {}

    def __exit__(self, *_: object) -> None:
        """Keep nothing: files are open only while they are read."""

    @abstractmethod
    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some connections, in the order of the file; the window may be exceeded."""

    @contextmanager
    def _open(self) -> Iterator[BinaryIO]:
        """Open the file for reading after its first bytes; InputError if they are others, or it cannot be read."""
        try:
            with self._path.open("rb") as file:
                if (found := file.read(len(self.magic))) != self.magic:
                    how = f"does not begin as {self.kind}" if found else "is empty"
                    raise InputError(f"{self._path}: {how}; expected the bytes {self.magic!r}; copy it whole")
                yield file
        except OSError as error:
            why = f"cannot be read: {error.strerror}; check the path and its permissions"
            raise InputError(f"{self._path}: {why}") from error

    def _note(self, byte: int | None, reason: str, whole: int | None = None) -> None:
        place = "" if byte is None else f" at byte {byte} of {whole or self._bytes}"
        self.damage[self._path, reason if byte is None else byte] = f"{place} ({reason})", byte

    def _refuse_without(self, found: Collection[object], first: str) -> None:
        """Refuse a damaged file in which nothing was found."""
        if self.damage and not found:
            where = f"byte {min(byte or 0 for _, byte in self.damage.values())} of {self._bytes}"
            raise InputError(f"{self._path}: breaks off at {where} before the first whole {first}; copy it again")

    def _decompressed(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """Yield blocks of messages; where a recorder has compressed each message, decompressed."""
        for block in blocks:
            packed = block.buffer.startswith(ZSTD, int(block.start[0]))
            rows = list(zip(block.log_time.tolist(), block.payloads(), strict=True)) if packed else []
            if plain := self._block(block.key, rows) if packed else block:
                yield plain

    def _block(self, key: int, rows: Sequence[tuple[Any, ...]]) -> Block | None:
        """Join messages; what is no time stamp with bytes, or cannot be decompressed, is left out."""
        sound = [(time, own) for *_, time, raw in rows if isinstance(time, int) and (own := _message(raw)) is not None]
        if len(sound) < len(rows):
            self._note(None, "messages without time stamp or bytes, or with broken compression, were left out")
        return one_block(key, *zip(*sound, strict=True)) if sound else None

    def _unpack(self, offset: int, compression: str, packed: bytes, claimed: int, *, cut: bool) -> bytes | None:
        """Return the records of the chunk at an offset, None if they cannot be decompressed."""
        try:
            return unpack(compression, packed, claimed, cut=cut)
        except BrokenError as error:
            self._note(offset, f"a chunk cannot be decompressed: {error}")
            return None


class Heads(NamedTuple):
    """What the records of a connection's messages look like up to their payloads."""

    width: int  # their length [byte]
    constant: tuple[slice, ...]  # bytes that they share if the payloads are equally long: no clocks and counters
    clock: int  # where the eight bytes of the log time begin
    in_ns: Callable[[NDArray[np.uint8]], Int]  # from these bytes, shape (n, 8), to the log time
    pattern: re.Pattern[bytes] | None = None  # what one looks like, where writers differ


class BlockCollector:
    """The messages of a chunk as blocks: runs of equally long ones at once, or one by one where topics alternate."""

    def __init__(self, data: bytes, keys: Collection[int] | None) -> None:
        """Keep the chunk's records, and the keys of the connections wanted, None for all."""
        self._data, self._keys, self._alternating, self._blocks = data, keys, False, list[Block]()
        self._mixed = defaultdict[int, list[tuple[int, int, int]]](list)

    def add(self, key: int, time: int, start: int, size: int, heads: Heads) -> int:
        """Add a message, or the run that begins with it; returns how many bytes were taken."""
        wanted, stride = self._keys is None or key in self._keys, heads.width + size
        if self._alternating:
            if wanted:
                self._mixed[key].append((start, size, time))
            return stride
        begin = start - heads.width
        count = (len(self._data) - begin) // stride
        rows = np.ndarray((count, heads.width), np.uint8, self._data, offset=begin, strides=(stride, 1))
        same, run = [rows[:, part] == rows[0, part] for part in heads.constant], count
        if not all(map(np.all, same)):  # to look at each row takes several times as long
            run = int(np.logical_and.reduce([part.all(axis=1) for part in same]).argmin())
        if wanted:
            log_time = heads.in_ns(np.ascontiguousarray(rows[:run, heads.clock : heads.clock + 8]))
            starts = start + stride * np.arange(run, dtype=np.int64)
            self._blocks.append(Block(key, log_time, self._data, starts, np.full(run, size, np.int64)))
        self._alternating = run < _SHORTEST_RUN
        return run * stride

    def finish(self) -> list[Block]:
        """Return all blocks."""
        for key, entries in self._mixed.items():
            start, size, log_time = np.array(entries, np.int64).T
            self._blocks.append(Block(key, log_time, self._data, start, size))
        return self._blocks


def one_block(key: int, log_time: Sequence[int], payloads: Sequence[bytes]) -> Block:
    """Join separate payloads into one block."""
    size = np.fromiter(map(len, payloads), np.int64, len(payloads))
    start = np.concatenate(([0], np.cumsum(size)[:-1])).astype(np.int64)
    return Block(key, np.array(log_time, np.int64), b"".join(payloads), start, size)


def _message(data: object) -> bytes | None:
    """Return a message, decompressed if it was compressed: no CDR message begins as zstd does. None if it is broken."""
    if not isinstance(data, bytes) or not data.startswith(ZSTD):
        return data if isinstance(data, bytes) else None
    from zstandard import ZstdError, frame_content_size

    try:
        size = frame_content_size(data)
        return unpack("zstd", data, LARGEST_MESSAGE if size < 0 else size, cut=size < 0)
    except (BrokenError, ZstdError):
        return None
