"""Samples that repeat the one before, and torques that stand still."""

from collections.abc import Mapping

import numpy as np

from friction_audit.io.checks.clock import GAP_S
from friction_audit.io.checks.columns import Column, Thinned
from friction_audit.io.recording import Marks, Recording, WholeLogError
from friction_audit.joint_log import DERIVATIVE, TORQUE_CHANNELS, Finding, Float
from friction_audit.parallel import per_joint

MOVING_RAD_S = 0.02
# Share of stale rows, of those in motion, from which on the state itself is slow, and the logger did not stall.
_HELD_SHARE = 0.5
_HELD_PERIODS = 3.5  # a state that is held for more of its own periods did stall


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
        recording, marks = _keep_slow_state(recording, stale, period)
    if not marks.count:
        return recording
    message = (
        f"{marks.count} of {stale.rows} rows ({marks.count / stale.rows:.1%}) are duplicate samples (logged faster "
        "than the robot updates); they are removed"
    )
    return recording.without(marks).with_findings(Finding("stale_samples", message, amount=float(marks.count)))


def _keep_slow_state(recording: Recording, stale: Stale, period: float) -> tuple[Recording, Marks]:
    """Unmark the rows of a state that is new less often than a hole is long: its steps would pass for holes."""
    lost = stale.marks.of(0, stale.rows)
    rows = np.flatnonzero(~lost)
    steps, repeats = np.diff(recording.t[rows]), np.diff(rows) - 1
    held = (repeats > 0) & (steps <= _HELD_PERIODS * period)
    for row in np.flatnonzero(held):
        lost[rows[row] : rows[row + 1]] = False
    message = (
        f"q, dq and torque are updated only every {period:.3g} s (a bus that polls the motors in turn?); "
        f"{repeats[held].sum()} repeated rows are kept"
    )
    marks = Marks(stale.rows)
    marks.add(0, lost)
    return recording.with_findings(Finding("slow_state", message, amount=period)), marks


# What a joint of an arm for tens of kilograms never holds, and what is left of it without gravity. [N m]
_LARGEST_NM = {"tau_J": 1000.0, "tau_interaction": 300.0, "tau_ext_hat_filtered": 300.0}
_SHARE = 0.95  # of the samples that may be below what is tested: a few wild ones prove nothing
_FEWEST_MOVING = 20  # samples in either direction that show what reverses with the motion
_FEW_STEPS = 5.0
_LEAST_NM = 0.01  # no joint of an arm turns with less: a channel of a few steps below it carries no torque [N m]
# Steps of more than what reverses make the estimate depend on their rounding. Panda sensors have half of that.
_COARSE = 1.0
_MOST_VALUES = 64
_UNEVEN = 0.01


def check_torque(recording: Recording, columns: Mapping[str, Column]) -> Recording:
    """Notice torques that are dead, coarse or may be in mN m; nothing is changed."""
    findings = []
    for name in (name for name in _LARGEST_NM if name in columns):
        usual = np.quantile(np.abs(columns[name].sample), _SHARE, axis=0)
        joint = int(np.argmax(usual))
        if usual[joint] > _LARGEST_NM[name]:
            text = (
                f"{name} exceeds {usual[joint]:.4g} in 5 % of the samples: a very large arm, or mN m; read as N m; if "
                "it is mN m, divide the column by 1000"
            )
            findings.append(Finding("torque_unit_suspected", text, joint + 1, float(usual[joint])))
    used = next(name for name in TORQUE_CHANNELS if name in columns)
    poor = per_joint(lambda joint: _poor(recording, columns, used, joint), len(recording.joint_names))
    return recording.with_findings(*findings, *poor)


def _poor(recording: Recording, columns: Mapping[str, Column], channel: str, joint: int) -> Finding | None:
    """Say of a moving joint that its torque is constant, or a few steps of a sensor, or rounded to coarse steps."""
    torque, dq = columns[channel].sample[:, joint], columns["dq"].sample[:, joint]
    forwards, backwards = torque[dq > MOVING_RAD_S], torque[dq < -MOVING_RAD_S]
    if len(forwards) + len(backwards) < _FEWEST_MOVING:
        return None
    name, step, rms = f"{channel} ({recording.mapping.get(channel, channel)})", _step(torque), float(np.std(torque))
    dead = ""
    if columns[channel].highest[joint] == columns[channel].lowest[joint]:
        dead = f"constant: {name} is {torque[0] + 0.0:g} in all rows while the joint moves"
    elif 0.0 < rms < min(_FEW_STEPS * step, _LEAST_NM):
        dead = f"dead: {name} varies by {rms:.2g} rms, a few steps of {step:.2g}"
    if dead:
        advice = "no friction is estimated from it; check the sensor, or exclude the joint with --joints"
        return Finding("torque_dead", f"torque channel is {dead}; {advice}", joint + 1)
    if min(len(forwards), len(backwards)) < _FEWEST_MOVING:
        return None
    reverses = 0.5 * abs(float(np.mean(forwards) - np.mean(backwards)))
    if step <= _COARSE * reverses:
        return None
    message = (
        f"{name} is quantised to {step:.3g}, the part that reverses with the motion is {reverses:.2g}: quantisation "
        "limits the estimate; log the torque with more digits"
    )
    return Finding("torque_coarse", message, joint + 1, step)


def _step(torque: Float) -> float:
    """Return the step to which a torque is rounded, 0 if it takes too many values or is no multiple of any."""
    values = np.unique(torque)
    steps = np.diff(values)
    steps = steps[steps > 1e-6 * (values[-1] - values[0])]
    if not 0 < len(steps) <= _MOST_VALUES:
        return 0.0
    step = float(steps.min())  # Coulomb friction alone takes two values, no multiples of their distance
    return step if np.abs(values / step - np.round(values / step)).max() < _UNEVEN else 0.0
