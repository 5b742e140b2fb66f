"""Wild samples: single values, or short runs, that no joint can have moved or carried.

A Hampel test finds what leaves the median of its neighbours by far more than the channel ever changes, and comes back.
Impacts do that too. The channels of the joint decide: a joint that went to that q has the dq for it, a joint with that
dq arrives at another q, and a torque that large changes dq.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.recording import LAG, Column, Marks, Recording
from friction_audit.joint_log import Finding, Float, Int
from friction_audit.parallel import per_joint

Pair = tuple[NDArray[np.intp], NDArray[np.intp]]
_LONGEST_RUN = 8  # rows over which a filter of the driver spreads one wild value
_REACH = _LONGEST_RUN + 4  # rows on both sides that make the median: a run is a minority there
_UNUSUAL, _UNUSUAL_ROWS = 0.005, 16  # largest changes and values left out of the scale: share, or rows of a short log
_TIMES_STEP = 10.0  # of 204 sound logs, measured and simulated, the closest torque reaches 0.76 of the scale
_TIMES_STILL = 10.0  # a channel that stands still has no usual step: the least deviation is larger by so much
_TIMES_RANGE = {"q": 0.0, "dq": 1.0}
_TIMES_RANGE_OF_TORQUE = 2.0  # dry friction turns by its whole range in one row, and a contact is as large
_LEAST = {"q": 0.05, "dq": 0.5, "temperature": 20.0}  # smaller ones do no harm [rad, rad/s, degC, N m]
_LEAST_TORQUE = 0.5
_CALM = 3.0  # a velocity that changes by more than so many usual steps may be the effect of the torque
_MOST_JUMPS = 0.01  # where more rows jump, the jumps are the channel's nature
TO_ZERO = {"q": 0.1, "dq": _LEAST["dq"]}  # jump to or from zero that no noise of a joint at rest makes [rad, rad/s]
_NEAR_STEPS = 3.5  # a longer step is a gap, in which a joint may go anywhere
_STILL_RAD = 1e-9  # displacement in a row below which a joint stands still
_SHOWN = 3
_AROUND = 2 * _REACH  # rows on both sides of a jump that decide about it


class _Run(NamedTuple):
    """Rows ``first`` to ``last`` of a channel that deviate from ``usual``, most of all with ``value``."""

    channel: str
    first: int
    last: int
    start_s: float
    value: float
    usual: float
    impossible: bool = True  # by the other channels of the joint


def leave_out_wild(
    recording: Recording, columns: Mapping[str, Column], step_s: float, *, first_s: float, numbered: bool
) -> Recording:
    """Leave out rows that hold a wild sample, and name each: by its number too where the rows are those of the file."""
    every = per_joint(lambda joint: _Wild(joint, columns, step_s, recording.rows), len(recording.joint_names))
    joints = [joint for joint in every if joint.suspected]
    if not joints:
        return recording
    _look_closely(recording, joints)
    marks, findings = Marks(recording.rows), []
    for wild in joints:
        runs = wild.runs()
        for run in runs:
            marks.add(run.first, np.ones(run.last + 1 - run.first, np.bool_))
        for channel in dict.fromkeys(run.channel for run in runs):
            own = [run for run in runs if run.channel == channel]
            findings.append(_finding(recording, wild.joint, own, first_s, numbered=numbered))
    return recording.without(marks).with_findings(*findings) if findings else recording


def _look_closely(recording: Recording, joints: "Sequence[_Wild]") -> None:
    """Give every joint all rows, each with those around it."""
    t, kept, begin, done = np.empty(0), dict[str, Float](), 0, 0
    for first, new, channels in recording.read():
        t = np.append(t, new)
        kept = {name: np.concatenate([kept[name], a]) if kept else a for name, a in channels.items()}
        end = first + len(new)
        stop = end if end == recording.rows else max(end - _AROUND, done)
        for wild in joints:
            own = {name: array[:, wild.joint] for name, array in kept.items()}
            wild.take(begin, t, own, done, stop)
            wild.take_zeros(first, new, {name: channels[name][:, wild.joint] for name in TO_ZERO})
        start = max(stop - _AROUND, 0)
        t, kept = t[start - begin :], {name: array[start - begin :].copy() for name, array in kept.items()}
        begin, done = start, stop


class _Wild:
    """The wild samples of one joint."""

    def __init__(self, joint: int, columns: Mapping[str, Column], step_s: float, rows: int) -> None:
        self.joint, self._step_s, self._rows = joint, step_s, rows
        both = ((name, one.changed[:, joint], one.sample[:, joint]) for name, one in columns.items())
        changes = {name: np.abs(after - before[: len(after)]) for name, after, before in both}  # over LAG rows
        usual = {n: float(np.quantile(a, 1.0 - _unusual(a))) if len(a) else 0.0 for n, a in changes.items()}
        self._usual_dq = usual["dq"]
        self._scales = {name: _scale(name, one.sample[:, joint], usual[name]) for name, one in columns.items()}
        self._jumping = [name for name, scale in self._scales.items() if columns[name].jump[joint] > scale]
        self._zeroed = [name for name in TO_ZERO if columns[name].zeroed[joint]]
        self.suspected = bool(self._jumping or self._zeroed)  # of more than what this pass shows
        # What q usually changes by per integral of dq: 1, or 57 where q is in degrees; 0 if it never moves.
        integral = np.abs(columns["dq"].changed[:, joint]) * LAG * step_s
        moves = integral > _STILL_RAD
        ratios = changes["q"][moves] / integral[moves]
        self._per_integral = max(float(np.median(ratios)), 1.0) if len(ratios) else 0.0
        self._most = max(_MOST_JUMPS * rows, 2 * _LONGEST_RUN)
        self._jumps = dict.fromkeys(self._jumping, 0)
        self._found: dict[str, list[_Run]] = {name: [] for name in self._jumping}
        self._zeros: dict[str, list[_Run]] = {name: [] for name in self._zeroed}
        # Of each channel the row before the zeros that go on, or the last row, and the first of these zeros.
        self._open = {name: (np.empty(0, np.int64), np.empty((0, 3))) for name in self._zeroed}

    def take(self, begin: int, t: Float, columns: Mapping[str, Float], done: int, stop: int) -> None:
        """Judge the rows from ``done`` to ``stop``, given those around them, the first of which is ``begin``."""
        for name in self._jumping:
            steps = np.abs(np.diff(columns[name][max(done - begin, 0) : stop - begin + 1]))
            jumps = np.flatnonzero(steps[: stop - done] > self._scales[name]) + (done - begin)
            self._jumps[name] += len(jumps)
            if self._jumps[name] >= self._most:
                continue
            runs = self._found[name]
            for jump in jumps.tolist():
                if not runs or begin + jump > runs[-1].last:
                    runs += self._run_at(name, begin, t, columns, jump)

    def take_zeros(self, first: int, t: Float, columns: Mapping[str, Float]) -> None:
        """Judge the runs of zeros that end in a piece."""
        for name in self._zeroed:
            rows, values = self._open[name]
            rows = np.append(rows, np.arange(first, first + len(t)))
            values = np.concatenate([values, np.column_stack([t, columns["q"], columns["dq"]])])
            more = int(rows[-1]) + 1 < self._rows
            runs, keep = _zeroed(name, rows, values, self._step_s, self._per_integral, more=more)
            self._zeros[name] += runs
            self._open[name] = rows[keep], values[keep]

    def runs(self) -> list[_Run]:
        """Return all that was found."""
        few = [found for name, found in self._found.items() if self._jumps[name] < self._most]
        judged = [run for found in few for run in found if run.impossible]
        known = {(run.channel, run.first) for run in judged}
        zeros = [run for runs in self._zeros.values() for run in runs if (run.channel, run.first) not in known]
        return judged + zeros

    def _run_at(self, name: str, begin: int, t: Float, columns: Mapping[str, Float], jump: int) -> list[_Run]:
        """Return the short run at a jump that leaves the median of its neighbours by more than the channel's scale."""
        column, scale, start = columns[name], self._scales[name], max(jump - _REACH, 0)
        near = column[start : jump + _REACH + 2]
        usual = float(np.median(near))
        away = np.abs(near - usual) > scale / 3.0
        edges = np.flatnonzero(np.diff(away, prepend=False, append=False)).reshape(-1, 2) + start
        for first, end in edges.tolist():
            at_edge = begin + first == 0 or begin + end == self._rows
            if first <= jump + 1 <= end and end - first <= (1 if at_edge else _LONGEST_RUN):
                value = float(max(column[first:end], key=lambda one: abs(one - usual)))
                if abs(value - usual) > scale:
                    run = _Run(name, begin + first, begin + end - 1, float(t[first]), value, usual)
                    return [run._replace(impossible=_is_impossible(run, first, end, columns, t, self._usual_dq))]
        return []


def _zeroed(
    channel: str, rows: Int, values: Float, step_s: float, scale: float, *, more: bool
) -> tuple[list[_Run], slice | list[int]]:
    """Return runs of zeros, of any length, that the motion contradicts, as a lost block of a file leaves them.

    Time, q and dq of the rows are ``values``, shape (n, 3); the scale is what q usually changes by per integral of dq.
    Where more rows follow, it is also returned which rows are still needed.
    """
    t, q, dq = values.T
    column = q if channel == "q" else dq
    last, zero = len(t) - 1, column == 0.0
    first, end = np.flatnonzero(np.diff(zero, prepend=False, append=False)).reshape(-1, 2).T
    needed: slice | list[int] = slice(last, None)
    if more and zero[-1]:
        needed = [int(first[-1])] if first[-1] == 0 else [int(first[-1]) - 1, int(first[-1])]
        first, end = first[:-1], end[:-1]
    if not len(first) or zero.all():
        return [], needed
    before, after = np.maximum(first - 1, 0), np.minimum(end, last)
    # At the begin and the end of the log there is but one side.
    begin = np.where(column[before], column[before], column[after])
    stop = np.where(column[after], column[after], column[before])
    if channel == "q":
        kept = np.zeros(len(first), np.bool_)
        # A step from or to the zeros that is more than the velocity allows.
        for one, other in ((before, before + 1), (after - 1, after)):
            most = np.maximum(np.abs(dq[one]), np.abs(dq[other])) * (t[other] - t[one])
            jump, near = np.abs(q[other] - q[one]), t[other] - t[one] < _NEAR_STEPS * step_s
            kept |= (jump > TO_ZERO["q"]) & near & (scale > 0.0) & (scale * most < 0.5 * jump)
    else:  # a driver may take slow motion for rest, but then the joint does not get far
        kept = np.minimum(np.abs(begin), np.abs(stop)) > TO_ZERO["dq"]
        kept &= np.abs(q[after] - q[before]) > _LEAST["q"]
    runs = []
    for row, after_it, usual in zip(first[kept].tolist(), end[kept].tolist(), (begin + stop)[kept] / 2.0, strict=True):
        run = _Run(channel, int(rows[row]), int(rows[after_it - 1]), float(t[row]), 0.0, float(usual))
        if channel == "q" or _is_impossible(run, row, after_it, {"q": q, "dq": dq}, t, 0.0):
            runs.append(run)
    return runs, needed


def _scale(channel: str, sample: Float, step: float) -> float:
    """Deviation beyond anything that a channel does, in its own unit, from some of its values and its usual step."""
    low, high = np.quantile(sample, (_unusual(sample), 1.0 - _unusual(sample)))
    least = _LEAST.get(channel, _LEAST_TORQUE) * (1.0 if step > 0.0 else _TIMES_STILL)
    return max(_TIMES_STEP * step, _TIMES_RANGE.get(channel, _TIMES_RANGE_OF_TORQUE) * float(high - low), least)


def _unusual(sample: Float) -> float:
    return min(max(_UNUSUAL, _UNUSUAL_ROWS / len(sample)), 0.25)


def _is_impossible(run: _Run, first: int, end: int, columns: Mapping[str, Float], t: Float, usual_dq: float) -> bool:
    """Ask the other channels of the joint whether what a run says took place; it lies between two places of these."""
    rows = slice(max(first - 1, 0), end + 1)
    time, q, dq = t[rows], columns["q"][rows], columns["dq"][rows]
    if run.channel == "q":
        return float(np.trapezoid(np.abs(dq), time)) < 0.5 * abs(run.value - run.usual)
    if run.channel == "dq":
        went = q[-1] - q[0]
        as_logged, between = np.trapezoid(dq, time), 0.5 * (dq[0] + dq[-1]) * (time[-1] - time[0])
        return bool(abs(went - between) < abs(went - as_logged) / 3.0)
    return bool(np.abs(np.diff(columns["dq"][max(first - 3, 0) : end + 3])).max() <= _CALM * usual_dq)


def _finding(recording: Recording, joint: int, runs: list[_Run], first_s: float, *, numbered: bool) -> Finding:
    channel, rows = runs[0].channel, sum(run.last - run.first + 1 for run in runs)
    places = [
        f"{run.value:.6g} at {run.start_s - first_s:.6g} s{f' (row {run.first + 1})' * numbered}, where "
        f"{run.usual:.4g} is usual"
        for run in runs[:_SHOWN]
    ]
    places += [f"and at {len(runs) - _SHOWN} more places"] if len(runs) > _SHOWN else []
    message = (
        f"{recording.name_of(channel, joint)} is wild: {'; '.join(places)}; the other channels of the joint show "
        f"nothing of it; {rows} row{'s' * (rows != 1)} left out"
    )
    return Finding("wild_samples", message, joint + 1, float(rows), damaged=True)
