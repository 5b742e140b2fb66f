"""Samples that repeat one that was lost: a tick older than their stamps say.

A recorder that comes by before there is a next state writes the last one once more, under a new stamp. Such a row is no
news beside the one that it repeats; where that one was lost, it equals none. So does the state that comes by when the
one before it was written twice. The joint then seems to stand for a tick and to leap in the next: one such row in a
thousand passes for a delay, a touch or a spring that rings.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float, median_step

LOST = 1.5
"""A step of so many usual ones has lost a sample."""
FARTHEST = 3
"""Rows before one that are looked at."""
LONGEST_RUN = 3
"""Rows in a row that are late: they hide each other from a look at single ones."""
PLAIN = 5.0
"""Standard deviations of its age from which on a row is late: by chance hardly one of a million is."""
NEARER = 0.5
"""Of a tick: what is older is nearer to a tick that was lost than to its own."""


def lone_repeats(t: Float, q: Float) -> NDArray[np.bool_]:
    """Tell the samples behind a hole that are where the joints were while it lasted, shape (n,).

    Args:
        t: Stamps, strictly increasing, shape (n,). [s]
        q: Positions, none of which repeats the one before while a joint moves, shape (n, j). [rad]
    """
    from scipy.ndimage import binary_opening

    kept = np.arange(len(t))
    # Those that were hidden by others may be plain without them.
    while np.any(late := _plain_ones(t[kept], q[kept])):
        kept = kept[~late]
    lone = np.ones(len(t), bool)
    lone[kept] = False
    # What makes row after row look late, without end, is the one before them all that is out of its time.
    return np.asarray(lone & ~binary_opening(lone, np.ones(LONGEST_RUN + 1, bool)), bool)


def _plain_ones(t: Float, q: Float) -> NDArray[np.bool_]:
    ticks = np.diff(t, prepend=t[0]) / median_step(t)
    late = np.zeros(len(t), bool)
    for run in range(1, LONGEST_RUN + 1):
        behind, ordinary = _inner(ticks > LOST, run), _inner(_whole(ticks), run)
        if len(behind) and len(ordinary):
            first = behind[_are_late(t, q, behind, ordinary, run) & ~late[behind]]
            late[first[:, None] + np.arange(run)] = True
    return late


def _inner(rows: NDArray[np.bool_], run: int) -> NDArray[np.int64]:
    """Numbers of the rows marked that have neighbours enough before them and behind the run that they begin."""
    inner = np.flatnonzero(rows)
    return inner[(inner >= FARTHEST) & (inner + run + 1 < len(rows))]


def _whole(ticks: Float) -> NDArray[np.bool_]:
    """Rows about which nothing is lost."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(ticks, 2 * FARTHEST + 1) <= LOST)


def _are_late(t: Float, q: Float, rows: NDArray[np.int64], ordinary: NDArray[np.int64], run: int) -> NDArray[np.bool_]:
    """Whether rows, each the first of a run, are plainly older than their stamps, by what was lost at the most."""
    late_s, weight = np.zeros(len(rows)), np.full(len(rows), np.finfo(np.float64).tiny)
    for position in q.T:
        # The ordinary ones without the one before, as behind a hole: what a cubic errs by grows with what it spans.
        noise = float(np.mean(_off(t, position, ordinary, (-3, -2, run, run + 1)) ** 2))
        if noise > 0.0:
            speed = (position[rows + run] - position[rows - 1]) / (t[rows + run] - t[rows - 1])
            late_s -= speed * _off(t, position, rows, (-2, -1, run, run + 1)) / noise
            weight += speed**2 / noise
    step_s, jitter_s = median_step(t), float(np.std(t[ordinary] - t[ordinary - 1]))
    age, error = late_s / weight, np.hypot(1.0 / np.sqrt(weight), jitter_s)
    longest = t[rows] - t[rows - 1] - NEARER * step_s
    return np.asarray((age > PLAIN * error) & (age > NEARER * step_s) & (age < longest))


def _off(t: Float, position: Float, rows: NDArray[np.int64], beside: tuple[int, ...]) -> Float:
    """How far positions are from the cubic through four neighbours, told by their distances in rows. [rad]"""
    away = t[rows[:, None] + np.array(beside)] - t[rows, None]
    expected = np.zeros(len(rows))
    for k, row in enumerate(beside):
        others = np.delete(away, k, axis=1)
        expected += position[rows + row] * np.prod(others / (others - away[:, [k]]), axis=1)
    return np.asarray(position[rows] - expected)
