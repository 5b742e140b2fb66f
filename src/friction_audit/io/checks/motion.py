"""Do q, dq and the clock belong together? Degrees, a wrong time unit, a stretched clock, a wrong column.

The change of q over the integral of dq, per joint, from a regression over many short windows of time, is 1 if all is
well, 57.3 if q is in degrees, 1000 if the clock was read in the wrong unit, 1.05 if it runs 5 % too short or dq reads
5 % too small.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.checks.clock import Clock, gap_threshold_s
from friction_audit.io.recording import Block, Column, Recording
from friction_audit.joint_log import DERIVATIVE, Finding, Float

_TRAVELLED = 0.1  # range of q that no noise of a joint at rest makes [rad]
_DISAGREES = 0.05
_WINDOWS_S = (0.5, 2.0, 8.0)  # the longer ones are for joints that move too slowly for the short ones
_WINDOW_SAMPLES = 15
_FEWEST_PARTS = 16
_MOST_SAMPLES = 1 << 18  # of longer logs, windows are spread evenly over the whole
_MOVED = 0.003  # change of q over a window from which on the joint counts as moving there [rad]
_SURELY_MOVED = 0.05  # integral of dq over a short window that no noise or offset of a joint at rest makes [rad]
_FEWEST_WINDOWS = 5
_TRUSTED_R2, _UNRELATED_R2 = 0.8, 0.5


class MotionRatio(NamedTuple):
    """Change of q over integral of dq."""

    ratio: Float  # one per joint, NaN where the joint hardly moves, shape (j,)
    determination: Float  # R^2, the share of the change of q that the integral explains, shape (j,)
    windows: np.ndarray  # windows of time in which the joint moved, 0 where it hardly moves, shape (j,)

    @property
    def trusted(self) -> np.ndarray:
        """True for the joints whose motion is explained: a wrong column and a joint at rest do not vote."""
        return self.determination > _TRUSTED_R2

    @property
    def common(self) -> float:
        """Median of the ratios that most joints agree on, of equal shares of the one nearest 1, or NaN."""
        votes = self.ratio[self.trusted]
        if not len(votes):
            return float("nan")
        agree = np.abs(votes[:, None] / votes[None, :] - 1.0) <= _DISAGREES
        best = max(range(len(votes)), key=lambda one: (int(agree[:, one].sum()), -abs(votes[one] - 1.0)))
        return float(np.median(votes[agree[:, best]]))


class Windows:
    """Motion over windows of time without holes, gathered piece by piece."""

    def __init__(self, clock: Clock, longest_s: float, joints: int) -> None:
        """Choose windows of one length, _MOST_SAMPLES together at most."""
        span, self._rows, self._next = clock.last_s - clock.first_s, clock.rows, 0
        step = span / (clock.rows - 1)
        # The step is in doubt, its unit may be misjudged: a window never is a large part of the log.
        length = max(_WINDOW_SAMPLES * step, min(longest_s, span / _FEWEST_PARTS))
        begin = clock.first_s + length * np.arange(int(span / length))
        most = max(int(_MOST_SAMPLES * step / length), 1)
        if len(begin) > most:
            begin = begin[np.linspace(0, len(begin) - 1, most).astype(np.intp)]
        self._order = np.argsort(np.append(begin, begin + length), kind="stable")
        self._times = np.append(begin, begin + length)[self._order]
        self._places = np.full(len(self._times), clock.rows - 1)
        self._found = np.empty((len(self._times), 3, joints))

    def rows_in(self, first: int, t: Float) -> NDArray[np.intp]:
        """Return the rows of the next piece at which windows begin or end, and note them."""
        stop = len(self._times)
        if first + len(t) < self._rows:
            stop = self._next + int(np.searchsorted(self._times[self._next :], t[-1], side="right"))
        rows = np.minimum(np.searchsorted(t, self._times[self._next : stop]), len(t) - 1)
        self._places[self._next : stop] = first + rows
        return rows

    def take(self, q: Float, dq: Float, integral: Float) -> None:
        """Take the signals at these rows."""
        own = slice(self._next, self._next + len(q))
        self._found[own, 0], self._found[own, 1], self._found[own, 2] = q, dq, integral
        self._next = own.stop

    def whole(self, holes: Sequence[tuple[int, float, float]], gap_s: float) -> tuple[Float, Float]:
        """Return q, dq and the integral of dq at begin and end of the windows without a gap, shape (m, 3, j) each."""
        begin, end = np.split(np.argsort(self._order), 2)
        gaps = np.array([row for row, before, after in holes if after - before > gap_s], np.int64)
        starts, stops = self._places[begin], self._places[end]
        kept = (stops > starts) & (np.searchsorted(gaps, starts) == np.searchsorted(gaps, stops))
        return self._found[begin[kept]], self._found[end[kept]]


class Motion:
    """Gathers what tells whether q, dq and the clock belong together."""

    def __init__(self, clock: Clock, joints: int) -> None:
        self._windows = [Windows(clock, longest_s, joints) for longest_s in _WINDOWS_S]
        self._integral = np.zeros(joints)
        self._gap_s = gap_threshold_s(clock.step_s)

    def take(self, first: int, t: Float, before: tuple[float, Float], q: Float, dq: Float) -> None:
        """Take the rows of a piece, given stamp and dq of the row before it."""
        several = [windows.rows_in(first, t) for windows in self._windows]
        # As np.unique, which loads numpy.ma first.
        rows = np.flatnonzero(np.bincount(np.concatenate([*several, [len(t) - 1]])))
        # Each dq counts for half of the steps on both of its sides; the step after a row is not yet in its integral.
        steps = 0.5 * np.diff(t, prepend=before[0])
        after = np.append(steps[1:], 0.0)
        starts, weights = np.append(0, rows[:-1] + 1), steps + after
        sums = np.stack([np.add.reduceat(column * weights, starts) for column in dq.T], axis=1)
        sums[0] += before[1] * steps[0] + self._integral
        integral = np.cumsum(sums, axis=0) - dq[rows] * after[rows, None]
        self._integral = integral[-1]
        for windows, own in zip(self._windows, several, strict=True):
            windows.take(q[own], dq[own], integral[np.searchsorted(rows, own)])

    def ratios(self, holes: Sequence[tuple[int, float, float]]) -> MotionRatio:
        """Regress the change of q on the integral of dq and, for a delay, on the change of dq, per joint."""
        several = [windows.whole(holes, self._gap_s) for windows in self._windows]
        joints = range(len(self._integral))
        found = [_first_that_moves([(begin[..., j], end[..., j]) for begin, end in several]) for j in joints]
        return MotionRatio(*map(np.array, zip(*found, strict=True)))


def _first_that_moves(several: Sequence[tuple[Float, Float]]) -> tuple[float, float, int]:
    """Return ratio, determination and number of windows for the shortest windows in which the joint moves."""
    for least, (begin, end) in zip((_SURELY_MOVED, np.inf, np.inf), several, strict=True):
        if len(begin) < _FEWEST_WINDOWS:
            continue
        change, dq_change, integral = (end - begin).T
        moved = (np.abs(change) > _MOVED) | (np.abs(integral) > least)
        if np.count_nonzero(moved) < _FEWEST_WINDOWS or not integral[moved].any():
            continue
        ratio, determination = _ratio(change[moved], integral[moved], dq_change[moved])
        # A coarse encoder flickers at rest by more than _MOVED, and a velocity has an offset.
        at_rest = np.abs(integral).max() <= _SURELY_MOVED and np.ptp(begin[:, 0]) <= _TRAVELLED
        if determination > _TRUSTED_R2 or not at_rest:
            return ratio, determination, int(moved.sum())
    return float("nan"), 0.0, 0


def _ratio(change: Float, integral: Float, dq_change: Float) -> tuple[float, float]:
    """Fit change = ratio * integral + delay * dq_change, twice: the second time without the outliers of the first."""
    columns = np.column_stack((integral, dq_change))
    kept = np.ones(len(change), dtype=np.bool_)
    for _ in range(2):
        solution = np.linalg.lstsq(columns[kept], change[kept], rcond=None)[0]
        residual = np.abs(change - columns @ solution)
        kept = residual <= max(6.0 * float(np.median(residual)), 1e-12)
    total = float(np.dot(change, change))
    return float(solution[0]), 1.0 - float(np.dot(residual, residual)) / total if total > 0.0 else 0.0


_TO_RADIANS = np.pi / 180.0
# Unit -> its channel, what makes rad or rad/s of it, and how near the ratio of the change of q to the integral of dq
# must be to that of the unit.
_OTHER_UNITS = {
    "rpm": ("dq", np.pi / 30.0, 0.05),
    "turns per second": ("dq", 2.0 * np.pi, 0.05),
    "turns": ("q", 2.0 * np.pi, 0.05),
    "degrees": ("q", _TO_RADIANS, 0.1),
    "degrees per second": ("dq", _TO_RADIANS, 0.1),
}
_LARGEST_Q_RAD = 4.0 * np.pi
_LARGEST_DQ_RAD_S = 12.0
_LARGEST_Q_DEG = 720.0  # beyond, a joint turns without end, in any unit: a bench rig, where magnitudes prove nothing
_RETURNS = 0.1  # share of samples against the usual direction from which on a joint goes to and fro
_STRETCHED = 0.02
_STRETCHED_TOO_FAR = 1.5
_TINY = 1e-3  # no clock is wrong by more than units are: with a smaller ratio q does not follow dq at all
_UNIT_FACTORS = (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9)
_STEPS_S = (5e-5, 0.5)  # between samples of a log of 2 Hz to 20 kHz
_LOG_STEPS_S = (5e-7, 100.0)  # of any log at all
_TURNS, _OF_A_TURN = (2.0 * np.pi, 360.0), 0.08  # by which q jumps at the end of a turn, to this share


def join_turns(recording: Recording, columns: Mapping[str, Column]) -> Recording:
    """Return the recording with positions that go on where a joint passes the end of a turn, in rad or degrees."""
    jump = columns["q"].jump
    turn = next((turn for turn in _TURNS if (np.abs(jump - turn) < _OF_A_TURN * turn).any()), None)
    if turn is None:
        return recording
    wrapped = np.flatnonzero(np.abs(jump - turn) < _OF_A_TURN * turn)

    def mend(blocks: Iterator[Block]) -> Iterator[Block]:
        before: Float | None = None
        turns = np.zeros(len(wrapped))
        for t, channels in blocks:
            if "q" in channels and len(t):
                q = channels["q"][:, wrapped]
                steps = np.diff(q, axis=0, prepend=q[:1] if before is None else before)
                ends = np.where(np.abs(np.abs(steps) - turn) < _OF_A_TURN * turn, -np.sign(steps), 0.0)
                before, passed = q[-1:], turns + np.cumsum(ends, axis=0)
                channels["q"][:, wrapped] += turn * passed
                turns = passed[-1]
            yield t, channels

    text = f"q ({recording.mapping.get('q', 'q')}) jumps by a turn at the end of its range; it is made continuous"
    found = [Finding("turns_joined", text, joint + 1) for joint in wrapped.tolist()]
    return recording.mended(mend).with_findings(*found)


def refuse_dead_velocity(recording: Recording, columns: Mapping[str, Column], clock: Clock) -> Recording:
    """Name the joints whose dq is one number while q moves; InputError where no joint that moves has a velocity."""
    q, dq = columns["q"], columns["dq"]
    travelled, turned = q.highest - q.lowest, np.abs(dq.sample[0]) * (clock.last_s - clock.first_s)
    dead = (travelled > _TRAVELLED) & (dq.highest == dq.lowest) & (turned < 0.5 * travelled)
    said = [
        f"{recording.name_of('dq', joint)} is {dq.sample[0, joint] + 0.0:g} in all {clock.rows} rows while q moves by "
        f"{travelled[joint]:.3g}; its velocity was not recorded: name another column with --map dq=<column>, or make "
        "the velocity from q with --map dq=derivative"
        for joint in map(int, np.flatnonzero(dead))
    ]
    if said and dead.sum() == np.count_nonzero(travelled > _TRAVELLED):
        raise InputError(f"{recording.path}: {said[0]}{'; so it is on all joints that move' if len(said) > 1 else ''}")
    numbers = (np.flatnonzero(dead) + 1).tolist()
    return recording.with_findings(*(Finding("velocity_dead", *one) for one in zip(said, numbers, strict=True)))


def check_motion(recording: Recording, ratios: MotionRatio, *, scaled: bool) -> Recording:
    """Notice columns of the wrong joint and a stretched clock; InputError, unless the user has scaled it, if by far."""
    if recording.mapping.get("dq") != DERIVATIVE:  # one made from q proves nothing
        recording = replace(recording, clock_windows=int(ratios.windows[ratios.trusted].sum()))
    # The joints whose q does not follow their own dq while that of others does.
    wrong = np.isfinite(ratios.ratio)
    if np.isfinite(ratios.common):
        wrong &= np.abs(ratios.ratio / ratios.common - 1.0) > _DISAGREES
    else:
        wrong &= ~ratios.trusted
    found = [_mismatch(recording, ratios, joint) for joint in np.flatnonzero(wrong).tolist()]
    if found and wrong.sum() == np.isfinite(ratios.ratio).sum() and ratios.determination[wrong].max() < _UNRELATED_R2:
        raise InputError(
            f"{recording.path}: {found[0].message}{'; so it is on all joints that move' if len(found) > 1 else ''}; or "
            "the rows are of several joints: name the joint of each row in a column called 'joint'"
        )
    ratio = ratios.common
    if np.isfinite(ratio) and abs(ratio - 1.0) > _STRETCHED:  # the clock runs at another speed than the motion
        if not 1.0 / _STRETCHED_TOO_FAR < ratio < _STRETCHED_TOO_FAR and not scaled:
            clock = f"the clock is wrong (--time-scale {ratio:.4g}), dq has another scale or unit (multiply it by "
            raise InputError(
                f"{recording.path}: the change of q is {ratio:.3g} times the integral of dq over time; expected 1: "
                f"{f'{clock}{ratio:.4g}), or ' * (ratio > _TINY)}q and dq are of different joints, or of opposite sign "
                "(--map)"
            )
        message = (
            f"the change of q is {ratio:.4g} times the integral of dq: either the clock is wrong by that factor "
            f"(correct it with --time-scale {ratio:.4g}), or dq is (multiply it by {ratio:.4g}); compare the duration "
            "with a watch"
        )
        found.append(Finding("clock_stretched", message, amount=ratio))
    return recording.with_findings(*found)


def turn_to_radians(recording: Recording, columns: Mapping[str, Column], ratio: float) -> Recording:
    """Turn q, dq or both into radians where their ratio says another unit, or with their magnitudes degrees."""
    every_q, every_dq = (np.fmax(-column.lowest, column.highest) for column in (columns["q"], columns["dq"]))
    largest = {"q": float(every_q.max()), "dq": float(every_dq.max())}
    is_beyond = largest["q"] > _LARGEST_Q_RAD
    said = ((unit, factor if c == "dq" else 1.0 / factor, near) for unit, (c, factor, near) in _OTHER_UNITS.items())
    units = [unit for unit, expected, near in said if _near(ratio, expected, near)]
    if np.isnan(ratio) and is_beyond:
        units = ["degrees"]
    elif _near(ratio, 1.0, 0.3) and is_beyond and largest["dq"] > _LARGEST_DQ_RAD_S:
        if re.search("(?<![a-zA-Z])(rad|deg)", recording.mapping.get("q", "")):
            return recording
        of_motor = "motor" in recording.mapping.get("q", "").lower()
        moves = columns["q"].highest - columns["q"].lowest > _TRAVELLED
        mixed = 2 * np.count_nonzero(every_q[moves] > _LARGEST_Q_RAD) < np.count_nonzero(moves)
        if len(recording.joint_names) == 1 or largest["q"] > _LARGEST_Q_DEG or of_motor or mixed:
            _refuse_degrees(recording, float(np.mean(columns["dq"].sample > 0.0)), **largest)
            message = (
                f"q reaches {largest['q']:.4g} and dq {largest['dq']:.4g}: a rig that turns without end, or degrees; "
                "read as rad and rad/s; degrees are given as --map q=NAME:deg, counts of an encoder as --map "
                "q=NAME:COUNTS/rev"
            )
            return recording.with_findings(Finding("degrees_suspected", message, amount=largest["q"]))
        units = ["degrees", "degrees per second"]
    for unit in units:
        channel, factor, _ = _OTHER_UNITS[unit]
        of_dq = "q hardly moves" if np.isnan(ratio) else f"the change of q is {ratio:.3g} times the integral of dq"
        message = (
            f"{channel} is in {unit}: it reaches {largest[channel]:.4g}, and {of_dq}; it was turned into radians, "
            f"times {factor:.4g}"
        )
        position, velocity = Finding("position_unit", message), Finding("velocity_unit", message, amount=1.0 / factor)
        finding = position if channel == "q" else velocity
        finding = Finding("degrees", message, amount=largest[channel]) if factor == _TO_RADIANS else finding
        recording = recording.scaled(channel, factor).with_findings(finding)
    return recording


def _refuse_degrees(recording: Recording, forwards: float, q: float, dq: float) -> None:
    """Refuse a table whose joints go to and fro by many radians, if it is radians; a bag has no names to say it."""
    is_arm = len(recording.joint_names) > 1
    if recording.topic is None and (is_arm or q <= _LARGEST_Q_DEG) and _RETURNS < forwards < 1.0 - _RETURNS:
        named = [(c, n) for c in ("q", "dq") if (n := recording.mapping.get(c, c)) != DERIVATIVE]
        degrees, radians = (" ".join(f"--map {c}={n}:{unit}" for c, n in named) for unit in ("deg", "rad"))
        raise InputError(
            f"{recording.path}: q ({named[0][1]}) oscillates up to {q:.4g} and dq up to {dq:.4g}: "
            f"degrees, or a motor of many turns; expected rad and rad/s of the joint; use {degrees}, or {radians}; "
            "divide the columns of a motor by the gear ratio, give counts of an encoder as --map q=NAME:COUNTS/rev, "
            "and leave an axis in mm out (--map q=... of the other joints)"
        )


def _near(value: float, target: float, tolerance: float = 0.1) -> bool:
    return abs(value / target - 1.0) < tolerance


def mend_unit(recording: Recording, ratio: float, step_s: float) -> Recording:
    """A factor of a thousand between motion and clock is a unit misjudged from the time step, and mended.

    Where that would give a sampling rate of no log, it is a unit of q or dq. InputError if the clock runs too fast or
    too slowly for any log, and the motion does not say by what factor.
    """
    factor = next((factor for factor in _UNIT_FACTORS if _near(ratio, factor, 0.3)), None)
    if factor is None or not _STEPS_S[0] <= factor * step_s <= _STEPS_S[1]:
        low, high = _LOG_STEPS_S
        if not low <= step_s <= high:
            raise InputError(
                f"{recording.path}: time ({recording.mapping.get('t', recording.clock)}) advances by {step_s:.3g} s a "
                f"row; expected {low:g} to {high:g} s; its unit is another one: give the factor with --time-scale"
            )
        return recording
    message = (
        f"the motion runs {ratio:.4g} times too fast for the clock ({recording.mapping.get('t', recording.clock)}): "
        f"its unit was misjudged; time was multiplied by {factor:g}"
    )
    finding = Finding("time_unit", message, amount=factor)
    return recording.changed(lambda t, channels: (t * factor, channels)).with_findings(finding)


def _mismatch(recording: Recording, ratios: MotionRatio, joint: int) -> Finding:
    ratio = float(ratios.ratio[joint])
    message = (
        f"{recording.joint_names[joint]}: the change of q is {ratio:.3g} times the integral of dq, which explains "
        f"{max(ratios.determination[joint], 0.0):.0%} of it; "
    )
    if ratios.trusted[joint] and ratio > _TINY:
        factor = ratio / ratios.common
        message += (
            f"on other joints {ratios.common:.3g} times: dq of this joint has another scale or unit; multiply its dq "
            f"by {factor:.4g}, or name its own column with --map dq=<column>"
        )
        return Finding("velocity_scale", message, joint + 1, factor)
    message += "check that both columns are of this joint"
    return Finding("position_mismatch", message, joint + 1, ratio)
