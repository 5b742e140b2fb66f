"""The columns of a table -> channels of a JointLog: by name, never by position, unless the user says so."""

import difflib
import re
from collections.abc import Collection, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.errors import InputError, near_misses
from friction_audit.io.readers.channel_names import (
    OTHER_UNIT,
    QUANTITIES,
    STATED_UNITS,
    ForeignName,
    Group,
    JointKey,
    arms_in,
    choose_arm,
    group_of,
    parse_name,
    positions_of,
    ranks,
    robot_of,
    shorten,
    stated_group,
)
from friction_audit.io.readers.clocks import UNITS, TimeColumn, find_time
from friction_audit.joint_log import JOINT_CHANNELS, TORQUE_CHANNELS, Finding

if TYPE_CHECKING:
    from friction_audit.io.readers.table import Table

MOST_JOINTS = 1000  # no robot has as many; with more, a table is transposed or a column is not what its name says
REQUIRED = ("q",)  # a velocity is made from the position where there is none
_SHOWN_JOINTS = 60
_COMPARED = 1000  # columns among which near misses are looked for: each comparison takes a fraction of a millisecond
_NUMBER = "[ _-]?(?:name|id|index|idx|number|no)"
_JOINT_COLUMN = re.compile(rf"name|(?:joint|axis)(?:{_NUMBER})?|(?:motor|actuator){_NUMBER}", re.IGNORECASE)
_COUNTER = re.compile(
    r".*(?:seq|index|counter|count|tick|frame|step|msg|sample)(?:[ _]?(?:id|no|number))?s?", re.IGNORECASE
)
_SEVERAL = re.compile(r"\{i\}|,|-")  # in a --map entry that names a column per joint
_AMBIGUOUS = ("torque", "tau", "effort")


class ColumnMap(NamedTuple):
    """Which column is what."""

    time: TimeColumn  # the clock
    # channel -> positions of its columns, one per joint; a single one in a long table
    channels: Mapping[str, tuple[int, ...]]
    joint_names: tuple[str, ...]  # one name per joint; of a long table not yet those in its rows
    mapping: Mapping[str, str]  # channel -> name in the file, for people
    per_turn: Mapping[str, float]  # channels that are not in radians -> their unit in a turn, 360 for degrees
    findings: tuple[Finding, ...] = ()  # channels left out
    joint: int | None = None  # position of the column of joints in a table with one row per joint and time, else None

    @property
    def cells(self) -> list[int]:
        """Positions of the clock and of the columns of all channels."""
        return [*self.time.cells, *chain.from_iterable(self.channels.values())]


def map_columns(
    table: "Table", mapping: Mapping[str, str], arm: str, *, needed: Sequence[str] = REQUIRED, is_long: bool = False
) -> ColumnMap:
    """Find time, joints and channels among the columns of a table.

    ``mapping`` is what the user says, channel or ``"t"`` -> name, and wins; ``arm`` is the one to read of several;
    ``needed`` are channels without which it is no log, and with them a torque: none where other files have them.
    """
    path, labels, bare = str(table.path), table.labels, [name.strip() for name in table.names]
    if lost := [f"--map {c}={mapping[c]}{near_misses(name, bare)}" for c, name in absent(mapping, bare).items()]:
        units = f"; units after a colon are {', '.join(STATED_UNITS)}" if any(":" in one for one in lost) else ""
        raise InputError(f"{path}: no column for {' and no column for '.join(lost)}; found {shorten(bare)}{units}")
    listed = [one for channel, one in mapping.items() if channel != "t" and one not in bare]
    per_joint = any(_SEVERAL.search(one) or f"{one}[0]" in bare for one in listed)  # is a column
    is_joint = (cell for cell, name in enumerate(bare) if _JOINT_COLUMN.fullmatch(name))
    joint = next(is_joint, None) if is_long and not per_joint else None
    outside = _outside_the_arm(bare, labels, mapping, arm, path) if joint is None else frozenset[int]()
    stated = {c: stated_group(mapping[c], bare, labels, outside) for c in JOINT_CHANNELS if c in mapping}
    taken = {bare[cell] for group in stated.values() for cell in group.cells.values()}
    parsed = {cell: parse_name(name) for cell, name in enumerate(bare) if cell not in outside and name not in taken}
    if joint is not None:  # the joint's name or number is in the row
        parsed = {cell: name for cell, name in parsed.items() if name and name.index is None and name.joint is None}
    guessed, others, heads = _guessed_groups(parsed, labels, stated)
    groups = {**guessed, **stated}
    q = groups.get("q")
    if q is not None and others and len(q.cells) == 1 and not q.names and "{" not in q.template:
        raise InputError(  # each may be a joint by a name of its own, or of another arm
            f"{path}: several columns may be q; name those of one arm in the order of its joints: "
            f"--map q={','.join((q.template, *others))}, and those of the other channels likewise"
        )
    if joint is not None and not groups.keys() >= {*needed}:
        return map_columns(table, mapping, arm, needed=needed)
    most = max((len(group.cells) for group in groups.values()), default=0)
    if most > MOST_JOINTS:
        raise InputError(f"{path}: columns for {most} joints; expected at most {MOST_JOINTS}: is the table transposed?")
    # A column that stands still is second choice; where there is no better one, the checks report a stopped clock.
    time = _stated_time(mapping["t"], bare) if "t" in mapping else find_time(bare, table.constant) or find_time(bare)
    lacks = not groups.keys() >= {*needed} or not groups.keys() & {*(TORQUE_CHANNELS if needed else JOINT_CHANNELS)}
    if time is None or lacks:
        raise InputError(_missing_message(bare, groups, found_time=time is not None, path=path))
    if joint is not None:
        first = {channel: next(iter(group.cells.values())) for channel, group in groups.items()}
        alone = {c: Group(bare[cell], {0: cell}, per_turn=groups[c].per_turn) for c, cell in first.items()}
        return _align(alone, time, bare, path, needed)._replace(joint=joint)
    columns = _align(groups, time, bare, path, needed)
    return columns._replace(findings=(*columns.findings, *_choices(columns, others, heads)))


def _choices(columns: ColumnMap, others: Sequence[str], heads: Mapping[str, str]) -> list[Finding]:
    """Say which columns were read where others could have been."""
    message = f"{columns.mapping.get('q')} was read as q; also there: {', '.join(others)}; choose with --map"
    found = [Finding("topic_chosen", message)] if others else []
    torque = next((c for c in TORQUE_CHANNELS if c in columns.channels), "")
    if {"q", torque} <= heads.keys() and heads["q"] != heads[torque]:
        both = f"{columns.mapping['q']} was read as q and {columns.mapping[torque]} as {torque}"
        message = f"{both}, which stand apart; check that they are of one arm and one clock; choose with --map"
        found.append(Finding("topic_chosen", message))
    return found


def absent(mapping: Mapping[str, str], names: Sequence[str]) -> dict[str, str]:
    """Return the channels whose columns a table lacks, and the first name that it lacks."""
    bare, found = [name.strip() for name in names], {}
    for channel, value in mapping.items():
        try:
            _stated_time(value, bare) if channel == "t" else stated_group(value, bare)
        except KeyError as error:
            found[channel] = str(error.args[0])
    return found


def _stated_time(value: str, names: Sequence[str]) -> TimeColumn:
    """Return the clock that a --map entry names, if need be with its unit: ``clock:ms``."""
    name, _, unit = value.rpartition(":")
    if unit not in UNITS or not name:
        name, unit = value, ""
    cell, *_ = positions_of(name.strip(), names)
    known = find_time([names[cell]])
    clock = known.clock if known else "column"
    return TimeColumn(cells=(cell,), name=name, unit=unit or (known.unit if known else None), clock=clock)


def doubt_torque(columns: ColumnMap, names: Sequence[str], stated: Collection[str]) -> tuple[Finding, ...]:
    """Doubt a ``torque`` of a single joint that the user did not name: a rig's may be the interaction torque."""
    alone = len(columns.joint_names) == 1 and robot_of(columns.joint_names) == "unknown" and "tau_J" not in stated
    if not alone or columns.channels.keys() & {*TORQUE_CHANNELS, "gravity"} != {"tau_J"}:
        return ()
    name = names[columns.channels["tau_J"][0]].strip()
    parsed = parse_name(name)
    if parsed is None or len(parsed.words) > 1 or parsed.words[0] not in _AMBIGUOUS:
        return ()
    message = f"column {name!r} was read as tau_J, with gravity; if it is without, use --map tau_interaction={name}"
    return (Finding("torque_ambiguous", message),)


def _outside_the_arm(
    names: Sequence[str], labels: Mapping[int, str], mapping: Collection[str], arm: str, path: str
) -> frozenset[int]:
    """Return the positions of columns of fingers and of other arms; a column that the user named chooses its arm."""
    parsed = ((cell, parse_name(text)) for cell, text in enumerate(names))
    own = {cell: name.joint for cell, name in parsed if name and name.joint and (arm or name.channel not in mapping)}
    joints = {**labels} or own
    kept = choose_arm(list(joints.values()), arm, path=path)
    return frozenset(cell for cell, joint in joints.items() if joint not in kept)


def _guessed_groups(
    names: Mapping[int, ForeignName | None], labels: Mapping[int, str], stated: Collection[str]
) -> tuple[dict[str, Group], list[str], dict[str, str]]:
    """Group the columns by channel and template, and keep the first of the best templates of each channel.

    Also returns the other templates of q that are as good, and what stands before the words of each channel.
    """
    found: dict[str, dict[tuple[tuple[int, ...], str], dict[int, ForeignName]]] = {}
    rank_of = ranks([name for name in names.values() if name])
    for cell, parsed in names.items():
        if parsed is not None and parsed.channel not in stated:
            key = (rank_of(parsed), parsed.template)
            found.setdefault(parsed.channel, {}).setdefault(key, {})[cell] = parsed
    best = {channel: min(candidates.items(), key=lambda one: one[0][0]) for channel, candidates in found.items()}
    groups = {}
    for channel, ((_, template), cells) in best.items():
        own = [(cell, name.index, name.joint or labels.get(cell)) for cell, name in cells.items()]
        groups[channel] = group_of(template, own, degrees=next(iter(cells.values())).degrees)
    tied = [key[1] for key in found.get("q", {}) if key[0] == best["q"][0][0]]
    return groups, tied[1:], {channel: next(iter(cells.values())).head for channel, (_, cells) in best.items()}


def _missing_message(names: Sequence[str], groups: Mapping[str, Group], *, found_time: bool, path: str) -> str:
    wanted = ([] if found_time else ["t"]) + [channel for channel in REQUIRED if channel not in groups]
    torques = [] if groups.keys() & {*TORQUE_CHANNELS} else list(TORQUE_CHANNELS)
    listed = wanted + ([f"a torque ({', '.join(TORQUE_CHANNELS)})"] if torques else [])
    parts = [f"{path}: no column for {' and '.join(listed)}; found {shorten(names, numbered=True) or 'none'}"]
    if near := dict.fromkeys(hint for channel in (*wanted, *torques) for hint in _near_misses(channel, names)):
        parts.append(f"close to it: {', '.join(near)}")
    # ``torque_1 [mNm]`` would be a channel without the unit, which is not converted.
    units = [one for one in names[:_COMPARED] if OTHER_UNIT.search(one) and parse_name(OTHER_UNIT.sub("", one))]
    if units and len(wanted) + len(torques) > (not found_time):
        parts.append(
            f"{shorten(units)}: expected rad or deg, rad/s or deg/s, N m or A; give counts of an encoder as "
            "--map q=NAME:COUNTS/rev, name a torque with --map and give --torque-scale, or convert the column"
        )
    mapped = wanted + ["dq"] * ("q" in wanted and "dq" not in groups) + (["tau_J"] if torques else [])
    examples = [f"--map {c}=<column{'' if c == 't' else ' with {i} for the joint'}>" for c in mapped]
    numbers = "" if mapped == ["t"] else ", or by numbers, e.g. #2-#8"
    other = ", or add the file of this log that has it with --join FILE" if groups else ""
    parts.append(f"name what is missing with {' '.join(examples)}{numbers}{other}")
    counter = None if found_time else next((name for name in names if _COUNTER.fullmatch(name)), None)
    if counter:
        parts.append(f"a counter of milliseconds is a clock too: --map t={counter}:ms")
    return "; ".join(parts)


def _near_misses(channel: str, names: Sequence[str]) -> list[str]:
    """Return the columns whose names, numbers aside, nearly are a known name of the channel."""
    known = ("t", "time", "stamp", "timestamp") if channel == "t" else (channel.lower(), *QUANTITIES.get(channel, ()))
    stems: dict[str, str] = {}
    for name in names[:_COMPARED]:
        stems.setdefault(re.sub(r"[\W_]*\d+\W*$", "", name).lower(), name)
    taken = {word for words in QUANTITIES.values() for word in words}
    close = {match for word in known for match in difflib.get_close_matches(word, stems, n=2, cutoff=0.7)}
    return [f"{stems[stem]} ({channel})" for stem in stems if stem in close and stem not in taken and len(stem) > 1]


def _align(
    groups: Mapping[str, Group], time: TimeColumn, names: Sequence[str], path: str, needed: Sequence[str]
) -> ColumnMap:
    """Bring all channels to the same joints, in the same order."""
    there = [c for c in ("q", "dq") if c in groups] or list(groups)
    reference = next((groups[c] for c in there if not groups[c].in_order), groups[there[0]])
    joints = {key: name for group in reversed(list(groups.values())) for key, name in group.names.items()}
    keys = list(reference.cells)
    # The joints are sorted by the numbers in their names, if all of them are joints of one arm.
    key_of = {joints[key]: key for key in keys if key in joints}
    arms = list(arms_in(list(key_of)).values())
    keys = [key_of[name] for name in arms[0]] if len(arms) == 1 and len(arms[0]) == len(keys) else keys
    channels, findings, short = {}, [], []
    torques = [c for c in TORQUE_CHANNELS if c in groups]
    for channel in (c for c in JOINT_CHANNELS if c in groups):
        group = groups[channel]
        fits = len(group.cells) == len(keys) and (group.in_order or len(keys) == 1)
        own = tuple(group.cells.values()) if fits else tuple(group.cells[key] for key in keys if key in group.cells)
        if channel == "temperature" and len(group.cells) == 1 and not re.search(r"[{#]", group.template):
            fits, own = True, (*group.cells.values(),) * len(keys)  # that of the arm or of the room
        lost = [names[cell] for key, cell in group.cells.items() if key not in keys and not fits]
        if len(own) == len(keys):
            channels[channel] = own
            text = f"{shorten(lost)} left out: {reference.template} has no such joint"
            findings += [Finding("incomplete_channel", text, amount=float(len(lost)))] if lost else []
        elif channel in ("q", "dq") or torques == [channel]:
            short.append(f"{channel} ({_joints_text(group.cells)})")
        else:
            some = len(group.cells)
            text = f"{channel} has columns for {some} of {len(keys)} joints ({group.template}); it is left out"
            findings.append(Finding("incomplete_channel", text, amount=float(some)))
    if short or (needed and not any(c in channels for c in TORQUE_CHANNELS)):
        raise InputError(
            f"{path}: the columns do not cover the same joints: expected {_joints_text(reference.cells)} as in "
            f"{reference.template}, but {', '.join(short) or 'the torques do not'}; found {shorten(names)}; "
            "name the columns with --map"
        )
    joint_names = tuple(joints.get(key, key if isinstance(key, str) else f"joint{key + 1}") for key in keys)
    return ColumnMap(
        time=time,
        channels=channels,
        joint_names=joint_names,
        mapping={channel: groups[channel].template for channel in channels},
        per_turn={c: n for c in ("q", "dq") if c in channels and (n := groups[c].per_turn) is not None},
        findings=tuple(findings),
    )


def _joints_text(cells: Mapping[JointKey, int]) -> str:
    keys = [str(key + 1) if isinstance(key, int) else key for key in cells]
    if len(keys) > _SHOWN_JOINTS:
        return f"{len(keys)} joints, more than an arm has: is the table transposed?"
    return f"{len(keys)} joint{'s' * (len(keys) != 1)}: {', '.join(keys)}"
