"""The torque of the rigid-body model along a log: evaluated on a coarse grid of times, interpolated at the samples.

Gravity needs only the position, which is smooth and nearly free of noise: it is read at the grid's times without a
filter. Inertial and Coriolis torque need the acceleration, so the velocity is low-pass filtered without a phase shift
before it is differentiated. The measured torque is never filtered: the energy sums multiply it with the measured
velocity.

Choice of the corner, on a real Panda moved by its own motors at up to 2 rad/s (21 s of excitation; F_m regressed on
sgn(dq), dq and an offset):

    corner [Hz]                           4      6      8      10     15     20     30
    rms of F_m, joint 2 [N m]             0.75   0.74   0.74   0.75   0.78   0.86   1.09
    Coulomb coefficient, joint 4 [N m]    0.461  0.459  0.460  0.460  0.459  0.456  0.453

The motion lies below 4 Hz; the structure shakes at 26 to 28 Hz, where M ddq of a rigid arm is wrong and adds noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from friction_audit.joint_log import Float, JointLog

CUTOFF_HZ = 10.0
FILTER_ORDER = 4
LARGEST_CUTOFF = 0.4  # of the grid's rate: below the Nyquist frequency, where a slow log leaves no room for the corner
# A hole in the log is a time step longer than both; nothing is filtered or interpolated across it.
HOLE_S = 0.5
HOLE_STEPS = 20
BLOCK = 1 << 16  # samples interpolated at a time
SPLINE_REACH = 20  # knots beyond a block that its spline takes along: their influence falls by 3.7 per step, to 1e-11


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Grid:
    """A uniform grid of times over one stretch of a log without a hole.

    Attributes:
        rows: The stretch's samples in the log.
        t: Times, from the first sample of the stretch to its last, shape (k,). [s]
        rate_hz: Rate asked for; the spacing is a little less than its inverse. [Hz]
    """

    rows: slice
    t: Float
    rate_hz: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class GridTorque:
    """A torque of all joints known on the grids of a log, one array of shape (k, j) per grid. [N m]"""

    grids: tuple[Grid, ...]
    values: tuple[Float, ...]

    def subtract_from(self, torque: Float, t: Float, columns: list[int]) -> None:
        """Subtract the torque of some joints from an array in place, block by block.

        Args:
            torque: Shape (m, len(columns)), changed. [N m]
            t: Times of its rows, increasing, shape (m,). [s]
            columns: Joints (0-based) of its columns.
        """
        from scipy.interpolate import CubicSpline

        borders = [0, *np.searchsorted(t, [grid.t[0] for grid in self.grids[1:]]).tolist(), len(t)]
        for grid, values, (start, stop) in zip(self.grids, self.values, pairwise(borders), strict=True):
            for first in range(start, stop, BLOCK):
                rows = slice(first, min(first + BLOCK, stop))
                low, high = np.searchsorted(grid.t, t[rows][[0, -1]])
                knots = slice(max(int(low) - SPLINE_REACH, 0), int(high) + SPLINE_REACH)
                torque[rows] -= CubicSpline(grid.t[knots], values[knots, columns])(t[rows])


def grids_of(log: JointLog, rate_hz: float) -> tuple[Grid, ...]:
    """Return grids of this rate (of the log's own, if that is lower), one for each stretch of a log without a hole."""
    rate_hz = min(rate_hz, log.rate_hz)
    ends = np.flatnonzero(np.diff(log.t) > max(HOLE_S, HOLE_STEPS / log.rate_hz)) + 1
    return tuple(_grid(log.t, slice(*rows), rate_hz) for rows in pairwise([0, *ends.tolist(), len(log.t)]))


def _grid(t: Float, rows: slice, rate_hz: float) -> Grid:
    start, stop = float(t[rows.start]), float(t[rows.stop - 1])
    # A stretch of one sample has a grid of two times all the same, so that nothing else needs to know.
    stop = stop if rows.stop - rows.start > 1 else start + 1 / rate_hz
    return Grid(rows=rows, t=np.linspace(start, stop, int(np.ceil((stop - start) * rate_hz)) + 1), rate_hz=rate_hz)


def position_on(grid: Grid, log: JointLog) -> Float:
    """Return the joints' positions on a grid, shape (k, j). [rad]"""
    return _columns(np.interp(grid.t, log.t[grid.rows], q) for q in _signals(grid, log.q))


def velocity_on(grid: Grid, log: JointLog) -> tuple[Float, Float]:
    """Return the joints' low-pass filtered velocity [rad/s] and acceleration [rad/s^2] on a grid, each (k, j)."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, min(CUTOFF_HZ, LARGEST_CUTOFF * grid.rate_hz), fs=grid.rate_hz, output="sos")
    padding = min(int(grid.rate_hz), len(grid.t) - 1)
    mean = _cell_means(grid.t, log.t[grid.rows], _signals(grid, log.dq))
    velocity = _columns(sosfiltfilt(sections, dq, padlen=padding) for dq in mean.T)
    # Central differences of fourth order, of second order at the ends.
    step = float(grid.t[1] - grid.t[0])
    slope: Float = np.gradient(velocity, step, axis=0)
    slope[2:-2] = (8 * (velocity[3:-1] - velocity[1:-3]) - (velocity[4:] - velocity[:-4])) / (12 * step)
    return velocity, slope


def _signals(grid: Grid, channel: Float) -> Iterator[Float]:
    return (channel[grid.rows, joint] for joint in range(channel.shape[1]))


def _cell_means(grid: Float, t: Float, signals: Iterator[Float]) -> Float:
    """Return means over the cell of each grid time: they keep the integral, and are the anti-alias filter."""
    if len(t) < 2 * len(grid):
        return _columns(np.interp(grid, t, signal) for signal in signals)
    edges = np.concatenate([grid[:1], (grid[1:] + grid[:-1]) / 2, grid[-1:]])
    half_step, integral, means = np.diff(t) / 2, np.zeros(len(t)), []
    for signal in signals:
        np.cumsum((signal[1:] + signal[:-1]) * half_step, out=integral[1:])
        means.append(np.diff(np.interp(edges, t, integral)) / np.diff(edges))
    return np.column_stack(means)


def _columns(signals: Iterator[Float]) -> Float:
    return np.column_stack(list(signals))
