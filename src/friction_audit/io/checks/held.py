"""Rows that repeat the one before; channels held until the next value of a slower topic; velocities of mostly noise.

A value that is held until the next one comes late by half of their period on average. Against channels that are not
held, friction is then wrong in proportion to the speed and to the acceleration, so values are interpolated between
updates. Noise of a velocity adds to the integral of its square, by which viscous friction is divided.
"""

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from friction_audit.io.checks.clock import GAP_S
from friction_audit.io.recording import Block, Column, Marks, Picked, Recording, Thinned, WholeLogError
from friction_audit.joint_log import DERIVATIVE, TORQUE_CHANNELS, Bool, Finding, Float

MOVING_RAD_S = 0.02
# Share of stale rows, of those in motion, from which on the state itself is slow, and the logger did not stall.
_HELD_SHARE = 0.5
_HELD_PERIODS = 3.5  # a state that is held for more of its own periods did stall
_TIMED = ("q", "dq", *TORQUE_CHANNELS, "gravity", "tau_compensation")
_STRETCHES, _LENGTH = 32, 1024  # of neighbouring rows that are looked at
_FEWEST_UPDATES = 20
_SHORTEST = 3.0  # rows of a usual run of equal values; the delay of shorter ones is below the jitter of clocks
_IRREGULAR = 0.1  # share of runs that last less than half of the usual one: values that are equal by chance have more
# Change at an update, over the smallest, that counts: a coarse value that moves slowly changes by its resolution each
# time; where it moves faster, it changes at every row.
_STEPS = 1.5
_LATE = 1.5  # usual runs after which an update was missed
_TRAVELLED_RAD = 0.1  # a joint that stands still has noise alone
_NOISY = 0.05  # share of noise in the mean square of a velocity in motion


class Stale:
    """Finds rows that are equal to the row before in q, dq and torque while a joint moves; at rest that is right."""

    def __init__(self, recording: Recording) -> None:
        logged = [name for name in recording.channels if recording.mapping.get(name) != DERIVATIVE]
        self._names = [name for name in ("dq", "q", *TORQUE_CHANNELS) if name in logged]
        self.rows, self.marks = recording.rows, Marks(recording.rows)
        # Rows that repeat one before, and the times between rows that are new where some between them are not. [s]
        self.repeats, self.steps = 0, Thinned()
        self._fresh = 0, 0.0

    def take(self, first: int, t: Float, before: Mapping[str, Float], channels: Mapping[str, Float]) -> None:
        """Take the rows of a piece, given the row before it."""
        columns = (pair for name in self._names for pair in zip(channels[name].T, before[name], strict=True))
        column, old = next(columns)
        equal = np.flatnonzero(column == np.append(old, column[:-1]))
        for column, old in columns:
            if not len(equal):
                break
            equal = equal[column[equal] == np.where(equal > 0, column[equal - 1], old)]
        equal = equal[equal + first > 0]
        if len(equal):
            equal = equal[(np.abs(channels["dq"][equal]) > MOVING_RAD_S).any(axis=1)]
        fresh = np.ones(len(t), np.bool_)
        fresh[equal] = False
        self.marks.add(first, ~fresh)
        if self.marks.count:
            rows = np.flatnonzero(fresh)
            repeats = np.diff(rows + first, prepend=self._fresh[0]) - 1
            self.steps.take(np.diff(t[rows], prepend=self._fresh[1])[repeats > 0])
            self.repeats += int(repeats[repeats > 0].sum())
        if fresh.any():
            last = int(np.flatnonzero(fresh)[-1]) if len(equal) else len(t) - 1
            self._fresh = first + last, float(t[last])


def drop_stale_samples(recording: Recording, stale: Stale, columns: Mapping[str, Column]) -> Recording:
    """Drop rows equal to the row before while a joint moves; WholeLogError where the state is slow and in blocks."""
    marks = stale.marks
    moves = stale.rows * float((np.abs(columns["dq"].sample) > MOVING_RAD_S).any(axis=1).mean())
    period = float(np.median(stale.steps.values)) if stale.repeats else 0.0
    if marks.count and _HELD_PERIODS * period > GAP_S and stale.repeats >= _HELD_SHARE * moves:
        if recording.blocks is not None:
            raise WholeLogError
        # Rows of a state that is new less often than a hole is long are kept: its steps would pass for holes.
        lost = marks.of(0, stale.rows)
        rows = np.flatnonzero(~lost)
        steps, repeats = np.diff(recording.t[rows]), np.diff(rows) - 1
        held = (repeats > 0) & (steps <= _HELD_PERIODS * period)
        for row in np.flatnonzero(held):
            lost[rows[row] : rows[row + 1]] = False
        message = (
            f"q, dq and torque are updated only every {period:.3g} s (a bus that polls the motors in turn?); "
            f"{repeats[held].sum()} repeated rows are kept"
        )
        recording = recording.with_findings(Finding("slow_state", message, amount=period))
        marks = Marks(stale.rows)
        marks.add(0, lost)
    if not marks.count:
        return recording
    message = (
        f"{marks.count} of {stale.rows} rows ({marks.count / stale.rows:.1%}) are duplicate samples (logged faster "
        "than the robot updates); they are removed"
    )
    return recording.without(marks).with_findings(Finding("stale_samples", message, amount=float(marks.count)))


class Stretches:
    """Neighbouring rows of all channels, at places spread evenly over a recording."""

    def __init__(self, recording: Recording) -> None:
        rows, joints = recording.rows, len(recording.joint_names)
        count, length = (_STRETCHES, _LENGTH) if rows > _STRETCHES * _LENGTH else (1, rows)
        starts = np.linspace(0, rows - length, count).astype(np.int64)
        self._places, self._shape = (starts[:, None] + np.arange(length)).ravel(), (count, length, joints)
        names = (name for name in recording.channels if name != "temperature")
        self._picked = {name: Picked(self._places, joints) for name in names}

    def take(self, first: int, channels: Mapping[str, Float]) -> None:
        """Take the rows of a piece."""
        for name, picked in self._picked.items():
            picked.take(first, channels[name])

    def of(self, name: str) -> Float:
        """Return the rows of a channel, shape (stretches, rows, j)."""
        return self._picked[name].values.reshape(self._shape)


def interpolate_held(recording: Recording, near: Stretches, step_s: float) -> Recording:
    """Return the recording with held values interpolated between their updates; WholeLogError if it is in blocks."""
    if any(finding.code == "slow_state" for finding in recording.findings):  # all channels are held together
        return recording
    moving = np.abs(near.of("dq")) > MOVING_RAD_S
    found, findings = {}, []
    for name in (name for name in _TIMED if name in recording.channels):
        values = near.of(name)
        periods = [_period(values[..., j], moving[..., j]) for j in range(values.shape[2])]
        if not any(periods) or recording.mapping.get(name) == DERIVATIVE:
            continue
        found[name] = periods
        period_s = step_s * float(np.median([period for period in periods if period]))
        held = [joint for joint, period in zip(recording.joint_names, periods, strict=True) if period]
        of = "" if all(periods) else f" of {', '.join(held)}"
        message = (
            f"{name} ({recording.mapping.get(name, name)}){of} changes only every {1e3 * period_s:.3g} ms (held values "
            f"of a slower topic), {500 * period_s:.3g} ms late on average; it is interpolated between its updates"
        )
        findings.append(Finding("held_values", message, amount=period_s))
    if not found:
        return recording
    if recording.blocks is not None:
        raise WholeLogError
    return recording.mended(partial(_interpolated, periods=found)).with_findings(*findings)


def _period(values: Float, moving: Bool) -> float:
    """Return for how many rows the values of a joint are held while it moves, 0 where they are not."""
    steps = np.diff(values, axis=1)
    stretch, update = np.nonzero(steps)
    own = moving[stretch, update]
    own = own[:-1] & own[1:] & (np.diff(stretch) == 0)
    jump = np.abs(steps[stretch, update])[1:][own]
    length = np.diff(update)[own][jump >= _STEPS * jump.min(initial=np.inf)]
    if len(length) < _FEWEST_UPDATES:
        return 0.0
    usual = float(np.median(length))
    return usual if usual >= _SHORTEST and np.mean(length < 0.5 * usual) < _IRREGULAR else 0.0


def _interpolated(blocks: Iterator[Block], periods: Mapping[str, list[float]]) -> Iterator[Block]:
    for t, channels in blocks:
        for name, column, period in ((name, j, p) for name, own in periods.items() for j, p in enumerate(own) if p):
            values = channels[name][:, column]
            fresh = np.append(True, np.diff(values) != 0.0)
            # Where an update was missed, or at rest, a value holds until a usual run before the next one.
            rows = np.flatnonzero(fresh)
            fresh[rows[1:][np.diff(rows) > _LATE * period] - round(period)] = True
            fresh[-1] = True
            values[:] = np.interp(t, t[fresh], values[fresh])
        yield t, channels


def noisy_velocity(recording: Recording, near: Stretches) -> Recording:
    """Notice a velocity whose noise counts in its mean square in motion, as that of a difference of neighbours does."""
    if recording.mapping.get("dq") == DERIVATIVE:
        return recording
    dq = near.of("dq")
    findings = []
    for joint in range(dq.shape[2]):
        column = dq[..., joint]
        moving = np.abs(column) > MOVING_RAD_S
        rough = np.diff(column, n=3)[moving[:, 3:]]
        if len(rough) < _FEWEST_UPDATES or np.ptp(near.of("q")[..., joint]) < _TRAVELLED_RAD:
            continue
        share = float(np.mean(rough**2)) / 20.0 / float(np.mean(column[moving] ** 2))  # 1 + 9 + 9 + 1 of white noise
        if share > _NOISY:
            message = (
                f"{recording.name_of('dq', joint)}: {share:.0%} of its mean square is noise (a difference of "
                "neighbouring positions?): viscous friction is too small by about as much; use --map dq=derivative"
            )
            findings.append(Finding("velocity_noisy", message, joint + 1, share))
    return recording.with_findings(*findings)
