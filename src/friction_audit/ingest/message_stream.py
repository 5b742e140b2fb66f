"""A recorded stream of messages, whatever the container: its connections, and blocks of undecoded payloads."""

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError

Int = NDArray[np.int64]

SHORTEST_RUN = 16
"""A run of equally long messages shorter than this means that topics alternate: no more runs are looked for."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Connection:
    """One publisher's stream in a file; several connections may share a topic.

    Attributes:
        key: What the container calls it, unique in the stream.
        topic: Topic name, with its leading slash if the file has one.
        type: Message type, ``package/msg/Name`` for ROS.
        encoding: How payloads are serialised: ``"ros1"``, ``"cdr"``, ``"json"``, ``"protobuf"`` or something else.
        definition: The message definition that the file carries, empty if it carries none.
        definition_format: Language of the definition, e.g. ``"ros2msg"``, ``"ros2idl"``, ``"protobuf"``.
        messages: Number of messages, or None when the file does not tell.
    """

    key: int
    topic: str
    type: str
    encoding: str
    definition: bytes = b""
    definition_format: str = ""
    messages: int | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """Consecutive messages of one connection: payloads as ranges of one buffer.

    Attributes:
        key: Key of the connection.
        log_time: Time at which each message was recorded, shape (n,). [ns]
        buffer: Bytes that hold all payloads.
        start: Offset of each payload in the buffer, shape (n,).
        size: Length of each payload, shape (n,). [byte]
    """

    key: int
    log_time: Int
    buffer: bytes
    start: Int
    size: Int

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.log_time)

    def payload(self, index: int) -> bytes:
        """Return one payload."""
        first = int(self.start[index])
        return self.buffer[first : first + int(self.size[index])]


@dataclass(slots=True)
class Window:
    """A part of a log by the time of recording, and what was left out on either side of it.

    Attributes:
        first: Log time of its start. [ns]
        last: Log time of its end. [ns]
        before: True if messages before it were left out.
        after: True if messages after it were left out.
        latest: Latest log time of the messages left out before it. [ns]
    """

    first: float
    last: float
    before: bool = False
    after: bool = False
    latest: float = -inf

    def leaves_out(self, times: tuple[int, int]) -> bool:
        """Return True if messages from one log time to another lie outside; times that run back are not trusted."""
        first, last = times
        earlier, later = first <= last < self.first, last >= first > self.last
        self.after |= later
        if earlier:
            self.before, self.latest = True, max(self.latest, last)
        return earlier or later

    def part_of(self, block: "Block") -> "Block":
        """Return the messages of a block that lie inside."""
        earlier, later = block.log_time < self.first, block.log_time > self.last
        self.after |= bool(later.any())
        if earlier.any():
            self.before, self.latest = True, max(self.latest, float(block.log_time[earlier].max()))
        kept = ~(earlier | later)
        return Block(block.key, block.log_time[kept], block.buffer, block.start[kept], block.size[kept])


@dataclass(frozen=True, slots=True)
class Damage:
    """Where a file is broken.

    Attributes:
        byte: Offset in the file up to which everything was sound, or None where that is not known.
        file_bytes: Length of the file.
        reason: What is wrong there.
    """

    byte: int | None
    file_bytes: int
    reason: str


class MessageStream(Protocol):
    """What every container offers; ``damage`` is complete once all blocks have been read."""

    @property
    def connections(self) -> tuple[Connection, ...]:
        """Connections in the file."""

    @property
    def damage(self) -> tuple[Damage, ...]:
        """What was found broken so far."""

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some connections, in the order of the file; the window may be exceeded."""


def block_of_ranges(key: int, buffer: bytes, ranges: Sequence[tuple[int, int, int]]) -> Block:
    """Make a block of the offset, length and time of each payload in a buffer."""
    start, size, log_time = np.array(ranges, np.int64).T
    return Block(key, log_time, buffer, start, size)


def block_of_payloads(key: int, log_time: Sequence[int], payloads: Sequence[bytes]) -> Block:
    """Join separate payloads into one block."""
    size = np.fromiter(map(len, payloads), np.int64, len(payloads))
    start = np.concatenate(([0], np.cumsum(size)[:-1])).astype(np.int64)
    return Block(key, np.array(log_time, np.int64), b"".join(payloads), start, size)


@contextmanager
def open_log(path: Path) -> Iterator[BinaryIO]:
    """Open a log for reading.

    Raises:
        InputError: If the file cannot be opened or read.
    """
    try:
        with path.open("rb") as file:
            yield file
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check the path and its permissions") from error
