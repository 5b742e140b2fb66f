"""What every container of messages offers: connections, and their messages in blocks."""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError

Int = NDArray[np.int64]
_SHORTEST_RUN = 16  # a shorter run of equally long messages means that topics alternate: no more runs are looked for


@dataclass(frozen=True, kw_only=True, slots=True)
class Connection:
    """One publisher's stream in a file; several connections may share a topic."""

    key: int  # what the container calls it, unique in the stream
    topic: str  # topic name, with its leading slash if the file has one
    type: str  # message type, package/msg/Name for ROS
    encoding: str  # how payloads are serialised: "ros1", "cdr", "json", "protobuf" or something else
    definition: bytes = b""  # the message definition that the file carries, empty if it carries none
    definition_format: str = ""  # language of the definition, e.g. "ros2msg", "ros2idl", "protobuf"
    messages: int | None = None  # number of messages, or None when the file does not say


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """Consecutive messages of one connection: payloads as ranges of one buffer."""

    key: int  # key of the connection
    log_time: Int  # time at which each message was recorded, shape (n,) [ns]
    buffer: bytes  # bytes that hold all payloads
    start: Int  # offset of each payload in the buffer, shape (n,)
    size: Int  # length of each payload, shape (n,) [byte]

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.log_time)

    def payload(self, index: int) -> bytes:
        """Return one payload."""
        first = int(self.start[index])
        return self.buffer[first : first + int(self.size[index])]


@dataclass(slots=True)
class Window:
    """A part of a log by the time of recording, and what was left out on either side of it."""

    first: float  # log time of its start [ns]
    last: float  # log time of its end [ns]
    before: bool = False  # true if messages before it were left out
    after: bool = False  # true if messages after it were left out
    latest: float = -inf  # latest log time of the messages left out before it [ns]

    def leaves_out(self, times: tuple[int, int]) -> bool:
        """Return True if messages from one log time to another lie outside; times that run back are not trusted."""
        first, last = times
        earlier, later = first <= last < self.first, last >= first > self.last
        self.after |= later
        if earlier:
            self.before, self.latest = True, max(self.latest, last)
        return earlier or later

    def part_of(self, block: Block) -> Block:
        """Return the messages of a block that lie inside."""
        earlier, later = block.log_time < self.first, block.log_time > self.last
        self.after |= bool(later.any())
        if earlier.any():
            self.before, self.latest = True, max(self.latest, float(block.log_time[earlier].max()))
        kept = ~(earlier | later)
        return Block(block.key, block.log_time[kept], block.buffer, block.start[kept], block.size[kept])


@dataclass(frozen=True, slots=True)
class Damage:
    """Where a file is broken: ``byte`` is the offset up to which it was sound, None where that is not known."""

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


class BlockCollector:
    """The messages of a chunk as blocks: runs of equally long ones at once, or one by one where topics alternate."""

    def __init__(self, data: bytes, keys: Collection[int] | None) -> None:
        """Keep the chunk's records, and the keys of the connections wanted, None for all."""
        self.blocks: list[Block] = []
        self._data, self._keys = data, keys
        self._mixed: dict[int, list[tuple[int, int, int]]] = {}
        self._alternating = False

    def add(self, key: int, time: int, start: int, size: int, run: Callable[[], Block]) -> int:
        """Add a message, or the run that begins with it; returns how many messages were taken."""
        wanted = self._keys is None or key in self._keys
        if self._alternating:
            if wanted:
                self._mixed.setdefault(key, []).append((start, size, time))
            return 1
        block = run()
        if wanted:
            self.blocks.append(block)
        self._alternating = len(block) < _SHORTEST_RUN
        return len(block)

    def finish(self) -> list[Block]:
        """Return all blocks."""
        for key, entries in self._mixed.items():
            start, size, log_time = np.array(entries, np.int64).T
            self.blocks.append(Block(key, log_time, self._data, start, size))
        return self.blocks


def block_of_payloads(key: int, log_time: Sequence[int], payloads: Sequence[bytes]) -> Block:
    """Join separate payloads into one block."""
    size = np.fromiter(map(len, payloads), np.int64, len(payloads))
    start = np.concatenate(([0], np.cumsum(size)[:-1])).astype(np.int64)
    return Block(key, np.array(log_time, np.int64), b"".join(payloads), start, size)


@contextmanager
def open_log(path: Path) -> Iterator[BinaryIO]:
    """Open a log for reading; InputError if it cannot be opened or read."""
    try:
        with path.open("rb") as file:
            yield file
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check the path and its permissions") from error
