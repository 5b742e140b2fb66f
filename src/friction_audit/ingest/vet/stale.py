"""Stale samples: rows that repeat the state before them while the arm moves."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import take_rows, with_findings
from friction_audit.ingest.vet.sampling import GAP_S
from friction_audit.joint_log import TORQUE_CHANNELS, Finding

MOVING_RAD_S = 0.02
HELD_SHARE = 0.5
"""Share of stale rows, of those in motion, from which on the state itself is slow, and the logger did not stall."""
HELD_PERIODS = 3.5
"""A state that is held for more of its own periods did stall."""


def drop_stale_samples(recording: Recording) -> Recording:
    """Drop rows equal to the row before in q, dq and torque while some joint moves.

    A logger that polls faster than the state changes repeats it. At standstill equal rows are left alone: an ideal
    simulation at rest repeats itself rightly.
    """
    stale = find_stale(recording)
    if len(stale) == 0:
        return recording
    fresh = np.ones(len(recording.t), dtype=np.bool_)
    fresh[stale] = False
    recording = _keep_slow_state(recording, fresh)
    stale = np.flatnonzero(~fresh)
    if len(stale) == 0:
        return recording
    share = len(stale) / len(fresh)
    message = (
        f"{len(stale)} of {len(fresh)} rows ({share:.1%}) repeat q, dq and torque of the row before while the arm "
        "moves (the logger was faster than the state); they are left out"
    )
    return with_findings(
        take_rows(recording, fresh), Finding(code="stale_samples", message=message, amount=float(len(stale)))
    )


def find_stale(recording: Recording) -> NDArray[np.intp]:
    """Return the rows that repeat the row before them while some joint moves."""
    arrays = [recording.channels[c] for c in ("dq", "q", *TORQUE_CHANNELS) if c in recording.channels]
    columns = [column for array in arrays for column in array.T]
    first = columns[0]
    rows = np.flatnonzero(first[1:] == first[:-1]) + 1
    for column in columns[1:]:
        if len(rows) == 0:
            return rows
        rows = rows[column[rows] == column[rows - 1]]
    return rows[_moving(recording, rows)]


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
    if HELD_PERIODS * period <= GAP_S or repeats.sum() < HELD_SHARE * moving:
        return recording
    held = (repeats > 0) & (steps <= HELD_PERIODS * period)
    for row in np.flatnonzero(held):
        fresh[rows[row] : rows[row + 1]] = True
    message = (
        f"q, dq and torque are new only every {period:.3g} s while the arm moves (a bus that asks one motor after the "
        f"other?); {repeats[held].sum()} rows that repeat them are kept"
    )
    return with_findings(recording, Finding(code="slow_state", message=message, amount=period))
