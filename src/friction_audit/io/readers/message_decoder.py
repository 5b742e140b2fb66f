"""Decoders of messages: ROS through rosbags, JSON, protobuf through mcap-protobuf-support.

The definition of a ROS message is from the file, from the standard set, or one of the known franka_msgs generations.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING

from friction_audit.io.readers.message_layout import Layout, element_of, find_layout
from friction_audit.io.readers.message_stream import BrokenError, Connection

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict
    from rosbags.typesys.store import Typestore

# Files in franka_msgs/, in the order in which they are tried.
_FRANKA_GENERATIONS = ("FrankaRobotState_nested", "FrankaState_flat", "FrankaState_multipanda")
_FRANKA_TYPES = ("franka_msgs/msg/FrankaState", "franka_msgs/msg/FrankaRobotState")
_ERRORS = ("Errors_36", "Errors_41")  # which have so many flags
_DEEPEST, _MOST_FIELDS = 64, 100_000  # the largest state message, FrankaRobotState, has some 200 fields in five levels
_STAMP_TYPES = ("builtin_interfaces/msg/Time",)


@dataclass(frozen=True, eq=False, slots=True)
class MessageDecoder:
    """Decodes payloads of one connection."""

    # Dotted paths of the fields that hold numbers, strings or time stamps, one level of nesting deep; list[].field for
    # the fields of a list's entries.
    paths: tuple[str, ...]
    decode: Callable[[bytes], object]  # decodes one message
    errors: tuple[type[Exception], ...]  # what that raises
    # Finds where the numbers lie in a payload, or raises BrokenError; JSON and protobuf have no constant layout.
    layout: Callable[[bytes], Layout] | None = None


def decoder_for(connection: Connection, payloads: Iterable[bytes]) -> MessageDecoder | None:
    """Make the decoder of a connection, from its first payloads where nothing else says what they hold.

    None if its type is not known; BrokenError if the definition in the file cannot be used.
    """
    if connection.encoding in ("cdr", "ros1"):
        types = _find_definition(connection, payloads)
        return None if types is None or connection.type not in types else _ros_decoder(connection, types)
    if connection.encoding == "protobuf":
        return _protobuf_decoder(connection)
    for payload in payloads if connection.encoding == "json" else ():
        with suppress(ValueError, RecursionError):
            if paths := tuple(_json_paths(json.loads(payload))):  # the first message that has fields
                return MessageDecoder(paths, json.loads, (ValueError, RecursionError))
    return None


def _ros_decoder(connection: Connection, types: "Typesdict") -> MessageDecoder:
    """Return the decoder of ROS 1 or ROS 2 (CDR) messages, through rosbags."""
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_typestore

    encoding, name = connection.encoding, connection.type

    @cache
    def store() -> "Typestore":  # generated when it is first needed
        made = get_typestore(Stores.EMPTY)
        made.register(types)
        return made

    def decode(payload: bytes) -> object:
        return (store().deserialize_cdr if encoding == "cdr" else store().deserialize_ros1)(payload, name)

    try:
        paths = tuple(_ros_paths(name, types))
    except KeyError as error:
        raise BrokenError(f"its definition does not say what {error} is") from error
    layout = partial(find_layout, typename=name, types=types, encoding=encoding)
    return MessageDecoder(paths, decode, (SerdeError, TypesysError, KeyError), layout)  # KeyError: of an unknown type


def _protobuf_decoder(connection: Connection) -> MessageDecoder:
    """Return the decoder of protobuf messages, by their descriptors in the file, through mcap-protobuf-support."""
    from google.protobuf.message import DecodeError
    from mcap.exceptions import McapError
    from mcap.records import Schema
    from mcap_protobuf.decoder import DecoderFactory

    language, content = connection.definition
    schema = Schema(id=1, name=connection.type, encoding=language, data=content)
    try:
        decode = DecoderFactory().decoder_for("protobuf", schema)
    except (McapError, DecodeError, TypeError, KeyError) as error:
        raise BrokenError(f"its protobuf descriptors cannot be used ({error})") from error
    if decode is None:
        raise BrokenError(f"its schema is of encoding {language!r}, not protobuf")
    return MessageDecoder(tuple(_protobuf_paths(decode(b"").DESCRIPTOR)), decode, (DecodeError,))


def _find_definition(connection: Connection, payloads: Iterable[bytes]) -> "Typesdict | None":
    """Find the definition of a connection's type and of all that it contains, as rosbags parses them."""
    from rosbags.typesys import Stores, get_typestore

    if connection.definition[1]:
        return _parse(connection)
    standard = get_typestore(Stores.ROS1_NOETIC if connection.encoding == "ros1" else Stores.ROS2_HUMBLE).fielddefs
    if connection.type in standard:
        return standard
    for payload in payloads if connection.type in _FRANKA_TYPES else ():
        for types in _franka_definitions(connection.type):  # the generation whose layout has the payload's length
            known = {**standard, **types}
            with suppress(BrokenError):
                find_layout(payload, connection.type, known, encoding=connection.encoding)
                return known
    return None


def _parse(connection: Connection) -> "Typesdict":
    from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

    types: Typesdict = dict(get_typestore(Stores.EMPTY).fielddefs)
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


def _count_fields(typename: str, types: "Typesdict", above: tuple[str, ...] = ()) -> int:
    """Count fields, arrays of numbers as one; BrokenError for a message that a decoder would not come to an end of."""
    if typename in above or len(above) > _DEEPEST:
        raise BrokenError(f"{typename} contains itself, or is nested more than {_DEEPEST} deep")
    count = 1
    for _, description in types.get(typename, ((), ()))[1]:
        is_message, detail, length = element_of(description)
        own = _count_fields(detail, types, (*above, typename)) if is_message else 1
        if own == 1 and is_message and length is not None:
            raise BrokenError(f"{typename} has an array of empty messages")
        count += own * (max(length or 1, 1) if is_message else 1)
        if count > _MOST_FIELDS:
            raise BrokenError(f"{typename} has more than {_MOST_FIELDS} fields")
    return count


def _franka_definitions(typename: str) -> Iterator["Typesdict"]:
    for generation, errors in product(_FRANKA_GENERATIONS, _ERRORS):
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
        path, (is_message, detail, length) = prefix + name, element_of(description)
        if not is_message or (length is None and detail in _STAMP_TYPES):
            yield path
        elif not prefix:
            yield from _ros_paths(detail, types, f"{path}." if length is None else f"{path}[].")


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
