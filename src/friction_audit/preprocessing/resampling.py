"""Inertial and Coriolis torque of an arm along a log: evaluated on a coarse grid of times, interpolated at the samples.

They need the acceleration, so the velocity is low-pass filtered without a phase shift before it is differentiated. The
position is smooth and nearly free of noise: it is read at the grid's times without a filter. The measured torque is
never filtered: the energy sums multiply it with the measured velocity.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float, JointLog

# Of a real Panda at up to 2 rad/s, all corners from 4 to 10 Hz leave 0.75 N m rms of F_m of joint 2, 20 Hz 0.86, 30 Hz
# 1.09: the motion lies below 4 Hz, the structure shakes at 26 to 28 Hz, where M ddq of a rigid arm is wrong.
CUTOFF_HZ = 10.0
FILTER_ORDER = 4
LARGEST_CUTOFF = 0.4  # of the grid's rate: below the Nyquist frequency, where a slow log leaves no room for the corner
# A hole in the log is a time step longer than both; nothing is filtered or interpolated across it.
HOLE_S = 0.5
HOLE_STEPS = 20
BLOCK = 1 << 16  # samples interpolated at a time
SPLINE_REACH = 20  # knots beyond a block that its spline takes along: their influence falls by 3.7 per step, to 1e-11


class Grid(NamedTuple):
    """A uniform grid of times over one stretch of a log without a hole."""

    samples: int  # of the log in the stretch
    t: Float  # times, from the first sample of the stretch to its last, shape (k,) [s]
    rate_hz: float  # rate asked for; the spacing is a little less than its inverse [Hz]


class GridTorque(NamedTuple):
    """A torque of all joints known on the grids of a log, one array of shape (k, j) per grid. [N m]"""

    grids: tuple[Grid, ...]
    values: tuple[Float, ...]

    def subtract_from(self, torque: Float, t: Float, columns: list[int]) -> None:
        """Subtract the torque of some joints (0-based) from an array in place, whose rows are at increasing times."""
        from scipy.interpolate import CubicSpline

        borders = [0, *np.searchsorted(t, [grid.t[0] for grid in self.grids[1:]]).tolist(), len(t)]
        for grid, values, (start, stop) in zip(self.grids, self.values, pairwise(borders), strict=True):
            for first in range(start, stop, BLOCK):
                rows = slice(first, min(first + BLOCK, stop))
                low, high = np.searchsorted(grid.t, t[rows][[0, -1]])
                knots = slice(max(int(low) - SPLINE_REACH, 0), int(high) + SPLINE_REACH)
                near = np.clip(t[rows], grid.t[0], grid.t[-1])  # in a hole as at its begin, or it leaves all bounds
                torque[rows] -= CubicSpline(grid.t[knots], values[knots, columns])(near)


def grids_of(log: JointLog, rate_hz: float) -> tuple[Grid, ...]:
    """Return grids of this rate (of the log's own, if that is lower), one for each stretch of a log without a hole."""
    rate_hz = min(rate_hz, log.rate_hz)
    holes = log.gaps_longer_than(max(HOLE_S, HOLE_STEPS / log.rate_hz))
    firsts = [(0, 0.0), *((int(row) + 1, after) for row, _, after in holes.tolist())]
    lasts = [*((int(row) + 1, before) for row, before, _ in holes.tolist()), (log.samples, log.duration_s)]
    grids = []
    for (first, start), (end, stop) in zip(firsts, lasts, strict=True):
        # A stretch of one sample has a grid of two times all the same, so that nothing else needs to know.
        stop = stop if end - first > 1 else start + 1 / rate_hz  # noqa: PLW2901
        t = np.linspace(start, stop, int(np.ceil((stop - start) * rate_hz)) + 1)
        grids.append(Grid(samples=end - first, t=t, rate_hz=rate_hz))
    return tuple(grids)


def motion_on(grids: Sequence[Grid], log: JointLog) -> list[tuple[Float, Float, Float]]:
    """Return position [rad], low-pass filtered velocity [rad/s] and acceleration [rad/s^2] on each grid, (k, j)."""
    # Means over the cell of each grid time keep the integral, and are the anti-alias filter.
    own = [grid.t if grid.samples > 1 else np.full(len(grid.t), grid.t[0]) for grid in grids]
    fine = [grid.samples >= 2 * len(grid.t) for grid in grids]
    edges = (np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]]) for t in own)
    times = [edge if one else t for edge, one, t in zip(edges, fine, own, strict=True)]
    positions, found = _along(log, "q", own, [False] * len(own)), _along(log, "dq", times, fine)
    means = (
        np.diff(a, axis=0) / np.diff(t)[:, None] if one else a for a, t, one in zip(found, times, fine, strict=True)
    )
    return [(position, *_smooth(grid, mean)) for grid, position, mean in zip(grids, positions, means, strict=True)]


def _smooth(grid: Grid, mean: Float) -> tuple[Float, Float]:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, min(CUTOFF_HZ, LARGEST_CUTOFF * grid.rate_hz), fs=grid.rate_hz, output="sos")
    padding = min(int(grid.rate_hz), len(grid.t) - 1)
    velocity = np.column_stack([sosfiltfilt(sections, dq, padlen=padding) for dq in mean.T])
    # Central differences of fourth order, of second order at the ends.
    step = float(grid.t[1] - grid.t[0])
    slope: Float = np.gradient(velocity, step, axis=0)
    slope[2:-2] = (8 * (velocity[3:-1] - velocity[1:-3]) - (velocity[4:] - velocity[:-4])) / (12 * step)
    return velocity, slope


def _along(log: JointLog, channel: str, times: Sequence[Float], integrate: Sequence[bool]) -> list[Float]:
    """Interpolate a channel, or its integral from the beginning of the log, at times along each grid: (k, j) each."""
    found, gone = [np.empty((len(t), len(log.joint_names))) for t in times], np.zeros(len(log.joint_names))
    t, signal = np.empty(0), np.empty((0, len(gone)))
    for part in log.blocks((channel,)):
        # The last sample of the block before comes along, or there were no motion from it on.
        t, signal = np.append(t[-1:], part.t), np.concatenate([signal[-1:], getattr(part, channel)])
        ends = t[0], np.inf if part.first + len(part.t) == log.samples else t[-1]
        places = [slice(*np.searchsorted(wanted, ends).tolist()) for wanted in times]
        for joint, column in enumerate(signal.T):
            integral = column
            if any(integrate):
                area = (column[1:] + column[:-1]) * (np.diff(t) / 2)
                integral = np.cumsum(np.append(gone[joint], area))
                gone[joint] = integral[-1]
            for out, wanted, own, one in zip(found, times, places, integrate, strict=True):
                out[own, joint] = np.interp(wanted[own], t, integral if one else column)
    return found
