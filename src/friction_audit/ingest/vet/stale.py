"""Stale samples: rows that repeat the state before them while the arm moves."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import take_rows, with_findings
from friction_audit.joint_log import TORQUE_CHANNELS, Finding

MOVING_RAD_S = 0.02


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
    moving = np.zeros(len(rows), dtype=np.bool_)
    for column in recording.channels["dq"].T:
        moving |= np.abs(column[rows]) > MOVING_RAD_S
    return rows[moving]
