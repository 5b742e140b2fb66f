"""Long tables, one row per joint and time -> Recording."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import ForeignName, parse_name
from friction_audit.io.readers.columns import (
    MOST_JOINTS,
    ColumnMap,
    ambiguous_torque,
    column_position,
    refuse_absent,
    stated_time,
)
from friction_audit.io.readers.joint_samples import choose_arm, robot_of
from friction_audit.io.readers.reader import Recording
from friction_audit.io.readers.time_column import Clock, TimeColumn, find_time
from friction_audit.io.readers.to_recording import to_recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float

_JOINT_COLUMNS = ("joint", "joint_name", "joint_id", "joint_index", "name")
_WHOLE = re.compile(r"^(\d+)\.0+$")
"""A joint's number in a column that was written as floats."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LongColumns:
    """The columns of a long table.

    Attributes:
        time: The clock.
        joint: Position of the column that tells the joint.
        channels: Channel -> position of its column.
        names: Channel -> name in the file.
        degrees: Channels whose names say degrees.
        stated: Channels that the user named.
    """

    time: TimeColumn
    joint: int
    channels: Mapping[str, int]
    names: Mapping[str, str]
    degrees: frozenset[str]
    stated: frozenset[str]


def find_long_columns(names: Sequence[str], *, path: str, mapping: Mapping[str, str]) -> LongColumns | None:
    """Return the columns of a long table, or None if this is none: no column of joints, or one column per joint."""
    bare = [name.strip() for name in names]
    joint = next((cell for cell, name in enumerate(bare) if name.lower() in _JOINT_COLUMNS), None)
    if joint is None or any(_is_several(value, bare) for channel, value in mapping.items() if channel != "t"):
        return None
    refuse_absent(mapping, bare, path)
    parsed = {cell: parse_name(name) for cell, name in enumerate(bare)}
    stated = {channel: column_position(value, bare) for channel, value in mapping.items() if channel != "t"}
    best = {**_best_of_each(parsed, taken=stated), **stated}
    if not {"q", "dq"} <= best.keys():
        return None
    time = stated_time(mapping["t"], bare) if "t" in mapping else find_time(bare)
    if time is None or not set(TORQUE_CHANNELS) & best.keys():
        raise InputError(
            f"{path}: a table with a column {bare[joint]!r} needs columns for time, q, dq and a torque "
            f"({', '.join(TORQUE_CHANNELS)}); found {', '.join(bare)}"
        )
    return LongColumns(
        time=time,
        joint=joint,
        stated=frozenset(stated),
        channels=best,
        names={channel: bare[cell] for channel, cell in best.items()},
        degrees=frozenset(
            c for c, cell in best.items() if (told := parsed[cell]) and told.channel == c and told.degrees
        ),
    )


def _is_several(value: str, names: Sequence[str]) -> bool:
    """Return True if a --map entry names a column per joint, as for a table with one row per time."""
    return value not in names and (re.search(r"\{i\}|,|-", value) is not None or f"{value}[0]" in names)


def _best_of_each(parsed: Mapping[int, ForeignName | None], *, taken: Mapping[str, int]) -> dict[str, int]:
    """Return channel -> position of the column with the most telling name, among those that tell no joint."""
    single = [
        (cell, told)
        for cell, told in parsed.items()
        if told is not None and told.index is None and told.joint is None and cell not in taken.values()
    ]
    return {told.channel: cell for cell, told in sorted(single, key=lambda item: -item[1].rank)}


def pivot_long(
    long: LongColumns,
    joint: NDArray[Any],
    clock: Clock,
    values: Mapping[str, Float],
    *,
    path: str,
    arm: str = "",
    findings: tuple[Finding, ...] = (),
) -> Recording:
    """Bring a long table to one row per time; rows of times that some joint lacks are left out.

    ``arm`` is the one to read where there are several.
    """
    import pandas as pd

    codes, labels = pd.factorize(joint, sort=False)
    if len(labels) > MOST_JOINTS:
        raise InputError(
            f"{path}: the column of joints holds {len(labels)} names; expected at most {MOST_JOINTS} joints; "
            "name another column as the joint's"
        )
    texts = [_WHOLE.sub(r"\1", str(label).strip()) for label in labels]
    kept = [texts.index(text) for text in choose_arm(texts, arm, path=path)]
    if not kept:
        raise InputError(f"{path}: 0 samples; the table has a header and no rows; record the arm while it moves")
    rows, lost = _rows_of_joints([np.flatnonzero(codes == code) for code in kept], clock.t)
    channels = {channel: np.empty((len(rows[0]), len(kept)), order="F") for channel in values}
    for channel, column in values.items():
        for place, chosen in enumerate(rows):
            channels[channel][:, place] = column[chosen]
    names = _names([texts[code] for code in kept])
    columns = ColumnMap(
        time=long.time,
        channels={},
        joint_names=names,
        robot=robot_of(names),
        mapping=long.names,
        degrees=long.degrees,
        findings=findings,
    )
    noticed = ambiguous_torque(long.names, joints=len(names), robot=columns.robot, stated=long.stated)
    noticed += () if lost == 0 else (_incomplete(lost),)
    own = Clock(clock.t[rows[0]], clock.start_s, clock.unit)
    return to_recording(columns, own, channels, findings=noticed)


def _names(labels: Sequence[str]) -> tuple[str, ...]:
    if not all(label.isdigit() for label in labels):
        return tuple(labels)
    base = 0 if any(int(label) == 0 for label in labels) else 1
    return tuple(f"joint{int(label) - base + 1}" for label in labels)


def _rows_of_joints(rows: list[NDArray[np.intp]], time: NDArray[Any]) -> tuple[list[NDArray[np.intp]], int]:
    """Return each joint's rows at the times that all joints have, and how many rows that leaves out."""
    first = time[rows[0]]
    if all(len(own) == len(first) and np.array_equal(time[own], first) for own in rows):
        return rows, 0
    common = first
    for own in rows:
        common = np.intersect1d(common, time[own])
    matched = []
    for own in rows:
        order = own[np.argsort(time[own], kind="stable")]
        matched.append(order[np.searchsorted(time[order], common)])
    return matched, sum(map(len, rows)) - len(rows) * len(common)


def _incomplete(lost: int) -> Finding:
    return Finding(
        code="incomplete_rows",
        message=f"{lost} rows belong to times at which other joints have no row; they are left out",
        amount=float(lost),
        damaged=True,
    )
