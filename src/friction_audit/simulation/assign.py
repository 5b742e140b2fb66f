"""``name=value`` on a tree of settings: nested frozen dataclasses, some of them in tuples with one per joint.

Where a field is a union of dataclasses, its kind can be assigned too: ``SlowSweep`` is ``slow_sweep``, None ``none``.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import partial
from math import inf, isfinite, nan
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from friction_audit.errors import UsageError, kind_name, near_misses
from friction_audit.joint_numbers import parse_joint_numbers, require_joints, write_joint_numbers

Settings = TypeVar("Settings")
Value = float | int | bool | str | tuple["Value", ...] | None

APART = ("hidden",)  # parts of the settings that have an option of their own
NOTHING = "none"
PLAIN = (float, int, str, NoneType)  # types of what text can give


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
    """Return settings as nested dictionaries, the hidden effects left out; ``kind`` says what was chosen."""
    if isinstance(node, tuple):
        return tuple(map(as_nested, node))
    if not is_dataclass(node):
        return node
    hints = get_type_hints(type(node))
    nested: dict[str, Any] = {}
    for name in (item.name for item in fields(node) if item.name not in APART):
        value = getattr(node, name)
        below = as_nested(value)
        chosen = is_dataclass(value) and _kinds_of(hints[name])
        nested[name] = {"kind": kind_name(type(value)), **below} if chosen else below
    return nested


def write_value(value: Setting) -> str:
    """Return a value as ``assign`` reads it; different ones of the joints side by side, their joints after ``@``."""
    match value:
        case Kind():
            return value.name
        case PerJoint():
            joints: dict[str, list[int]] = {}
            for number, one in enumerate(value.values, start=1):
                joints.setdefault(write_value(one), []).append(number)
            alike = len(joints) == 1
            return "  ".join(text if alike else f"{text}@{write_joint_numbers(at)}" for text, at in joints.items())
        case None | bool():
            return NOTHING if value is None else str(value).lower()
        case float():
            short = f"{value:g}"
            return short if float(short) == value else repr(value)
        case tuple():
            return ",".join(map(write_value, value)) or NOTHING
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
    assignment, at, numbers = entry.partition("@")
    joints = parse_joint_numbers(numbers, f"--set {entry}") if at else None
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
    raise UsageError(f"--set {name}: no such setting; --list with the scenario names all{near_misses(name, known)}")


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
        value, hint, here = getattr(node, item.name), hints[item.name], (item.name,)
        kinds = _kinds_of(hint)
        if item.name in APART:
            continue
        if kinds:
            usual = [  # those that can be made without being given a number
                name
                for name, kind in kinds.items()
                if not is_dataclass(kind)
                or not any(item.default is item.default_factory is MISSING for item in fields(kind))
            ]
            others = tuple(name for name in usual if not isinstance(value, kinds[name]))
            yield _Leaf(here, Kind(kind_name(type(value)), others), partial(_turn_into, kinds, usual))
        if is_dataclass(value):
            yield from (leaf._replace(path=here + leaf.path) for leaf in _leaves(value))
        elif isinstance(value, tuple) and value and all(map(is_dataclass, value)):
            # One per joint: the settings that all joints have, with the joints' values.
            own = [{leaf.path: leaf for leaf in _leaves(one)} for one in value]
            for path in (path for path in own[0] if all(path in one for one in own)):
                values: Any = tuple(one[path].value for one in own)
                yield _Leaf(here + path, PerJoint(values), own[0][path].read)
        elif not kinds and all(isinstance(one, PLAIN) for one in (value if isinstance(value, tuple) else (value,))):
            yield _Leaf(here, value, partial(_read, hint, inf in (value, item.default)))


def _kinds_of(hint: Any) -> dict[str, type]:  # noqa: ANN401 - any annotation
    """Return the kinds that an annotation leaves open, by name; empty where it leaves nothing open."""
    members = get_args(hint) if isinstance(hint, UnionType) else ()
    single: list[Any] = [member for member in members if is_dataclass(member) or member is NoneType]
    return {kind_name(member): member for member in single} if any(map(is_dataclass, single)) else {}


def _turn_into(kinds: dict[str, type], usual: Collection[str], name: str, old: object) -> object:
    """Return another kind of settings with its usual values, or the old ones if they are of that kind."""
    if name not in kinds:
        raise ValueError(f"one of {', '.join(kinds)}")
    if isinstance(old, kinds[name]):
        return old
    if name not in usual:
        raise UsageError(f"{name} has no usual values; a scenario must have it")
    return kinds[name]()


def _read(hint: Any, endless: bool, text: str, _old: object = None) -> Value:  # noqa: ANN401 - any plain annotation
    """Read a value of an annotated type; an endless number may be inf. ValueError says what was expected."""
    origin, members = get_origin(hint), get_args(hint)
    if origin is tuple:
        parts = [] if text == NOTHING and Ellipsis in members else text.split(",")
        if Ellipsis not in members and len(parts) != len(members):
            raise ValueError(f"{len(members)} values separated by commas, found {len(parts)}")
        return tuple(_read(members[0], endless, part.strip()) for part in parts)
    if origin is UnionType:
        return None if text == NOTHING else _read(next(one for one in members if one is not NoneType), endless, text)
    if origin is Literal or hint is bool:
        if text not in (members or ("true", "false")):
            raise ValueError(f"one of {', '.join(members)}" if members else "true or false")
        return text if members else text == "true"
    if hint is str:
        return text
    value = nan
    with suppress(ValueError):
        value = hint(text)
    if not isfinite(value) and not (endless and text == "inf"):
        raise ValueError("a number" if hint is float else "a whole number")
    return value
