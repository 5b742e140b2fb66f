"""Closed cycles: where gravity is in the torque, only paths that return to their start say anything about friction."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

LONGEST_RUN = 8
"""Strokes tried before a start is given up."""


def end_to_end(q: Float, start: NDArray[np.int64], stop: NDArray[np.int64]) -> Float:
    """Return how far the joint furthest from its start is at the stop, shape (m,). [rad]

    Gravity at a joint depends on all joints beyond it, so all of them must return.
    """
    return np.asarray(np.abs(q[stop] - q[start]).max(axis=1), np.float64)


def close_runs(q: Float, borders: NDArray[np.int64], closure_rad: float) -> NDArray[np.int64]:
    """Join neighbouring strokes into the shortest runs that end where they began.

    Args:
        q: Position of all joints, shape (n, j). [rad]
        borders: Border samples of the strokes, shape (m + 1,).
        closure_rad: Largest distance that still counts as closed. [rad]

    Returns:
        Border samples of the runs; a stroke that closes with none of its followers stays alone (and open).
    """
    kept, s = [0], 0
    while s < len(borders) - 1:
        ends = borders[s + 1 : s + 1 + LONGEST_RUN]
        closed = end_to_end(q, np.full(len(ends), borders[s]), ends) <= closure_rad
        s += int(np.argmax(closed)) + 1 if closed.any() else 1
        kept.append(s)
    return borders[kept]
