"""Settings that may be of one kind or another: the members of a union of dataclasses, by name."""

import math
import re
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

NOTHING = "none"
KIND = "kind"


def name_of(kind: type) -> str:
    """Return the name of a kind: ``SlowSweep`` is ``slow_sweep``, nothing at all is ``none``."""
    return NOTHING if kind is NoneType else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind.__name__).lower()


def kinds_of(hint: Any) -> dict[str, type]:  # noqa: ANN401 - any annotation
    """Return the kinds that an annotation leaves open, by name; empty where it leaves nothing open."""
    members = get_args(hint) if get_origin(hint) in (Union, UnionType) else ()
    if not any(map(is_dataclass, members)):
        return {}
    return {name_of(member): member for member in members}


def can_be_made(kind: type) -> bool:
    """Return True if a kind has usual values for everything."""
    if not is_dataclass(kind):
        return True
    return all(item.default is not MISSING or item.default_factory is not MISSING for item in fields(kind))


def as_nested(node: Any) -> Any:  # noqa: ANN401 - settings or a part of them
    """Return settings as nested dictionaries; where there was a choice, ``kind`` says what it was."""
    if isinstance(node, tuple):
        return tuple(map(as_nested, node))
    if not is_dataclass(node):
        return node
    hints = get_type_hints(type(node))
    nested: dict[str, Any] = {}
    for name in (item.name for item in fields(node)):
        value = getattr(node, name)
        below = as_nested(value)
        nested[name] = {KIND: name_of(type(value)), **below} if value is not None and kinds_of(hints[name]) else below
    return nested


Value = float | int | bool | str | tuple["Value", ...] | None
Reader = Callable[[str], Value]
"""Text -> value; raises ValueError with what it expected."""

TRUTHS = {"true": True, "false": False}


def reader_of(hint: Any, *, endless: bool = False) -> Reader | None:  # noqa: ANN401 - any annotation
    """Return what reads a value of an annotated type, or None where text cannot give one.

    Args:
        hint: The annotation.
        endless: True if the number may be infinite.
    """
    number = _read_limit if endless else _read_float
    plain: dict[Any, Reader] = {float: number, int: _read_int, bool: _read_bool, str: str}
    if hint in plain:
        return plain[hint]
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Literal:
        return lambda text: _read_word(text, arguments)
    if origin is tuple:
        return _tuple_reader(arguments)
    if origin in (Union, UnionType) and NoneType in arguments:
        return _optional_reader([one for one in arguments if one is not NoneType])
    return None


def write_plain(value: Value) -> str:
    """Return a value as its reader reads it."""
    match value:
        case None:
            return NOTHING
        case bool():
            return str(value).lower()
        case float():
            short = f"{value:g}"
            return short if float(short) == value else repr(value)
        case tuple():
            return ",".join(map(write_plain, value)) or NOTHING
    return str(value)


def _tuple_reader(arguments: tuple[Any, ...]) -> Reader | None:
    """Return the reader of a tuple of numbers or words of one type: a fixed number of them, or any, even none."""
    kinds = set(arguments) - {Ellipsis}
    kind = kinds.pop() if len(kinds) == 1 else tuple
    item = None if kind is tuple or get_origin(kind) is tuple else reader_of(kind)
    if item is None:
        return None
    count = None if Ellipsis in arguments else len(arguments)

    def read(text: str) -> Value:
        parts = [] if text == NOTHING and count is None else text.split(",")
        if count not in (None, len(parts)):
            raise ValueError(f"{count} values separated by commas, found {len(parts)}")
        return tuple(item(part.strip()) for part in parts)

    return read


def _optional_reader(others: list[Any]) -> Reader | None:
    """Return the reader of a value that may be missing."""
    present = reader_of(others[0]) if len(others) == 1 else None
    return None if present is None else lambda text: None if text == NOTHING else present(text)


def _read_float(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("a number")
    return value


def _read_limit(text: str) -> float:
    return math.inf if text == "inf" else _read_float(text)


def _read_int(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError("a whole number") from None


def _read_bool(text: str) -> bool:
    if text not in TRUTHS:
        raise ValueError(" or ".join(TRUTHS))
    return TRUTHS[text]


def _read_word(text: str, words: tuple[Any, ...]) -> str:
    if text not in words:
        raise ValueError(f"one of {', '.join(map(str, words))}")
    return text
