"""Where each number lies in a serialised message.

CDR aligns every primitive to its own size, counted from after the four bytes of the encapsulation header, and ends
strings with a zero; ROS 1 does neither.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.message_stream import Block, BrokenError

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

# Node types of rosbags; 1 is a base type, 4 a sequence, whose length lies before it.
_MESSAGE, _ARRAY = 2, 3
_CDR_HEADER_BYTES = 4
_CDR_LITTLE_ENDIAN = b"\x00\x01"
_CDR_TRAILING_PADDING_BYTES = 3
_NUMBER_TYPES = {"bool": "u1", "byte": "u1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "<i2",
                 "uint16": "<u2", "int32": "<i4", "uint32": "<u4", "int64": "<i8", "uint64": "<u8", "float32": "<f4",
                 "float64": "<f8"}  # fmt: skip

Records = NDArray[np.void]


@dataclass(frozen=True, slots=True)
class Leaf:
    """Numbers at a fixed place."""

    offset: int  # from the start of the payload [byte]
    dtype: str  # of one number
    count: int


@dataclass(frozen=True, eq=False, slots=True)
class Layout:
    """Layout of one payload."""

    size: int  # length of the payload [byte]
    numbers: Mapping[str, Leaf]  # dotted path of a field -> where its numbers lie
    strings: Mapping[str, tuple[str, ...]]  # dotted path of a string or of an array of strings -> its content
    # Offsets of the bytes that decide the layout (string and sequence lengths, string contents, CDR header): payloads
    # of the same size that agree in these bytes have the same layout and the same strings.
    fixed: NDArray[np.intp]
    content: NDArray[np.uint8]  # these bytes

    def records(self, block: Block, paths: Sequence[str]) -> Records | None:
        """View a block as records, one per message, one field per path; None if any message is laid out differently."""
        size, count = self.size, len(block)
        if not self.numbers.keys() >= {*paths} or not (block.size == size).all():
            return None
        buffer, start, steps = block.buffer, int(block.start[0]), np.diff(block.start)
        stride = int(steps[0]) if count > 1 else size
        if stride < size or not (steps == stride).all():  # the payloads are not at a constant distance
            buffer, start, stride = b"".join(block.payloads()), 0, size
        rows = np.ndarray((count, size), np.uint8, buffer, offset=start, strides=(stride, 1))
        if not (rows[:, self.fixed] == self.content).all():
            return None
        leaves = [self.numbers[path] for path in paths]
        formats = [(leaf.dtype, (leaf.count,)) for leaf in leaves]
        offsets = [leaf.offset for leaf in leaves]
        kind = np.dtype({"names": list(paths), "formats": formats, "offsets": offsets, "itemsize": size})
        return np.ndarray((count,), kind, buffer, offset=start, strides=(stride,))


def find_layout(payload: bytes, typename: str, types: "Typesdict", *, encoding: str) -> Layout:
    """Walk a message definition over one payload; BrokenError if they do not fit, or the payload is big-endian."""
    if encoding == "cdr" and payload[:2] != _CDR_LITTLE_ENDIAN:
        raise BrokenError("not little-endian plain CDR")
    walk = _Walk(payload, types, is_cdr=encoding == "cdr")
    try:
        walk.message(typename, "")
    except (struct.error, UnicodeDecodeError, KeyError) as error:
        raise BrokenError(str(error)) from error
    spare = len(payload) - walk.position
    if spare < 0 or spare > (_CDR_TRAILING_PADDING_BYTES if walk.is_cdr else 0):
        raise BrokenError(f"{spare} bytes left over")
    fixed = np.flatnonzero(walk.fixed)
    return Layout(len(payload), walk.numbers, walk.strings, fixed, np.frombuffer(payload, np.uint8)[fixed])


def element_of(description: Any) -> tuple[bool, Any, int | None]:  # noqa: ANN401
    """Return of a field, or of a list's elements: whether it is a message, its type, the list's length (-1: any)."""
    node, detail = description
    if node <= _MESSAGE:
        return node == _MESSAGE, detail, None
    (inner, detail), size = detail
    return inner == _MESSAGE, detail, size if node == _ARRAY else -1


class _Walk:
    def __init__(self, payload: bytes, types: "Typesdict", *, is_cdr: bool) -> None:
        self.payload, self.types, self.is_cdr = payload, types, is_cdr
        self.numbers: dict[str, Leaf] = {}
        self.strings: dict[str, tuple[str, ...]] = {}
        self.fixed = np.zeros(len(payload), bool)
        self.position = _CDR_HEADER_BYTES if is_cdr else 0
        self.fixed[: len(_CDR_LITTLE_ENDIAN) if is_cdr else 0] = True

    def message(self, typename: str, prefix: str) -> None:
        for name, description in self.types[typename][1]:
            path, (is_message, detail, size) = prefix + name, element_of(description)
            count = 1 if size is None else self.length() if size < 0 else size
            if is_message:
                for index in range(count):
                    self.message(detail, f"{path}." if size is None else f"{path}[{index}].")
            elif detail[0] == "string":
                self.strings[path] = tuple(self.string() for _ in range(count))
            else:
                self.numeric(detail[0], path, count)

    def numeric(self, base: str, path: str, count: int) -> None:
        if base not in _NUMBER_TYPES:
            raise BrokenError(f"{path} is of type {base}")
        width = np.dtype(_NUMBER_TYPES[base]).itemsize
        if count:
            self.align(width)
        if self.position + count * width > len(self.payload):
            raise BrokenError(f"{path} ends after the payload")
        self.numbers[path] = Leaf(self.position, _NUMBER_TYPES[base], count)
        self.position += count * width

    def length(self) -> int:
        self.align(4)
        (value,) = struct.unpack_from("<I", self.payload, self.position)
        self.fixed[self.position : self.position + 4] = True
        self.position += 4
        if value > len(self.payload):
            raise BrokenError(f"a sequence of {value} elements")
        return int(value)

    def string(self) -> str:
        size = self.length()
        content = self.payload[self.position : self.position + size]
        if len(content) < size or (self.is_cdr and content[-1:] != b"\x00"):
            raise BrokenError("a string without end")
        self.fixed[self.position : self.position + size] = True
        self.position += size
        return (content[:-1] if self.is_cdr else content).decode()

    def align(self, width: int) -> None:
        if self.is_cdr:
            self.position += -(self.position - _CDR_HEADER_BYTES) % width
