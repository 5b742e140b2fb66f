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

from friction_audit.io.readers.message_stream import Block

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc, Typesdict


_CDR_HEADER_BYTES = 4
_CDR_LITTLE_ENDIAN = b"\x00\x01"
_CDR_TRAILING_PADDING_BYTES = 3
_NUMBER_TYPES = {"bool": "u1", "byte": "u1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "<i2",
                 "uint16": "<u2", "int32": "<i4", "uint32": "<u4", "int64": "<i8", "uint64": "<u8", "float32": "<f4",
                 "float64": "<f8"}  # fmt: skip

Records = NDArray[np.void]


class LayoutError(Exception):
    """The payload does not fit its definition, or the definition has no constant layout."""


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
            buffer, start, stride = b"".join(block.payload(index) for index in range(count)), 0, size
        rows = np.ndarray((count, size), np.uint8, buffer, offset=start, strides=(stride, 1))
        if not (rows[:, self.fixed] == self.content).all():
            return None
        leaves = [self.numbers[path] for path in paths]
        formats = [(leaf.dtype, (leaf.count,)) for leaf in leaves]
        offsets = [leaf.offset for leaf in leaves]
        kind = np.dtype({"names": list(paths), "formats": formats, "offsets": offsets, "itemsize": size})
        return np.ndarray((count,), kind, buffer, offset=start, strides=(stride,))


def find_layout(payload: bytes, typename: str, types: "Typesdict", *, encoding: str) -> Layout:
    """Walk a message definition over one payload; LayoutError if they do not fit, or the payload is big-endian."""
    if encoding == "cdr" and payload[:2] != _CDR_LITTLE_ENDIAN:
        raise LayoutError("not little-endian plain CDR")
    walk = _Walk(payload, types, is_cdr=encoding == "cdr")
    try:
        walk.message(typename, "")
    except (struct.error, UnicodeDecodeError, KeyError) as error:
        raise LayoutError(str(error)) from error
    spare = len(payload) - walk.position
    if spare < 0 or spare > (_CDR_TRAILING_PADDING_BYTES if walk.is_cdr else 0):
        raise LayoutError(f"{spare} bytes left over")
    fixed = np.flatnonzero(walk.fixed)
    return Layout(len(payload), walk.numbers, walk.strings, fixed, np.frombuffer(payload, np.uint8)[fixed])


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
            self.field(description, prefix + name)

    def field(self, description: "FieldDesc", path: str) -> None:
        # Node types of rosbags: 1 a base type, 2 a named message, 3 an array, 4 a sequence (with its length before it).
        node: Any = int(description[0])
        detail: Any = description[1]
        count = None
        if node > 2:  # noqa: PLR2004
            (inner, detail), size = detail
            node, count = int(inner), size if node == 3 else self.length()  # noqa: PLR2004
        if node == 1 and detail[0] == "string":
            self.strings[path] = tuple(self.string() for _ in range(1 if count is None else count))
        elif node == 1:
            self.numeric(detail[0], path, 1 if count is None else count)
        else:
            for index in range(1 if count is None else count):
                self.message(detail, f"{path}." if count is None else f"{path}[{index}].")

    def numeric(self, base: str, path: str, count: int) -> None:
        if base not in _NUMBER_TYPES:
            raise LayoutError(f"{path} is of type {base}")
        width = np.dtype(_NUMBER_TYPES[base]).itemsize
        if count:
            self.align(width)
        if self.position + count * width > len(self.payload):
            raise LayoutError(f"{path} ends after the payload")
        self.numbers[path] = Leaf(self.position, _NUMBER_TYPES[base], count)
        self.position += count * width

    def length(self) -> int:
        self.align(4)
        (value,) = struct.unpack_from("<I", self.payload, self.position)
        self.fixed[self.position : self.position + 4] = True
        self.position += 4
        if value > len(self.payload):
            raise LayoutError(f"a sequence of {value} elements")
        return int(value)

    def string(self) -> str:
        size = self.length()
        content = self.payload[self.position : self.position + size]
        if len(content) < size or (self.is_cdr and content[-1:] != b"\x00"):
            raise LayoutError("a string without end")
        self.fixed[self.position : self.position + size] = True
        self.position += size
        return (content[:-1] if self.is_cdr else content).decode()

    def align(self, width: int) -> None:
        if self.is_cdr:
            self.position += -(self.position - _CDR_HEADER_BYTES) % width
