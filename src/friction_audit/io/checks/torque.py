"""Samples that repeat the one before, and torques that stand still."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.checks.clock import GAP_S
from friction_audit.io.recording import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float

MOVING_RAD_S = 0.02
# Share of stale rows, of those in motion, from which on the state itself is slow, and the logger did not stall.
_HELD_SHARE = 0.5
_HELD_PERIODS = 3.5  # a state that is held for more of its own periods did stall


def drop_stale_samples(recording: Recording) -> Recording:
    """Drop rows equal to the row before in q, dq and torque while some joint moves.

    At standstill equal rows are left alone: an ideal simulation at rest repeats itself rightly.
    """
    fresh = np.ones(len(recording.t), dtype=np.bool_)
    fresh[_find_stale(recording)] = False
    if fresh.all():
        return recording
    recording = _keep_slow_state(recording, fresh)
    stale = int(np.count_nonzero(~fresh))
    if stale == 0:
        return recording
    message = (
        f"{stale} of {len(fresh)} rows ({stale / len(fresh):.1%}) are duplicate samples (logged faster than the robot "
        "updates); they are removed"
    )
    finding = Finding(code="stale_samples", message=message, amount=float(stale))
    return recording.take_rows(fresh).with_findings(finding)


def _find_stale(recording: Recording) -> NDArray[np.intp]:
    arrays = [recording.channels[c] for c in ("dq", "q", *TORQUE_CHANNELS) if c in recording.channels]
    first, *others = [column for array in arrays for column in array.T]
    rows = np.flatnonzero(first[1:] == first[:-1]) + 1
    for column in others:
        rows = rows[column[rows] == column[rows - 1]]
    return rows[_moving(recording, rows)] if len(rows) else rows


def _moving(recording: Recording, rows: NDArray[np.intp] | slice) -> NDArray[np.bool_]:
    moving = np.zeros(len(recording.t[rows]), dtype=np.bool_)
    for column in recording.channels["dq"].T:
        moving |= np.abs(column[rows]) > MOVING_RAD_S
    return moving


def _keep_slow_state(recording: Recording, fresh: NDArray[np.bool_]) -> Recording:
    """Mark stale rows as fresh where the state is new less often than a hole is long, as on a bus of many motors.

    Without them, each of its steps would pass for a hole in the log.
    """
    rows = np.flatnonzero(fresh)
    steps, repeats = np.diff(recording.t[rows]), np.diff(rows) - 1
    period = float(np.median(steps[repeats > 0])) if repeats.any() else 0.0
    moving = np.count_nonzero(_moving(recording, slice(None)))
    if _HELD_PERIODS * period <= GAP_S or repeats.sum() < _HELD_SHARE * moving:
        return recording
    held = (repeats > 0) & (steps <= _HELD_PERIODS * period)
    for row in np.flatnonzero(held):
        fresh[rows[row] : rows[row + 1]] = True
    message = (
        f"q, dq and torque are updated only every {period:.3g} s (a bus that polls the motors in turn?); "
        f"{repeats[held].sum()} repeated rows are kept"
    )
    return recording.with_findings(Finding(code="slow_state", message=message, amount=period))


# What a joint of an arm for tens of kilograms never holds, and what is left of it without gravity. [N m]
_LARGEST_NM = {"tau_J": 1000.0, "tau_interaction": 300.0, "tau_ext_hat_filtered": 300.0}
_SHARE = 0.95  # of the samples that may be below what is tested: a few wild ones prove nothing
_MOST_SAMPLES = 1 << 16
_FEWEST_MOVING = 20  # samples in either direction that show what reverses with the motion
_FEW_STEPS = 5.0
_LEAST_NM = 0.01  # no joint of an arm turns with less: a channel of a few steps below it carries no torque [N m]
# Steps of more than what reverses make the estimate depend on their rounding. Panda sensors have half of that.
_COARSE = 1.0
_MOST_VALUES = 64
_UNEVEN = 0.01


def check_torque(recording: Recording) -> Recording:
    """Notice torques that are dead, coarse or may be in mN m; nothing is changed."""
    every = max(1, len(recording.t) // _MOST_SAMPLES)
    findings = []
    for name in (name for name in _LARGEST_NM if name in recording.channels):
        usual = np.quantile(np.abs(recording.channels[name][::every]), _SHARE, axis=0)
        joint = int(np.argmax(usual))
        if usual[joint] > _LARGEST_NM[name]:
            text = (
                f"{name} exceeds {usual[joint]:.4g} in 5 % of the samples: a very large arm, or mN m; read as N m; if "
                "it is mN m, divide the column by 1000"
            )
            amount = float(usual[joint])
            findings.append(Finding(code="torque_unit_suspected", message=text, joint=joint + 1, amount=amount))
    used = next(name for name in TORQUE_CHANNELS if name in recording.channels)
    return recording.with_findings(*findings, *(_poor(recording, used, j) for j in range(len(recording.joint_names))))


def _poor(recording: Recording, channel: str, joint: int) -> Finding | None:
    """Say of a moving joint that its torque is constant, or a few steps of a sensor, or rounded to coarse steps."""
    every = max(1, len(recording.t) // _MOST_SAMPLES)
    torque, dq = recording.channels[channel][::every, joint], recording.channels["dq"][::every, joint]
    forwards, backwards = torque[dq > MOVING_RAD_S], torque[dq < -MOVING_RAD_S]
    if len(forwards) + len(backwards) < _FEWEST_MOVING:
        return None
    name = recording.name_of(channel, joint)
    if np.ptp(recording.channels[channel][:, joint]) == 0.0:
        return _dead(f"torque channel is constant: {name} is {torque[0]:g} in all rows while the joint moves", joint)
    step, rms = _step(torque), float(np.std(torque))
    if 0.0 < rms < min(_FEW_STEPS * step, _LEAST_NM):
        return _dead(f"torque channel is dead: {name} varies by {rms:.2g} rms, a few steps of {step:.2g}", joint)
    if min(len(forwards), len(backwards)) < _FEWEST_MOVING:
        return None
    reverses = 0.5 * abs(float(np.mean(forwards) - np.mean(backwards)))
    if step <= _COARSE * reverses:
        return None
    message = (
        f"{name} is quantised to {step:.3g}, the part that reverses with the motion is {reverses:.2g}: quantisation "
        "limits the estimate; log the torque with more digits"
    )
    return Finding(code="torque_coarse", message=message, joint=joint + 1, amount=step)


def _dead(what: str, joint: int) -> Finding:
    message = f"{what}; no friction is estimated from it; check the sensor, or exclude the joint with --joints"
    return Finding(code="torque_dead", message=message, joint=joint + 1)


def _step(torque: Float) -> float:
    """Return the step to which a torque is rounded, 0 if it takes too many values or is no multiple of any.

    Coulomb friction alone, +-0.3 N m, takes two values, which are no multiples of their distance.
    """
    values = np.unique(torque)
    steps = np.diff(values)
    steps = steps[steps > 1e-6 * (values[-1] - values[0])]
    if not 0 < len(steps) <= _MOST_VALUES:
        return 0.0
    step = float(steps.min())
    return step if np.abs(values / step - np.round(values / step)).max() < _UNEVEN else 0.0
