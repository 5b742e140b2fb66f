"""What was not recorded: channels, joints and rows without numbers; and wild samples.

Wild samples: single values, or short runs, that no joint can have moved or carried.

A Hampel test finds what leaves the median of its neighbours by far more than the channel ever changes, and comes back.
Impacts do that too. The channels of the joint decide: a joint that went to that q has the dq for it, a joint with that
dq arrives at another q, and a torque that large changes dq.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.recording import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float, median_step
from friction_audit.parallel import per_joint

_ESSENTIAL = ("q", "dq", *TORQUE_CHANNELS)
ABSURD = 1e9  # no position, velocity, torque or temperature is as large, in any unit: a damaged number
_SPARSE = 0.1  # share of missing values from which a channel that is not essential is left out, rather than the rows

Counts = Mapping[str, NDArray[np.int64]]  # channel -> missing values of each joint


def leave_out_missing(recording: Recording, path: str) -> Recording:
    """Leave out channels and joints that were never recorded, then rows with anything missing.

    Raises:
        InputError: If nothing usable is left.
    """
    missing = {channel: _missing_per_joint(array) for channel, array in recording.channels.items()}
    if not any(counts.any() for counts in missing.values()) and bool(np.isfinite(recording.t).all()):
        return recording
    recording = _leave_out_channels(recording, missing, path)
    recording = _leave_out_joints(recording, {channel: missing[channel] for channel in recording.channels}, path)
    whole = np.isfinite(recording.t)
    for array in recording.channels.values():
        for column in array.T:
            if not _is_whole(column):
                whole &= np.abs(column) < ABSURD
    lost = len(whole) - int(np.count_nonzero(whole))
    if lost == 0:
        return recording
    message = f"{lost} of {len(whole)} rows hold NaN, infinity or numbers beyond {ABSURD:g}; they are left out"
    finding = Finding(code="non_finite", message=message, amount=float(lost), damaged=True)
    return recording.take_rows(whole).with_findings(finding)


def _is_whole(column: Float) -> bool:
    # NaN goes through min and max: two fast passes and no temporary array.
    return bool(column.min() > -ABSURD and column.max() < ABSURD)


def _missing_per_joint(array: Float) -> NDArray[np.int64]:
    def missing(joint: int) -> int:
        column = array[:, joint]
        return 0 if _is_whole(column) else int(np.count_nonzero(~(np.abs(column) < ABSURD)))

    return np.array(per_joint(missing, array.shape[1]), dtype=np.int64)


def _leave_out_channels(recording: Recording, missing: Counts, path: str) -> Recording:
    samples = len(recording.t)
    empty = [channel for channel, counts in missing.items() if (counts == samples).all()]
    sparse = [c for c, counts in missing.items() if c not in (*_ESSENTIAL, *empty) and counts.max() > _SPARSE * samples]
    names = {channel: f"{channel} ({recording.mapping.get(channel, channel)})" for channel in empty}
    torques = [channel for channel in TORQUE_CHANNELS if channel in recording.channels]
    lost: list[str] = [channel for channel in ("q", "dq") if channel in empty]
    lost += torques if all(channel in empty for channel in torques) else []
    if lost:
        raise InputError(
            f"{path}: {', '.join(names[channel] for channel in lost)}: none of the {samples} rows holds a number (all "
            f"NaN, infinite or beyond {ABSURD:g}); expected q, dq and one torque of {', '.join(TORQUE_CHANNELS)}; "
            "record a topic that carries them, such as the robot's own state"
        )
    findings = []
    for channel in empty:
        text = f"{names[channel]} holds no number in {samples} rows; the channel is left out"
        findings.append(Finding(code="empty_channel", message=text, amount=float(samples)))
    for channel in sparse:
        few = int(missing[channel].max())
        text = f"{channel} lacks {few} of {samples} rows; the channel is left out, the rows are kept"
        findings.append(Finding(code="sparse_channel", message=text, amount=float(few)))
    channels, mapping = dict(recording.channels), dict(recording.mapping)
    for channel in (*empty, *sparse):
        del channels[channel]
        mapping.pop(channel, None)
    return replace(recording, channels=channels, mapping=mapping).with_findings(*findings)


def _leave_out_joints(recording: Recording, missing: Counts, path: str) -> Recording:
    samples = len(recording.t)
    empty = np.zeros(len(recording.joint_names), dtype=np.bool_)
    for counts in missing.values():
        empty |= counts == samples
    if not empty.any():
        return recording
    if empty.all():
        raise InputError(
            f"{path}: no joint has q, dq and torque together; each lacks one of them in all {samples} rows"
        )
    findings = []
    for joint in map(int, np.flatnonzero(empty)):
        text = f"{recording.joint_names[joint]} lacks a channel in all {samples} rows; the joint is left out"
        findings.append(Finding(code="empty_joint", message=text, joint=joint + 1, amount=float(samples)))
    return recording.take_joints([int(joint) for joint in np.flatnonzero(~empty)]).with_findings(*findings)


_LONGEST_RUN = 8  # rows over which a filter of the driver spreads one wild value
_REACH = _LONGEST_RUN + 4  # rows on both sides that make the median: a run is a minority there
LAG = 3  # changes are taken over three rows: neighbouring rows of a slow or coarse channel are often equal
_UNUSUAL, _UNUSUAL_ROWS = 0.005, 16  # largest changes and values left out of the scale: share, or rows of a short log
_TIMES_STEP = 10.0  # of 204 sound logs, measured and simulated, the closest torque reaches 0.76 of the scale
_TIMES_STILL = 10.0  # a channel that stands still has no usual step: the least deviation is larger by so much
_TIMES_RANGE = {"q": 0.0, "dq": 1.0}
_TIMES_RANGE_OF_TORQUE = 2.0  # dry friction turns by its whole range in one row, and a contact is as large
_LEAST = {"q": 0.05, "dq": 0.5, "temperature": 20.0}  # smaller ones do no harm [rad, rad/s, degC, N m]
_LEAST_TORQUE = 0.5
_CALM = 3.0  # a velocity that changes by more than so many usual steps may be the effect of the torque
MOST_SAMPLES = 1 << 16  # from which quantiles are taken, for speed
_MOST_JUMPS = 0.01  # where more rows jump, the jumps are the channel's nature
_LEAST_TO_ZERO = 0.1  # jump of q to or from zero that no noise of a joint at rest makes [rad]
_NEAR_STEPS = 3.5  # a longer step is a gap, in which a joint may go anywhere
_STILL_RAD = 1e-9  # way in a row below which a joint stands still
_SHOWN = 3
_BLOCK = 1 << 15  # samples whose steps are compared at a time


@dataclass(frozen=True, kw_only=True, slots=True)
class _Run:
    """Rows ``first`` to ``last`` of a channel that deviate from ``usual``, most of all with ``value``."""

    channel: str
    first: int
    last: int
    value: float
    usual: float


def leave_out_wild(recording: Recording, *, first_s: float, numbered: bool) -> Recording:
    """Leave out rows that hold a wild sample, and name each.

    Args:
        recording: In order of time.
        first_s: Time of the log's first sample on the recording's clock. [s]
        numbered: True if the rows still are those of the file, so that their numbers can be named.
    """
    per = per_joint(lambda joint: _of_joint(recording, joint), len(recording.joint_names))
    if not any(per):
        return recording
    kept = np.ones(len(recording.t), dtype=np.bool_)
    for run in (run for runs in per for run in runs):
        kept[run.first : run.last + 1] = False
    findings = [
        _finding(recording, joint, [run for run in runs if run.channel == channel], first_s, numbered=numbered)
        for joint, runs in enumerate(per)
        for channel in dict.fromkeys(run.channel for run in runs)
    ]
    return recording.take_rows(kept).with_findings(*findings)


def _of_joint(recording: Recording, joint: int) -> list[_Run]:
    columns = {channel: array[:, joint] for channel, array in recording.channels.items()}
    found = (run for channel, column in columns.items() for run in _deviations(channel, column))
    wild = [run for run in found if _is_impossible(run, columns, recording.t)]
    known = {(run.channel, run.first) for run in wild}
    zeroed = (run for channel in ("q", "dq") for run in _zeroed(channel, columns, recording.t))
    return [*wild, *(run for run in zeroed if (run.channel, run.first) not in known)]


def _way_per_integral(q: Float, dq: Float, t: Float) -> float:
    """Return what q usually changes by per integral of dq: 1, or 57 where q is in degrees; 0 if it never moves."""
    every = max(len(q) // MOST_SAMPLES, 1)
    change, integral = np.abs(np.diff(q))[::every], (np.abs(dq[1:]) * np.diff(t))[::every]
    moves = integral > _STILL_RAD
    return max(float(np.median(change[moves] / integral[moves])), 1.0) if moves.any() else 0.0


def _zeroed(channel: str, columns: Mapping[str, Float], t: Float) -> Iterator[_Run]:
    """Yield runs of zeros, of any length, that the motion contradicts: numbers that a lost block of a file had."""
    column, dq, last = columns[channel], columns["dq"], len(t) - 1
    zero = column == 0.0
    if not zero.any() or zero.all():
        return
    first, end = np.flatnonzero(np.diff(zero, prepend=False, append=False)).reshape(-1, 2).T
    before, after = np.maximum(first - 1, 0), np.minimum(end, last)
    usual = np.where(first == 0, column[after], np.where(end > last, column[before], 0.0))
    begin, stop = np.where(first == 0, usual, column[before]), np.where(end > last, usual, column[after])
    if channel == "q":  # no joint that was there a row ago can be at zero by now
        scale = _way_per_integral(column, dq, t)
        kept = np.zeros(len(first), dtype=np.bool_)
        for one, other in ((before, np.minimum(first, last)), (end - 1, after)):
            way = np.maximum(np.abs(dq[one]), np.abs(dq[other])) * (t[other] - t[one])
            jump, near = np.abs(column[other] - column[one]), t[other] - t[one] < _NEAR_STEPS * median_step(t)
            kept |= (jump > _LEAST_TO_ZERO) & near & (scale > 0.0) & (scale * way < 0.5 * jump)
    else:  # a driver may take slow motion for rest, but then the joint does not get far
        kept = np.minimum(np.abs(begin), np.abs(stop)) > _LEAST["dq"]
        kept &= np.abs(columns["q"][after] - columns["q"][before]) > _LEAST["q"]
    for place in map(int, np.flatnonzero(kept)):
        rows = {"first": int(first[place]), "last": int(end[place]) - 1}
        run = _Run(channel=channel, **rows, value=0.0, usual=float(begin[place] + stop[place]) / 2.0)
        if channel == "q" or _is_impossible(run, columns, t):
            yield run


def _deviations(channel: str, column: Float) -> list[_Run]:
    """Return the short runs that leave the median of their neighbours by more than the channel's own scale."""
    scale = _scale(channel, column)
    # Block by block: a sound channel costs one pass in the processor's cache.
    blocks = (np.abs(np.diff(column[first : first + _BLOCK + 1])) > scale for first in range(0, len(column), _BLOCK))
    jumps = np.concatenate([number * _BLOCK + np.flatnonzero(block) for number, block in enumerate(blocks)])
    runs: list[_Run] = []
    for jump in jumps if len(jumps) < max(_MOST_JUMPS * len(column), 2 * _LONGEST_RUN) else ():
        if not runs or jump > runs[-1].last:
            runs += _run_at(channel, column, int(jump), scale)
    return runs


def _scale(channel: str, column: Float) -> float:
    every = max(len(column) // MOST_SAMPLES, 1)
    return scale_of(channel, column[::every], _usual_step(column))


def scale_of(channel: str, sample: Float, step: float) -> float:
    """Deviation beyond anything that a channel does, in its own unit, from some of its values and its usual step."""
    low, high = np.quantile(sample, (_unusual(sample), 1.0 - _unusual(sample)))
    least = _LEAST.get(channel, _LEAST_TORQUE) * (1.0 if step > 0.0 else _TIMES_STILL)
    return max(_TIMES_STEP * step, _TIMES_RANGE.get(channel, _TIMES_RANGE_OF_TORQUE) * float(high - low), least)


def _usual_step(column: Float) -> float:
    every = max(len(column) // MOST_SAMPLES, 1)
    return usual_change(column[LAG:][::every] - column[:-LAG][::every])


def usual_change(changes: Float) -> float:
    """Return the largest of changes but for the few unusual ones."""
    return float(np.quantile(np.abs(changes), 1.0 - _unusual(changes))) if len(changes) else 0.0


def _unusual(sample: Float) -> float:
    return min(max(_UNUSUAL, _UNUSUAL_ROWS / len(sample)), 0.25)


def _run_at(channel: str, column: Float, jump: int, scale: float) -> list[_Run]:
    start = max(jump - _REACH, 0)
    near = column[start : jump + _REACH + 2]
    usual = float(np.median(near))
    away = np.abs(near - usual) > scale / 3.0
    edges = np.flatnonzero(np.diff(away, prepend=False, append=False)).reshape(-1, 2) + start
    for first, end in edges:
        at_edge = first == 0 or end == len(column)
        if first <= jump + 1 <= end and end - first <= (1 if at_edge else _LONGEST_RUN):
            value = float(max(column[first:end], key=lambda one: abs(one - usual)))
            if abs(value - usual) > scale:
                return [_Run(channel=channel, first=int(first), last=int(end) - 1, value=value, usual=usual)]
    return []


def _is_impossible(run: _Run, columns: Mapping[str, Float], t: Float) -> bool:
    """Ask the other channels of the joint whether what a run says took place."""
    rows = slice(max(run.first - 1, 0), run.last + 2)
    time, q, dq = t[rows], columns["q"][rows], columns["dq"][rows]
    if run.channel == "q":
        return float(np.trapezoid(np.abs(dq), time)) < 0.5 * abs(run.value - run.usual)
    if run.channel == "dq":
        went = q[-1] - q[0]
        as_logged, between = np.trapezoid(dq, time), 0.5 * (dq[0] + dq[-1]) * (time[-1] - time[0])
        return bool(abs(went - between) < abs(went - as_logged) / 3.0)
    wide = columns["dq"][max(run.first - 3, 0) : run.last + 4]
    return bool(np.abs(np.diff(wide)).max() <= _CALM * _usual_step(columns["dq"]))


def _finding(recording: Recording, joint: int, runs: list[_Run], first_s: float, *, numbered: bool) -> Finding:
    channel, t = runs[0].channel, recording.t - first_s
    rows = sum(run.last - run.first + 1 for run in runs)
    places = [
        f"{run.value:.6g} at {t[run.first]:.6g} s{f' (row {run.first + 1})' if numbered else ''}, where "
        f"{run.usual:.4g} is usual"
        for run in runs[:_SHOWN]
    ]
    more = f"; and at {len(runs) - _SHOWN} more places" if len(runs) > _SHOWN else ""
    message = (
        f"{recording.name_of(channel, joint)} is wild: "
        f"{'; '.join(places)}{more}; the other channels of the joint show nothing of it; "
        f"{rows} row{'' if rows == 1 else 's'} left out"
    )
    return Finding(code="wild_samples", message=message, joint=joint + 1, amount=float(rows), damaged=True)
