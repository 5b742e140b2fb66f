"""What ``--map`` says of the columns of a table: names, templates, places, units."""

import difflib
import re
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import parse_name
from friction_audit.io.readers.time_column import UNITS, TimeColumn, find_time

_SHOWN_GROUPS = 14
_POSITION = re.compile(r"#(\d+)(?:-#?(\d+))?")

JointKey = int | str  # a joint's number (0-based), or its name where it has no number


@dataclass(frozen=True, kw_only=True, slots=True)
class Group:
    """The columns of one channel."""

    template: str  # name with {i} or {joint} for the joint
    cells: Mapping[JointKey, int]  # joint -> position of the column
    names: Mapping[JointKey, str] = field(default_factory=dict)  # joint -> the joint's name, where the columns have it
    degrees: bool = False  # true if the name says degrees
    in_order: bool = False  # true if the user gave the columns one by one, in the order of the joints


def refuse_absent(mapping: Mapping[str, str], names: Sequence[str], path: str) -> None:
    """Refuse columns that the table lacks, all of them at once.

    Raises:
        InputError: Naming them.
    """
    lost = []
    for channel, name in absent(mapping, names).items():
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
        lost.append(f"--map {channel}={mapping[channel]}" + (f" (did you mean {' or '.join(near)}?)" if near else ""))
    if lost:
        raise InputError(f"{path}: no column for {' and no column for '.join(lost)}; found {shorten(names)}")


def absent(mapping: Mapping[str, str], names: Sequence[str]) -> dict[str, str]:
    """Return the channels whose columns a table lacks, and the first name that it lacks."""
    bare, found = [name.strip() for name in names], {}
    for channel, value in mapping.items():
        try:
            stated_time(value, bare) if channel == "t" else stated_group(value, bare)
        except KeyError as error:
            found[channel] = str(error.args[0])
    return found


def shorten(names: Sequence[str]) -> str:
    """Return a list of column names with numbered runs drawn together: ``time, q_1...q_7``."""
    runs: dict[str, list[str]] = defaultdict(list)
    for name in names:
        runs[re.sub(r"\d+(?!.*\d)", "#", name)].append(name)
    shown = [run[0] if len(run) == 1 else f"{run[0]}...{run[-1]}" for run in runs.values()]
    more = len(shown) - _SHOWN_GROUPS
    return ", ".join(shown[:_SHOWN_GROUPS]) + (f" and {more} more" if more > 0 else "")


def stated_group(
    value: str, names: Sequence[str], labels: Mapping[int, str] | None = None, outside: Collection[int] = ()
) -> Group:
    """Read one --map entry: a template with {i}, names with commas, one name, or the name of a list column.

    ``:deg``, ``:rad``, ``:A`` or ``:mA`` after it says the unit. KeyError if there is no such column.
    """
    bare, _, unit = value.rpartition(":")
    if unit in ("deg", "rad", "A", "mA") and value not in names:
        group = stated_group(bare, names, labels, outside)
        return replace(group, template=value, degrees=unit == "deg")
    template = value.strip() if "{i}" in value else value + "[{i}]"
    pattern = re.compile(re.escape(template).replace(re.escape("{i}"), r"(\d+)"))
    places = reversed(list(enumerate(names)))  # of repeated names the first counts
    numbered = {int(match[1]): cell for cell, name in places if (match := pattern.fullmatch(name))}
    if numbered:
        kept = {number: numbered[number] for number in sorted(numbered) if numbered[number] not in outside}
        base = 0 if 0 in kept else 1
        cells: dict[JointKey, int] = {number - base: cell for number, cell in kept.items()}
        parsed = {key: parse_name(names[cell]) for key, cell in cells.items()}
        joints = {key: (name.joint if name else None) or (labels or {}).get(cells[key]) for key, name in parsed.items()}
        return Group(template=value, cells=cells, names={key: name for key, name in joints.items() if name})
    if "{i}" in value:
        raise KeyError(value)
    listed = [cell for part in value.split(",") for cell in _stated_cells(part.strip(), names)]
    return Group(template=value, cells=dict(enumerate(listed)), in_order=True)


def _stated_cells(part: str, names: Sequence[str]) -> list[int]:
    match = _POSITION.fullmatch(part)
    if match is None or match[2] is None:
        return [_column_position(part, names)]
    return [_column_position(f"#{number}", names) for number in range(int(match[1]), int(match[2]) + 1)]


def _column_position(name: str, names: Sequence[str]) -> int:
    """Return the position of a column given by name or as ``#3`` (counted from 1); KeyError if there is none."""
    if name in names:
        return list(names).index(name)
    match = _POSITION.fullmatch(name)
    if match is not None and 1 <= int(match[1]) <= len(names):
        return int(match[1]) - 1
    raise KeyError(name)


def stated_time(value: str, names: Sequence[str]) -> TimeColumn:
    """Return the clock that a --map entry names, if need be with its unit: ``clock:ms``."""
    name, _, unit = value.rpartition(":")
    if unit not in UNITS or not name:
        name, unit = value, ""
    cell = _column_position(name.strip(), names)
    known = find_time([names[cell]])
    clock = known.clock if known else "column"
    return TimeColumn(cells=(cell,), name=name, unit=unit or (known.unit if known else None), clock=clock)
