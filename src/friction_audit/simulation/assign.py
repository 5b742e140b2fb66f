"""``name=value`` on a tree of settings: nested frozen dataclasses, some of them in tuples with one per joint.

Names, types and limits are those of the dataclasses themselves; nothing is written down a second time.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import Field, fields, is_dataclass, replace
from difflib import SequenceMatcher
from functools import partial
from math import inf
from typing import Any, NamedTuple, TypeVar, get_type_hints

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import require_joints, split_joints, write_joint_numbers
from friction_audit.simulation.plain_values import Value, can_be_made, kinds_of, name_of, reader_of, write_plain

Settings = TypeVar("Settings")
Change = Callable[[Any], Any]
"""What is there -> what shall be there."""

APART = ("hidden",)
"""Parts of the settings that have an option of their own."""


LIKE = 0.7
"""Names more alike than this may have been meant for each other."""

TIE = 0.01


class PerJoint(NamedTuple):
    """A setting that every joint has for itself: one value per joint."""

    values: tuple[Value, ...]


class Kind(NamedTuple):
    """A setting that is of one kind and could be of another: its kind, and the others."""

    name: str
    others: tuple[str, ...]


Setting = Value | PerJoint | Kind


class _Leaf(NamedTuple):
    """A setting: where it is, what it is, what text makes of it (ValueError: what was expected)."""

    path: tuple[str, ...]
    value: Setting
    read: Callable[[str], Change]


def paths(settings: object) -> dict[str, Setting]:
    """Return every setting that can be assigned, by its dotted path, in the order of declaration."""
    return {name: leaf.value for name, leaf in _named(settings).items()}


def write_value(value: Setting) -> str:
    """Return a value as ``assign`` reads it; different ones of the joints side by side, their joints behind ``@``."""
    if isinstance(value, Kind):
        return value.name
    if not isinstance(value, PerJoint):
        return write_plain(value)
    joints: dict[str, list[int]] = {}
    for number, one in enumerate(value.values, start=1):
        joints.setdefault(write_plain(one), []).append(number)
    if len(joints) == 1:
        return next(iter(joints))
    return "  ".join(f"{text}@{write_joint_numbers(numbers)}" for text, numbers in joints.items())


def assign_texts(settings: Settings, entries: Iterable[str]) -> Settings:
    """Return the settings with several entries assigned, those last that the settings allow only after others.

    Raises:
        UsageError: As ``assign_text`` does, for the first entry that never fits, or if two entries contradict.
    """
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

    Raises:
        UsageError: If the text has another shape, or as ``assign`` does.
    """
    assignment, joints = split_joints(entry, f"--set {entry}")
    path, equals, text = assignment.partition("=")
    if not equals or not path.strip():
        raise UsageError(f"--set {entry}: expected NAME=VALUE, e.g. duration_s=60")
    return assign(settings, path.strip(), text.strip(), joints)


def assign(settings: Settings, path: str, text: str, joints: tuple[int, ...] | None = None) -> Settings:
    """Return the settings with one value replaced.

    Args:
        settings: The tree.
        path: Dotted path of a setting, or as much of its end as no other one shares.
        text: The value, e.g. ``"80"``, ``"0.2,0.7"``, ``"true"``.
        joints: Numbers (1..n) of the joints that it is for; None for all.

    Raises:
        UsageError: If there is no such setting or more than one, or value or joints do not fit.
    """
    known = _named(settings)
    full = _find(path, tuple(known))
    behind = "" if joints is None else f"@{write_joint_numbers(joints)}"
    where, leaf = f"--set {full}={text}{behind}", known[full]
    if joints is not None:
        if not isinstance(leaf.value, PerJoint):
            raise UsageError(f"{where}: is not set joint by joint; leave out {behind}")
        require_joints(joints, len(leaf.value.values), where)
    try:
        change = leaf.read(text)
    except ValueError as error:
        raise UsageError(f"{where}: expected {error}") from error
    try:
        changed: Settings = _put(settings, leaf.path, change, joints)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error
    return changed


def _named(settings: object) -> dict[str, _Leaf]:
    return {".".join(leaf.path): leaf for leaf in _leaves(settings)}


def _leaves(node: Any) -> Iterator[_Leaf]:  # noqa: ANN401 - any dataclass
    hints = get_type_hints(type(node))
    for item in fields(node):
        if item.name not in APART:
            below = _below(getattr(node, item.name), item, hints[item.name])
            yield from (leaf._replace(path=(item.name, *leaf.path)) for leaf in below)


def _below(value: Any, item: Field[Any], hint: Any) -> Iterator[_Leaf]:  # noqa: ANN401 - any value, any annotation
    """Yield the settings that a field of a dataclass holds, the field itself with an empty path."""
    kinds = kinds_of(hint)
    if kinds:
        others = tuple(name for name, kind in kinds.items() if can_be_made(kind) and not isinstance(value, kind))
        yield _Leaf((), Kind(name_of(type(value)), others), partial(_turn_into, kinds))
    if is_dataclass(value):
        yield from _leaves(value)
    elif _one_per_joint(value):
        yield from _side_by_side(value)
    elif not kinds:
        read = reader_of(hint, endless=inf in (value, item.default))
        if read is not None:
            yield _Leaf((), value, lambda text: _always(read(text)))


def _always(value: Value) -> Change:
    return lambda _: value


def _turn_into(kinds: dict[str, type], name: str) -> Change:
    """Return what turns settings into another kind with its usual values, and leaves them if they are of that kind."""
    if name not in kinds:
        raise ValueError(f"one of {', '.join(kinds)}")

    def change(old: object) -> object:
        if isinstance(old, kinds[name]):
            return old
        if not can_be_made(kinds[name]):
            raise UsageError(f"{name} has no usual values; a scenario must have it")
        return kinds[name]()

    return change


def _one_per_joint(value: object) -> bool:
    return isinstance(value, tuple) and len(value) > 0 and all(map(is_dataclass, value))


def _side_by_side(nodes: tuple[object, ...]) -> Iterator[_Leaf]:
    """Yield the settings that all joints have, with the joints' values."""
    own = [{leaf.path: leaf for leaf in _leaves(node)} for node in nodes]
    for path, leaf in own[0].items():
        if all(path in one for one in own):
            values: Any = tuple(one[path].value for one in own)
            yield leaf._replace(value=PerJoint(values))


def _find(name: str, known: tuple[str, ...]) -> str:
    """Return the one path that a name stands for."""
    found = [path for path in known if path == name] or [path for path in known if path.endswith(f".{name}")]
    if len(found) == 1:
        return found[0]
    if found:
        raise UsageError(f"--set {name}: stands for {len(found)} settings; expected one of {', '.join(found)}")
    near = _near(name, known)
    hint = f"did you mean {' or '.join(near)}?" if near else "--list with the scenario names all of them"
    raise UsageError(f"--set {name}: no such setting; {hint}")


def _near(name: str, known: tuple[str, ...]) -> list[str]:
    """Return the paths that a name may have meant, the likeliest first."""
    likeness = {path: _likeness(name, path) for path in known}
    near = sorted((path for path in known if likeness[path] >= LIKE), key=lambda path: -likeness[path])
    return near[:3]


def _likeness(name: str, path: str) -> float:
    """Return how alike the ends of two paths are, 0 to 1, with or without a unit; a common beginning breaks ties."""
    (place, _, end), (its_place, _, its_end) = name.rpartition("."), path.rpartition(".")
    ends = max(SequenceMatcher(None, end, other).ratio() for other in (its_end, its_end[: len(end)]))
    return ends + TIE * SequenceMatcher(None, place, its_place).ratio() if ends >= LIKE else 0.0


def _put(node: Any, path: tuple[str, ...], change: Change, joints: tuple[int, ...] | None) -> Any:  # noqa: ANN401
    """Return a node with the value at a path below it changed, for some joints or for all."""
    if not path:
        return change(node)
    name, *rest = path
    old = getattr(node, name)
    put = partial(_put, path=tuple(rest), change=change)
    if rest and isinstance(old, tuple):
        meant = range(1, len(old) + 1) if joints is None else joints
        new = tuple(put(one, joints=None) if number in meant else one for number, one in enumerate(old, start=1))
    else:
        new = put(old, joints=joints)
    return replace(node, **{name: new})
