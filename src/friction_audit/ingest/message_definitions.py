"""Definitions of ROS messages: from the file, from the standard set, or one of the known franka_msgs generations."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from friction_audit.ingest.message_layout import LayoutError, find_layout
from friction_audit.ingest.message_stream import Connection

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

FRANKA_GENERATIONS = ("FrankaRobotState_nested", "FrankaState_flat", "FrankaState_multipanda")
"""Files in ``franka_msgs/``, in the order in which they are tried."""

FRANKA_TYPES = ("franka_msgs/msg/FrankaState", "franka_msgs/msg/FrankaRobotState")

ERROR_FLAGS = (36, 41)
"""Number of flags in ``franka_msgs/Errors``, by generation."""


DEEPEST = 64
MOST_FIELDS = 100_000
"""The largest state message, FrankaRobotState, has some 200 fields in five levels."""


class DefinitionError(Exception):
    """The definition that a file carries cannot be used."""


def find_definition(connection: Connection, payload: bytes | None) -> "Typesdict | None":
    """Find the definition of a connection's type and of all that it contains.

    Args:
        connection: A ROS 1 or ROS 2 connection.
        payload: A message of it, with which the known franka_msgs generations are tried.

    Returns:
        Definitions as rosbags parses them, or None if nothing is known.

    Raises:
        DefinitionError: If the file carries a definition that cannot be parsed.
    """
    if connection.definition:
        return _parse(connection)
    standard = _standard_types(connection.encoding)
    if connection.type in standard:
        return standard
    if connection.type in FRANKA_TYPES and payload is not None:
        return _try_franka(connection, payload, standard)
    return None


def may_be_known(connection: Connection) -> bool:
    """Return True if a definition can be found once a message is at hand."""
    return bool(connection.definition) or connection.type in FRANKA_TYPES


def _parse(connection: Connection) -> "Typesdict":
    from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

    types: Typesdict = dict(get_typestore(Stores.EMPTY).fielddefs)
    try:
        text = connection.definition.decode()
        if connection.definition_format == "ros2idl":
            types.update(_parse_idl(text))
        else:
            types.update(get_types_from_msg(text, connection.type))
    except (TypesysError, UnicodeDecodeError, RecursionError) as error:
        raise DefinitionError(f"its definition cannot be parsed ({error})") from error
    if connection.type in types:
        _count_fields(connection.type, types)
    return types


def _count_fields(typename: str, types: "Typesdict", above: tuple[str, ...] = ()) -> int:
    """Return how many fields a message has at least, arrays of numbers counted once.

    Raises:
        DefinitionError: If it contains itself, or arrays of messages that a decoder would not come to an end of.
    """
    if typename in above or len(above) > DEEPEST:
        raise DefinitionError(f"{typename} contains itself, or is nested more than {DEEPEST} deep")
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
        if count > MOST_FIELDS:
            raise DefinitionError(f"{typename} has more than {MOST_FIELDS} fields")
    return count


def _parse_idl(text: str) -> "Typesdict":
    from rosbags.typesys import get_types_from_idl

    separator = "=" * 80 + "\n"
    if not text.startswith(f"{separator}IDL: "):
        return get_types_from_idl(text)
    types: Typesdict = {}
    for part in text.split(separator)[1:]:
        types.update(get_types_from_idl(part.split("\n", 1)[1]))
    return types


def _standard_types(encoding: str) -> "Typesdict":
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE).fielddefs


def _try_franka(connection: Connection, payload: bytes, standard: "Typesdict") -> "Typesdict | None":
    """Choose the generation whose layout has the payload's length."""
    for types in _franka_definitions(connection.type):
        candidate = {**standard, **types}
        try:
            find_layout(payload, connection.type, candidate, encoding=connection.encoding)
        except LayoutError:
            continue
        return candidate
    return None


def _franka_definitions(typename: str) -> Iterator["Typesdict"]:
    from importlib.resources import files

    from rosbags.typesys import get_types_from_msg

    folder = files("friction_audit.ingest") / "franka_msgs"
    parts: Typesdict = {}
    for name in ("CollisionIndicators", "Elbow"):
        text = (folder / f"{name}.msg").read_text(encoding="utf-8")
        parts.update(get_types_from_msg(text, f"franka_msgs/msg/{name}"))
    for generation in FRANKA_GENERATIONS:
        text = (folder / f"{generation}.msg").read_text(encoding="utf-8")
        for flags in ERROR_FLAGS:
            errors = get_types_from_msg(f"bool[{flags}] flags", "franka_msgs/msg/Errors")
            yield {**parts, **errors, **get_types_from_msg(text, typename)}
