"""Decoders of messages: ROS through rosbags, JSON, protobuf through mcap-protobuf-support.

The definition of a ROS message is from the file, from the standard set, or one of the known franka_msgs generations.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from friction_audit.io.readers.message_layout import Layout, LayoutError, find_layout
from friction_audit.io.readers.message_stream import Connection, UndecodableError

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict
    from rosbags.typesys.store import Typestore

# Files in franka_msgs/, in the order in which they are tried.
_FRANKA_GENERATIONS = ("FrankaRobotState_nested", "FrankaState_flat", "FrankaState_multipanda")
_FRANKA_TYPES = ("franka_msgs/msg/FrankaState", "franka_msgs/msg/FrankaRobotState")
_ERRORS = ("Errors_36", "Errors_41")  # which have so many flags
_DEEPEST, _MOST_FIELDS = 64, 100_000  # the largest state message, FrankaRobotState, has some 200 fields in five levels
_STAMP_TYPES = ("builtin_interfaces/msg/Time",)


class DefinitionError(Exception):
    """The definition that a file carries cannot be used."""


@dataclass(frozen=True, eq=False, slots=True)
class MessageDecoder:
    """Decodes payloads of one connection."""

    # Dotted paths of the fields that hold numbers, strings or time stamps, one level of nesting deep; list[].field for
    # the fields of a list's entries.
    paths: tuple[str, ...]
    library: Callable[[bytes], object]  # what decodes one message
    errors: tuple[type[Exception], ...]  # what that raises
    # Finds where the numbers lie in a payload; JSON and protobuf have no constant layout.
    layout: Callable[[bytes], Layout | None] = lambda _: None

    def decode(self, payload: bytes) -> object:
        """Decode one message; raises UndecodableError."""
        try:
            return self.library(payload)
        except self.errors as error:
            raise UndecodableError(str(error)) from error


def decoder_for(connection: Connection, payload: bytes | None = None) -> MessageDecoder | None:
    """Make the decoder of a connection; None if its type is not known, or cannot be known without a message.

    DefinitionError if the definition in the file cannot be used.
    """
    if connection.encoding in ("cdr", "ros1"):
        types = _find_definition(connection, payload)
        return None if types is None or connection.type not in types else _ros_decoder(connection, types)
    if connection.encoding == "json" and payload is not None:
        return _json_decoder(payload)
    if connection.encoding == "protobuf":
        return _protobuf_decoder(connection)
    return None


def needs_message(connection: Connection) -> bool:
    """Return True if a decoder may be found once a message is at hand."""
    return connection.encoding == "json" or bool(connection.definition) or connection.type in _FRANKA_TYPES


def _ros_decoder(connection: Connection, types: "Typesdict") -> MessageDecoder:
    """Return the decoder of ROS 1 or ROS 2 (CDR) messages, through rosbags."""
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_typestore

    is_cdr, name = connection.encoding == "cdr", connection.type

    @cache
    def store() -> "Typestore":  # generated when it is first needed
        made = get_typestore(Stores.EMPTY)
        made.register(types)
        return made

    def decode(payload: bytes) -> object:
        return (store().deserialize_cdr if is_cdr else store().deserialize_ros1)(payload, name)

    def layout(payload: bytes) -> Layout | None:
        with suppress(LayoutError):
            return find_layout(payload, name, types, encoding=connection.encoding)
        return None

    try:
        paths = tuple(_ros_paths(name, types))
    except KeyError as error:
        raise DefinitionError(f"its definition does not say what {error} is") from error
    return MessageDecoder(paths, decode, (SerdeError, TypesysError, KeyError), layout)  # KeyError: of an unknown type


def _json_decoder(payload: bytes) -> MessageDecoder:
    """Return the decoder of JSON messages; the fields are those of the first message."""
    decoder = MessageDecoder((), json.loads, (ValueError, RecursionError))
    with suppress(UndecodableError):
        return replace(decoder, paths=tuple(_json_paths(decoder.decode(payload))))
    return decoder


def _protobuf_decoder(connection: Connection) -> MessageDecoder:
    """Return the decoder of protobuf messages, by their descriptors in the file, through mcap-protobuf-support."""
    from google.protobuf.message import DecodeError
    from mcap.exceptions import McapError
    from mcap.records import Schema
    from mcap_protobuf.decoder import DecoderFactory

    schema = Schema(id=1, name=connection.type, encoding=connection.definition_format, data=connection.definition)
    try:
        decode = DecoderFactory().decoder_for("protobuf", schema)
    except (McapError, DecodeError, TypeError, KeyError) as error:
        raise DefinitionError(f"its protobuf descriptors cannot be used ({error})") from error
    if decode is None:
        raise DefinitionError(f"its schema is of encoding {connection.definition_format!r}, not protobuf")
    return MessageDecoder(tuple(_protobuf_paths(decode(b"").DESCRIPTOR)), decode, (DecodeError,))


def _find_definition(connection: Connection, payload: bytes | None) -> "Typesdict | None":
    """Find the definition of a connection's type and of all that it contains, as rosbags parses them."""
    from rosbags.typesys import Stores, get_typestore

    if connection.definition:
        return _parse(connection)
    standard = get_typestore(Stores.ROS1_NOETIC if connection.encoding == "ros1" else Stores.ROS2_HUMBLE).fielddefs
    if connection.type in standard:
        return standard
    if connection.type in _FRANKA_TYPES and payload is not None:
        for types in _franka_definitions(connection.type):  # the generation whose layout has the payload's length
            try:
                find_layout(payload, connection.type, {**standard, **types}, encoding=connection.encoding)
            except LayoutError:
                continue
            return {**standard, **types}
    return None


def _parse(connection: Connection) -> "Typesdict":
    from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

    types: Typesdict = dict(get_typestore(Stores.EMPTY).fielddefs)
    separator = "=" * 80 + "\n"
    try:
        text = connection.definition.decode()
        if connection.definition_format != "ros2idl":
            types.update(get_types_from_msg(text, connection.type))
        elif text.startswith(f"{separator}IDL: "):
            for part in text.split(separator)[1:]:
                types.update(get_types_from_idl(part.split("\n", 1)[1]))
        else:
            types.update(get_types_from_idl(text))
    except (TypesysError, UnicodeDecodeError, RecursionError) as error:
        raise DefinitionError(f"its definition cannot be parsed ({error})") from error
    if connection.type in types:
        _count_fields(connection.type, types)
    return types


def _count_fields(typename: str, types: "Typesdict", above: tuple[str, ...] = ()) -> int:
    """Return how many fields a message has at least, arrays of numbers counted once.

    DefinitionError if it contains itself, or arrays of messages that a decoder would not come to an end of.
    """
    if typename in above or len(above) > _DEEPEST:
        raise DefinitionError(f"{typename} contains itself, or is nested more than {_DEEPEST} deep")
    count = 1
    length: int | None
    for _, description in types.get(typename, ((), ()))[1]:
        # Node types of rosbags: 2 a named message, 3 an array, 4 a sequence (whose length a payload bounds).
        match description:
            case (2, inner):
                length = None
            case (3, ((2, inner), size)):
                length = int(size)
            case (_, ((2, inner), _)):
                length = 1
            case _:
                count += 1
                continue
        own = _count_fields(str(inner), types, (*above, typename))
        if own == 1 and length is not None:
            raise DefinitionError(f"{typename} has an array of empty messages")
        count += own * (1 if length is None else length)
        if count > _MOST_FIELDS:
            raise DefinitionError(f"{typename} has more than {_MOST_FIELDS} fields")
    return count


def _franka_definitions(typename: str) -> Iterator["Typesdict"]:
    for generation in _FRANKA_GENERATIONS:
        for errors in _ERRORS:
            yield franka_types((errors, "CollisionIndicators", "Elbow", generation), typename)


def franka_types(names: Sequence[str], own: str) -> "Typesdict":
    """Return the types in some files of franka_msgs/, which are called as the types are; the last one is ``own``."""
    from importlib.resources import files

    from rosbags.typesys import get_types_from_msg

    found: Typesdict = {}
    for name in names:
        text = (files("friction_audit.io.readers") / "franka_msgs" / f"{name}.msg").read_text(encoding="utf-8")
        typename = own if name == names[-1] else f"franka_msgs/msg/{name.partition('_')[0]}"
        found.update(get_types_from_msg(text, typename))
    return found


def _ros_paths(typename: str, types: "Typesdict", prefix: str = "") -> Iterator[str]:
    for name, description in types[typename][1]:
        path = prefix + name
        kind, detail = int(description[0]), description[1]
        if kind == 1 or detail in _STAMP_TYPES:
            yield path
        elif kind == 2 and not prefix:  # noqa: PLR2004
            yield from _ros_paths(str(detail), types, f"{path}.")
        elif kind > 2:  # noqa: PLR2004
            match detail:
                case ((1, _), _):
                    yield path
                case ((2, str(inner)), _) if "." not in path:
                    yield from _ros_paths(inner, types, f"{path}[].")


def _json_paths(message: object, prefix: str = "") -> Iterator[str]:
    for name, value in message.items() if isinstance(message, Mapping) else ():
        path = f"{prefix}{name}"
        yield path
        if isinstance(value, Mapping) and not prefix:
            yield from _json_paths(value, f"{path}.")
        elif isinstance(value, list) and value and not prefix:
            yield from _json_paths(value[0], f"{path}[].")


def _protobuf_paths(descriptor: object, prefix: str = "") -> Iterator[str]:
    for field in descriptor.fields:  # type: ignore[attr-defined]
        path = f"{prefix}{field.name}"
        yield path
        if field.message_type is not None and not prefix:
            yield from _protobuf_paths(field.message_type, f"{path}[]." if field.is_repeated else f"{path}.")
