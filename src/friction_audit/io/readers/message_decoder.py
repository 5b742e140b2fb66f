"""Decoders of messages: ROS through rosbags or by where each number lies, JSON, protobuf by mcap-protobuf-support."""

import json
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.readers.message_stream import Block, BrokenError, Connection

Types = dict[str, Any]  # definitions of messages by name, as rosbags has them
# Files in franka_msgs/, in the order in which they are tried.
_FRANKA_GENERATIONS = ("FrankaRobotState_nested", "FrankaState_flat", "FrankaState_multipanda")
_FRANKA_TYPES = ("franka_msgs/msg/FrankaState", "franka_msgs/msg/FrankaRobotState")
_ERRORS = ("Errors_36", "Errors_41")  # which have so many flags
_DEEPEST, _MOST_FIELDS = 64, 100_000  # the largest state message, FrankaRobotState, has some 200 fields in five levels
_SECONDS = {"sec", "secs", "seconds"}  # in the fields of a time stamp
# Node types of rosbags; 1 is a base type, 4 a sequence, whose length lies before it.
_MESSAGE, _ARRAY = 2, 3
_CDR_HEADER_BYTES = 4
_CDR_LITTLE_ENDIAN = b"\x00\x01"
_CDR_TRAILING_PADDING_BYTES = 3
_CLOSE_BYTES = 64  # fixed bytes as close are compared in one go, with what lies between
_NUMBER_TYPES = {"bool": "u1", "byte": "u1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "<i2",
                 "uint16": "<u2", "int32": "<i4", "uint32": "<u4", "int64": "<i8", "uint64": "<u8", "float32": "<f4",
                 "float64": "<f8"}  # fmt: skip

Records = NDArray[np.void]
Fields = Iterator[tuple[str, Any, bool]]  # name of each field of a message, what it holds if fields, whether in a list


class Layout(NamedTuple):
    """Layout of one payload."""

    size: int  # length of the payload [byte]
    numbers: Mapping[str, tuple[np.dtype[Any], int]]  # dotted path of a field -> type of its numbers, where they begin
    strings: Mapping[str, tuple[str, ...]]  # dotted path of a string or of an array of strings -> its content
    # Bits that decide the layout (string and sequence lengths, string contents, CDR header): payloads of the same size
    # that agree in these have the same layout and the same strings.
    fixed: NDArray[np.uint8]
    content: NDArray[np.uint8]  # a payload
    spans: tuple[slice, ...]  # where these bits lie

    def records(self, block: Block, paths: Sequence[str]) -> Records | None:
        """View a block as records, one per message, one field per path; None if any message is laid out differently."""
        size, count = self.size, len(block)
        if not self.numbers.keys() >= {*paths} or not (block.size == size).all():
            return None
        buffer, start, steps = block.buffer, int(block.start[0]), np.diff(block.start)
        stride = int(steps[0]) if count > 1 else size
        if stride < size or not (steps == stride).all():  # the payloads are not at a constant distance
            anywhere = np.ndarray((len(buffer) - size + 1,), f"V{size}", buffer, strides=(1,))
            buffer, start, stride = anywhere[block.start], 0, size
        rows = np.ndarray((count, size), np.uint8, buffer, offset=start, strides=(stride, 1))
        for span in self.spans:
            differs = rows[:, span] ^ self.content[span]
            differs &= self.fixed[span]
            if differs.max():
                return None
        formats, offsets = zip(*(self.numbers[path] for path in paths), strict=True)
        kind = np.dtype({"names": list(paths), "formats": formats, "offsets": offsets, "itemsize": size})
        return np.ndarray((count,), kind, buffer, offset=start, strides=(stride,))


class MessageDecoder(NamedTuple):
    """Decodes payloads of one connection."""

    # Dotted paths of the fields that hold numbers, strings or time stamps, one level of nesting deep; list[].field for
    # the fields of a list's entries.
    paths: tuple[str, ...]
    decode: Callable[[bytes], object]  # decodes one message
    errors: tuple[type[Exception], ...]  # what that raises
    # Finds where the numbers lie in a payload, or raises BrokenError; JSON and protobuf have no constant layout.
    layout: Callable[[bytes], Layout] | None = None


def decoder_for(connection: Connection, payloads: Iterable[bytes]) -> MessageDecoder | None:
    """Make the decoder of a connection; None if its type is not known, BrokenError if its definition is broken."""
    if connection.encoding in ("cdr", "ros1"):
        types = _find_definition(connection, payloads)
        return None if types is None or connection.type not in types else _ros_decoder(connection, types)
    if connection.encoding == "protobuf":
        return _protobuf_decoder(connection)
    paths = dict[str, None]()
    for payload in payloads if connection.encoding == "json" else ():
        with suppress(ValueError, RecursionError):
            paths |= dict.fromkeys(_paths(json.loads(payload), _json_fields))  # lists may be empty in the first message
    return MessageDecoder(tuple(paths), json.loads, (ValueError, RecursionError)) if paths else None


def _ros_decoder(connection: Connection, types: Types) -> MessageDecoder:
    """Return the decoder of ROS 1 or ROS 2 (CDR) messages, through rosbags."""
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_typestore

    encoding, name = connection.encoding, connection.type

    @cache
    def reader() -> Callable[[bytes, str], object]:  # generated when it is first needed
        made = get_typestore(Stores.EMPTY)
        made.register(types)
        return made.deserialize_cdr if encoding == "cdr" else made.deserialize_ros1

    def fields_of(typename: str) -> Fields:
        for field, description in types[typename][1]:
            is_message, kind, size = _element_of(description)
            yield field, kind if is_message else None, size is not None

    try:
        paths = tuple(_paths(name, fields_of))
    except KeyError as error:
        raise BrokenError(f"its definition does not say what {error} is") from error
    layout = partial(find_layout, typename=name, types=types, encoding=encoding)
    errors = (SerdeError, TypesysError, KeyError)  # the last of an unknown type
    return MessageDecoder(paths, lambda payload: reader()(payload, name), errors, layout)


def _protobuf_decoder(connection: Connection) -> MessageDecoder:
    """Return the decoder of protobuf messages, by their descriptors in the file, through mcap-protobuf-support."""
    from google.protobuf.message import DecodeError
    from mcap.exceptions import McapError
    from mcap.records import Schema
    from mcap_protobuf.decoder import DecoderFactory

    language, content = connection.definition
    try:
        decode = DecoderFactory().decoder_for("protobuf", Schema(1, content, language, connection.type))
    except (McapError, DecodeError, TypeError, KeyError) as error:
        raise BrokenError(f"its protobuf descriptors cannot be used ({error})") from error
    if decode is None:
        raise BrokenError(f"its schema is of encoding {language!r}, not protobuf")
    kind = decode(b"").DESCRIPTOR
    paths = _paths(kind, lambda one: ((field.name, field.message_type, field.is_repeated) for field in one.fields))
    return MessageDecoder(tuple(paths), decode, (DecodeError,))


def _find_definition(connection: Connection, payloads: Iterable[bytes]) -> Types | None:
    """Find the definition of a connection's type and of all that it contains, as rosbags parses them."""
    from rosbags.typesys import Stores, get_typestore

    if connection.definition[1]:
        return _parse(connection)
    standard = get_typestore(Stores.ROS1_NOETIC if connection.encoding == "ros1" else Stores.ROS2_HUMBLE).fielddefs
    if connection.type in standard:
        return standard
    if connection.type in _FRANKA_TYPES:  # the generation whose layout has the payload's length
        for payload, generation, errors in product(payloads, _FRANKA_GENERATIONS, _ERRORS):
            own = franka_types((errors, "CollisionIndicators", "Elbow", generation), connection.type)
            with suppress(BrokenError):
                find_layout(payload, connection.type, known := {**standard, **own}, encoding=connection.encoding)
                return known
    return None


def _parse(connection: Connection) -> Types:
    from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

    types: Types = dict(get_typestore(Stores.EMPTY).fielddefs)
    separator, (language, content) = "=" * 80 + "\n", connection.definition
    try:
        text = content.decode()
        if language != "ros2idl":
            types.update(get_types_from_msg(text, connection.type))
        elif text.startswith(f"{separator}IDL: "):
            for part in text.split(separator)[1:]:
                types.update(get_types_from_idl(part.split("\n", 1)[1]))
        else:
            types.update(get_types_from_idl(text))
    except (TypesysError, UnicodeDecodeError, RecursionError) as error:
        raise BrokenError(f"its definition cannot be parsed ({error})") from error
    if connection.type in types:
        _count_fields(connection.type, types)
    return types


def _count_fields(typename: str, types: Types, above: tuple[str, ...] = ()) -> int:
    """Count fields, arrays of numbers as one; BrokenError for a message that a decoder would not come to an end of."""
    if typename in above or len(above) > _DEEPEST:
        raise BrokenError(f"{typename} contains itself, or is nested more than {_DEEPEST} deep")
    count = 1
    for _, description in types.get(typename, ((), ()))[1]:
        is_message, detail, length = _element_of(description)
        own = _count_fields(detail, types, (*above, typename)) if is_message else 1
        if own == 1 and is_message and length is not None:
            raise BrokenError(f"{typename} has an array of empty messages")
        count += own * (max(length or 1, 1) if is_message else 1)
        if count > _MOST_FIELDS:
            raise BrokenError(f"{typename} has more than {_MOST_FIELDS} fields")
    return count


def franka_types(names: Sequence[str], own: str) -> Types:
    """Return the types in some files of franka_msgs/, which are called as the types are; the last one is ``own``."""
    from importlib.resources import files

    from rosbags.typesys import get_types_from_msg

    found: Types = {}
    for name in names:
        text = (files("friction_audit.io.readers") / "franka_msgs" / f"{name}.msg").read_text(encoding="utf-8")
        typename = own if name == names[-1] else f"franka_msgs/msg/{name.partition('_')[0]}"
        found.update(get_types_from_msg(text, typename))
    return found


def _paths(message: Any, fields_of: Callable[[Any], Fields], prefix: str = "") -> Iterator[str]:  # noqa: ANN401
    """Yield the dotted paths of numbers, texts and time stamps, one level of nesting deep."""
    for name, inner, is_list in fields_of(message):
        path = prefix + name
        if inner is None or (not is_list and any(one in _SECONDS for one, *_ in fields_of(inner))):
            yield path
        elif not prefix:
            yield from _paths(inner, fields_of, f"{path}[]." if is_list else f"{path}.")


def _json_fields(message: object) -> Fields:
    for name, value in message.items() if isinstance(message, Mapping) else ():
        inner = value[0] if isinstance(value, list) and value else value
        yield name, inner if isinstance(inner, Mapping) else None, isinstance(value, list)


def find_layout(payload: bytes, typename: str, types: Types, *, encoding: str) -> Layout:
    """Walk a message definition over one payload; BrokenError if they do not fit, or the payload is big-endian."""
    if encoding == "cdr" and payload[:2] != _CDR_LITTLE_ENDIAN:
        raise BrokenError("not little-endian plain CDR")
    walk = _Walk(payload, types, is_cdr=encoding == "cdr")
    try:
        walk.message(typename, "")
    except (struct.error, UnicodeDecodeError, KeyError) as error:
        raise BrokenError(str(error)) from error
    spare = len(payload) - walk.position
    if not 0 <= spare <= (_CDR_TRAILING_PADDING_BYTES if walk.is_cdr else 0):
        raise BrokenError(f"{spare} bytes left over")
    found = np.flatnonzero(walk.fixed)
    lots = np.split(found, np.flatnonzero(np.diff(found) > _CLOSE_BYTES) + 1) if len(found) else ()
    spans = tuple(slice(int(lot[0]), int(lot[-1]) + 1) for lot in lots)
    return Layout(len(payload), walk.numbers, walk.strings, walk.fixed, np.frombuffer(payload, np.uint8), spans)


def _element_of(description: Any) -> tuple[bool, Any, int | None]:  # noqa: ANN401
    """Return of a field, or of a list's elements: whether it is a message, its type, the list's length (-1: any)."""
    node, detail = description
    if node <= _MESSAGE:
        return node == _MESSAGE, detail, None
    (inner, detail), size = detail
    return inner == _MESSAGE, detail, size if node == _ARRAY else -1


class _Walk:
    """A walk over a payload: CDR aligns primitives after its header of four bytes and ends strings with a zero."""

    def __init__(self, payload: bytes, types: Types, *, is_cdr: bool) -> None:
        self.payload, self.types, self.is_cdr = payload, types, is_cdr
        self.numbers, self.strings = dict[str, tuple[np.dtype[Any], int]](), dict[str, tuple[str, ...]]()
        self.fixed = np.zeros(len(payload), np.uint8)
        self.position = _CDR_HEADER_BYTES if is_cdr else 0
        self.fixed[: len(_CDR_LITTLE_ENDIAN) if is_cdr else 0] = 0xFF

    def message(self, typename: str, prefix: str) -> None:
        for name, description in self.types[typename][1]:
            path, (is_message, detail, size) = prefix + name, _element_of(description)
            count = 1 if size is None else self.length() if size < 0 else size
            if is_message:
                for index in range(count):
                    self.message(detail, f"{path}." if size is None else f"{path}[{index}].")
            elif detail[0] == "string":
                self.strings[path] = tuple(self.string() for _ in range(count))
            else:
                if (kind := _NUMBER_TYPES.get(detail[0])) is None:
                    raise BrokenError(f"{path} is of type {detail[0]}")
                width = np.dtype(kind).itemsize
                self.take(count, width if count else 1)
                self.numbers[path] = np.dtype((kind, (count,))), self.position - count * width
                if self.position > len(self.payload):
                    raise BrokenError(f"{path} ends after the payload")

    def take(self, count: int, width: int, *, decides: bool = False) -> bytes:
        """Pass over elements of some bytes each; returns them, and notes if they decide the layout."""
        if self.is_cdr:
            self.position += -(self.position - _CDR_HEADER_BYTES) % width
        begin, self.position = self.position, self.position + count * width
        self.fixed[begin : self.position] |= 0xFF * decides
        return self.payload[begin : self.position]

    def length(self) -> int:
        (value,) = struct.unpack("<I", self.take(1, 4, decides=True))
        if value > len(self.payload):
            raise BrokenError(f"a sequence of {value} elements")
        return int(value)

    def string(self) -> str:
        content = self.take(size := self.length(), 1, decides=True)
        if len(content) < size or (self.is_cdr and content[-1:] != b"\x00"):
            raise BrokenError("a string without end")
        return (content[:-1] if self.is_cdr else content).decode()
