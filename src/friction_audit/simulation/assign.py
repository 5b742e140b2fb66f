"""``name=value`` on a tree of settings: nested frozen dataclasses, some of them in tuples with one per joint.

Names, types and limits are those of the dataclasses themselves. Where a field is a union of dataclasses, its kind can
be assigned too, by name: ``SlowSweep`` is ``slow_sweep``, None is ``none``.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import MISSING, fields, is_dataclass, replace
from difflib import SequenceMatcher
from functools import partial
from math import inf
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import require_joints, split_joints, write_joint_numbers

Settings = TypeVar("Settings")
Value = float | int | bool | str | tuple["Value", ...] | None

APART = ("hidden",)  # parts of the settings that have an option of their own
NOTHING = "none"
UNIONS = (Union, UnionType)
LIKE, TIE = 0.7, 0.01  # names more alike than the first may have been meant; the place in the tree breaks ties


class PerJoint(NamedTuple):
    """A setting that every joint has for itself: one value per joint."""

    values: tuple[Value, ...]


class Kind(NamedTuple):
    """A setting that is of one kind and could be of another: its kind, and the others."""

    name: str
    others: tuple[str, ...]


Setting = Value | PerJoint | Kind


class _Leaf(NamedTuple):
    """A setting: where it is, what it is, what text makes of what is there (ValueError: what was expected)."""

    path: tuple[str, ...]
    value: Setting
    read: Callable[[str, Any], Any]


def paths(settings: object) -> dict[str, Setting]:
    """Return every setting that can be assigned, by its dotted path, in the order of declaration."""
    return {".".join(leaf.path): leaf.value for leaf in _leaves(settings)}


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
        chosen = value is not None and _kinds_of(hints[name])
        nested[name] = {"kind": _name_of(type(value)), **below} if chosen else below
    return nested


def write_value(value: Setting) -> str:
    """Return a value as ``assign`` reads it; different ones of the joints side by side, their joints after ``@``."""
    if isinstance(value, Kind):
        return value.name
    if isinstance(value, PerJoint):
        joints: dict[str, list[int]] = {}
        for number, one in enumerate(value.values, start=1):
            joints.setdefault(_write_plain(one), []).append(number)
        if len(joints) == 1:
            return next(iter(joints))
        return "  ".join(f"{text}@{write_joint_numbers(numbers)}" for text, numbers in joints.items())
    return _write_plain(value)


def _write_plain(value: Value) -> str:
    match value:
        case None:
            return NOTHING
        case bool():
            return str(value).lower()
        case float():
            short = f"{value:g}"
            return short if float(short) == value else repr(value)
        case tuple():
            return ",".join(map(_write_plain, value)) or NOTHING
    return str(value)


def assign_texts(settings: Settings, entries: Iterable[str]) -> Settings:
    """Return the settings with several entries assigned, those last that the settings allow only after others."""
    given = tuple(entries)
    waiting = list(given)
    while waiting:
        refused: dict[str, UsageError] = {}
        for entry in waiting:
            try:
                settings = assign_text(settings, entry)
            except UsageError as error:
                refused[entry] = error
        if len(refused) == len(set(waiting)):
            raise refused[waiting[0]]
        waiting = list(refused)
    undone = [entry for entry in given if assign_text(settings, entry) != settings]
    if undone:
        raise UsageError(f"--set {undone[0]}: is undone by another --set; leave one of them out")
    return settings


def assign_text(settings: Settings, entry: str) -> Settings:
    """Return the settings with ``"name=value"`` or ``"name=value@2,5"`` assigned.

    The name is the dotted path of a setting, or as much of its end as no other one shares; without joints, all have it.
    """
    assignment, joints = split_joints(entry, f"--set {entry}")
    name, equals, text = (part.strip() for part in assignment.partition("="))
    if not equals or not name:
        raise UsageError(f"--set {entry}: expected NAME=VALUE, e.g. duration_s=60")
    known = {".".join(leaf.path): leaf for leaf in _leaves(settings)}
    full = _find(name, tuple(known))
    at = "" if joints is None else f"@{write_joint_numbers(joints)}"
    where, leaf = f"--set {full}={text}{at}", known[full]
    if joints is not None:
        if not isinstance(leaf.value, PerJoint):
            raise UsageError(f"{where}: is not set joint by joint; leave out {at}")
        require_joints(joints, len(leaf.value.values), where)
    try:
        changed: Settings = _put(settings, leaf.path, partial(leaf.read, text), joints)
    except ValueError as error:
        raise UsageError(f"{where}: expected {error}") from error
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error
    return changed


def _find(name: str, known: tuple[str, ...]) -> str:
    found = [path for path in known if path == name] or [path for path in known if path.endswith(f".{name}")]
    if len(found) == 1:
        return found[0]
    if found:
        raise UsageError(f"--set {name}: stands for {len(found)} settings; expected one of {', '.join(found)}")
    likeness = {path: _likeness(name, path) for path in known}
    near = sorted((path for path in known if likeness[path] >= LIKE), key=lambda path: -likeness[path])[:3]
    hint = f"did you mean {' or '.join(near)}?" if near else "--list with the scenario names all of them"
    raise UsageError(f"--set {name}: no such setting; {hint}")


def _likeness(name: str, path: str) -> float:
    """Return how alike the ends of two paths are, 0 to 1, with or without a unit; a common beginning breaks ties."""
    (place, _, end), (its_place, _, its_end) = name.rpartition("."), path.rpartition(".")
    ends = max(SequenceMatcher(None, end, other).ratio() for other in (its_end, its_end[: len(end)]))
    return ends + TIE * SequenceMatcher(None, place, its_place).ratio() if ends >= LIKE else 0.0


def _put(node: Any, path: tuple[str, ...], change: Callable[[Any], Any], joints: tuple[int, ...] | None) -> Any:  # noqa: ANN401
    """Return a node with the value at a path below it changed, for some joints or for all."""
    if not path:
        return change(node)
    old, rest = getattr(node, path[0]), path[1:]
    if rest and isinstance(old, tuple):
        meant = range(1, len(old) + 1) if joints is None else joints
        each = enumerate(old, start=1)
        new: Any = tuple(_put(one, rest, change, None) if number in meant else one for number, one in each)
    else:
        new = _put(old, rest, change, joints)
    return replace(node, **{path[0]: new})


def _leaves(node: Any) -> Iterator[_Leaf]:  # noqa: ANN401 - any dataclass
    hints = get_type_hints(type(node))
    for item in fields(node):
        if item.name not in APART:
            value = getattr(node, item.name)
            below = _below(value, hints[item.name], endless=inf in (value, item.default))
            yield from (leaf._replace(path=(item.name, *leaf.path)) for leaf in below)


def _below(value: Any, hint: Any, *, endless: bool) -> Iterator[_Leaf]:  # noqa: ANN401 - any value, any annotation
    """Yield the settings that a field of a dataclass holds, the field itself with an empty path."""
    kinds = _kinds_of(hint)
    if kinds:
        others = tuple(name for name, kind in kinds.items() if _can_be_made(kind) and not isinstance(value, kind))
        yield _Leaf((), Kind(_name_of(type(value)), others), partial(_turn_into, kinds))
    if is_dataclass(value):
        yield from _leaves(value)
    elif isinstance(value, tuple) and value and all(map(is_dataclass, value)):
        # One per joint: the settings that all joints have, with the joints' values.
        own = [{leaf.path: leaf for leaf in _leaves(node)} for node in value]
        for path, leaf in own[0].items():
            if all(path in one for one in own):
                values: Any = tuple(one[path].value for one in own)
                yield leaf._replace(value=PerJoint(values))
    elif not kinds and _is_plain(hint):
        yield _Leaf((), value, lambda text, _: _read(text, hint, endless=endless))


def _name_of(kind: type) -> str:
    return NOTHING if kind is NoneType else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind.__name__).lower()


def _kinds_of(hint: Any) -> dict[str, type]:  # noqa: ANN401 - any annotation
    """Return the kinds that an annotation leaves open, by name; empty where it leaves nothing open."""
    members = get_args(hint) if get_origin(hint) in UNIONS else ()
    return {_name_of(member): member for member in members} if any(map(is_dataclass, members)) else {}


def _can_be_made(kind: type) -> bool:
    if not is_dataclass(kind):
        return True
    return all(item.default is not MISSING or item.default_factory is not MISSING for item in fields(kind))


def _turn_into(kinds: dict[str, type], name: str, old: object) -> object:
    """Return another kind of settings with its usual values, or the old ones if they are of that kind."""
    if name not in kinds:
        raise ValueError(f"one of {', '.join(kinds)}")
    if isinstance(old, kinds[name]):
        return old
    if not _can_be_made(kinds[name]):
        raise UsageError(f"{name} has no usual values; a scenario must have it")
    return kinds[name]()


def _is_plain(hint: Any) -> bool:  # noqa: ANN401 - any annotation
    """Return True for a number, a word, several of one type, or one that may be None: what text can give."""
    origin, members = get_origin(hint), set(get_args(hint)) - {Ellipsis}
    if origin is tuple:
        return len(members) == 1 and members <= {float, int, str}
    if origin in UNIONS:
        return len(members) == 2 and NoneType in members and all(map(_is_plain, members - {NoneType}))  # noqa: PLR2004
    return origin is Literal or hint in (float, int, bool, str)


def _read(text: str, hint: Any, *, endless: bool = False) -> Value:  # noqa: ANN401 - any annotation that is plain
    """Read a value of an annotated type; an endless number may be inf. ValueError says what was expected."""
    origin, members = get_origin(hint), get_args(hint)
    if origin is tuple:
        parts = [] if text == NOTHING and Ellipsis in members else text.split(",")
        if Ellipsis not in members and len(parts) != len(members):
            raise ValueError(f"{len(members)} values separated by commas, found {len(parts)}")
        return tuple(_read(part.strip(), members[0]) for part in parts)
    if origin in UNIONS:
        return None if text == NOTHING else _read(text, next(one for one in members if one is not NoneType))
    if origin is Literal or hint is bool:
        if text not in (members or ("true", "false")):
            raise ValueError(f"one of {', '.join(members)}" if members else "true or false")
        return text if members else text == "true"
    return text if hint is str else _read_number(text, hint, endless=endless)


def _read_number(text: str, kind: type[float] | type[int], *, endless: bool) -> float:
    if endless and text == "inf":
        return inf
    try:
        value = kind(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("a number" if kind is float else "a whole number")
    return value
