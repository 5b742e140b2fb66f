"""Several files of one log -> one Recording: channels of the others, interpolated at the stamps of the first file."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.clocks import UNITS
from friction_audit.io.recording import Recording, take_rows
from friction_audit.joint_log import JOINT_CHANNELS, TORQUE_CHANNELS, Finding, Float

LONGEST_GAP = 3.5  # median steps of a file; in a longer gap of it nothing is interpolated


def join_recordings(parts: Sequence[Recording], mapping: Mapping[str, str]) -> Recording:
    """Return the first recording with the channels that the others have and it lacks, in the span that all cover."""
    joined, *others = parts
    stems = {channel: name.rpartition(":")[0] or name for channel, name in mapping.items()}
    held = {c: any(part.mapping.get(c, "").startswith(stem) for part in parts) for c, stem in stems.items()}
    if not all(held.values()):
        unused = " ".join(f"--map {c}={mapping[c]}" for c, is_held in held.items() if not is_held)
        names = ", ".join(part.path for part in parts)
        raise InputError(f"{names}: no column for {unused} in any of these files; correct it")
    low, high = -inf, inf
    for other in others:
        stamps = _on_clock_of(joined, other)
        start, stop = np.nanmin(stamps, initial=inf), np.nanmax(stamps, initial=-inf)
        low, high = max(low, start), min(high, stop)
        if not ((joined.t >= low) & (joined.t <= high)).any():
            raise InputError(
                f"{other.path}: its clock runs from {start:.6g} to {stop:.6g} s, that of {joined.path} from "
                f"{np.nanmin(joined.t):.6g} to {np.nanmax(joined.t):.6g} s (from its first sample); expected clocks "
                "that overlap; name the common clock with --map t=NAME, or join files of one recording"
            )
        joined = _with_channels(joined, other, stamps)
    rows = (joined.t >= low) & (joined.t <= high)
    for channel in {"q", "dq", *TORQUE_CHANNELS} & joined.channels.keys() - parts[0].channels.keys():
        there = np.isfinite(joined.channels[channel]).all(axis=1)
        rows &= there | ~there.any()  # a channel without any number is refused with the other faults
    outside = len(rows) - int(np.count_nonzero(rows))
    held_by = ((Path(part.path).name, [c for c in JOINT_CHANNELS if c in part.channels]) for part in others)
    names = ", ".join(f"{', '.join(own)} of {name}" for name, own in held_by)
    cut = f"; {outside} samples outside of the common span or in gaps are left out" if outside else ""
    message = f"joined on the clock of {Path(joined.path).name}, by linear interpolation: {names}{cut}"
    if outside:  # the parts of a log that --t-start and --t-end name count from its first sample all the same
        first_s = float(np.nanmin(joined.t)) if joined.first_s is None else joined.first_s
        joined = replace(joined.changed(lambda t, channels: take_rows(t, channels, rows)), first_s=first_s)
    return joined.with_findings(Finding("joined", message, amount=float(outside)))


def refuse_without_torque(recording: Recording, parts: Sequence[Recording]) -> None:
    """Refuse a recording that lacks the position or every torque, and say what its parts hold."""
    lost = [] if "q" in recording.channels else ["q"]
    lost += [] if recording.channels.keys() & {*TORQUE_CHANNELS} else [f"torque ({', '.join(TORQUE_CHANNELS)})"]
    if lost:
        held = [f"{Path(part.path).name} has {', '.join(part.channels) or 'none'}" for part in parts]
        held += [one.message for part in parts for one in part.findings if one.code == "channel_empty"]
        what = f"{recording.path}: no {' and no '.join(lost)}; {'; '.join(held)}"
        raise InputError(f"{what}; join the file that has it with --join, or name its columns with --map")


def _on_clock_of(first: Recording, other: Recording) -> Float:
    """Return the stamps of another file on the clock of the first."""
    if (first.start_s is None) != (other.start_s is None):
        dated, plain = (first.path, other.path) if first.start_s is not None else (other.path, first.path)
        what = f"the clock of {dated} says the date, that of {plain} does not; expected one clock in both files"
        advice = "name it with --map t=NAME, or convert the stamps of one"
        raise InputError(f"{other.path}: cannot be joined: {what}; {advice}")
    # A unit is guessed from the step, for logs of 5 Hz and more: that of a slow one, such as a temperature, is wrong.
    scale = UNITS[other.guessed_unit] / UNITS[first.guessed_unit] if other.guessed_unit and first.guessed_unit else 1.0
    return scale * other.t + (scale * other.origin_s - first.origin_s)


def _with_channels(first: Recording, other: Recording, stamps: Float) -> Recording:
    if not (new := [channel for channel in other.channels if channel not in first.channels]):
        raise InputError(
            f"{other.path}: has {', '.join(other.channels)}, as {first.path}; expected channels that it lacks; name "
            f"them with --map, or leave out --join {other.path}"
        )
    order: Sequence[int] = range(len(other.joint_names))
    if set(first.joint_names) == set(other.joint_names):
        order = [other.joint_names.index(name) for name in first.joint_names]
    elif len(first.joint_names) != len(order):
        raise InputError(
            f"{other.path}: has {len(order)} joints ({', '.join(other.joint_names)}), {first.path} has "
            f"{len(first.joint_names)} ({', '.join(first.joint_names)}); expected the same; name columns with --map"
        )
    channels = dict(first.channels)
    for channel in new:
        columns = [interpolated(first.t, stamps, other.channels[channel][:, joint]) for joint in order]
        channels[channel] = np.asfortranarray(np.column_stack(columns))
    name = Path(other.path).name
    findings = [one._replace(message=f"{name}: {one.message}") for one in other.findings]
    if both := [channel for channel in other.channels if channel in first.channels]:
        message = f"{', '.join(both)} of {name} are left out: {Path(first.path).name} has them"
        findings.append(Finding("not_joined", message))
    return replace(
        first,
        channels=channels,
        mapping={**first.mapping, **{c: other.mapping[c] for c in new if c in other.mapping}},
        robot=other.robot if first.robot == "unknown" else first.robot,
        serial=first.serial or other.serial,
        torque_unit=first.torque_unit or other.torque_unit,
    ).with_findings(*findings)


def interpolated(t: Float, stamps: Float, values: Float) -> Float:
    """Return values at other stamps; missing in gaps and outside of the stamps; of equal stamps the first counts."""
    rows = np.flatnonzero(np.isfinite(stamps))
    rows = rows[np.unique(stamps[rows], return_index=True)[1]]
    longest = LONGEST_GAP * float(np.median(np.diff(stamps[rows]))) if len(rows) > 1 else 0.0
    rows = rows[np.isfinite(values[rows])]
    stamps, values = stamps[rows], values[rows]
    if len(stamps) < 2:  # noqa: PLR2004 - no interval
        return np.full(len(t), np.nan)
    found: Float = np.interp(t, stamps, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(stamps, t, side="right"), 1, len(stamps) - 1)
    met = stamps[np.clip(np.searchsorted(stamps, t), 0, len(stamps) - 1)] == t  # a sample, also before a gap
    found[(stamps[after] - stamps[after - 1] > longest) & ~met] = np.nan
    return found
