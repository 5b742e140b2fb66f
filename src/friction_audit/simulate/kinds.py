"""Settings that may be of one kind or another: the members of a union of dataclasses, by name."""

import re
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

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
