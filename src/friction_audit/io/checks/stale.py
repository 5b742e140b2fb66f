"""Stale samples: rows that a logger repeats because it polls faster than the state changes."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.io.checks.sampling import GAP_S
from friction_audit.io.recording import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding

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
