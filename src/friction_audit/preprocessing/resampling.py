"""The torque of the rigid-body model along a log: evaluated on a coarse grid of times, read off at the samples.

Gravity needs only the position, which is smooth and nearly free of noise: it is read off the log at the grid's times
and nothing is filtered. Inertial and Coriolis torque need the acceleration, so the velocity is low-pass filtered
without a phase shift before it is differentiated. The measured torque is never filtered: the energy sums multiply it
with the measured velocity.

How the corner was chosen, on a real arm moved by its own motors at up to 2 rad/s (a Panda, 21 s of excitation;
F_m regressed on sgn(dq), dq and an offset):

    corner [Hz]                           4      6      8      10     15     20     30
    rms of F_m, joint 2 [N m]             0.75   0.74   0.74   0.75   0.78   0.86   1.09
    Coulomb coefficient, joint 4 [N m]    0.461  0.459  0.460  0.460  0.459  0.456  0.453

The motion lies below 4 Hz. The structure shakes at 26 to 28 Hz, where M ddq of a rigid arm is wrong and only adds
noise. The coefficients hardly notice: from 4 to 30 Hz none moves by more than 0.01 N m, here or from energy
cycles, and filtering the torque alike changes the energy sums as little. So the corner stands at 10 Hz, above the
motion and below the vibration.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float, JointLog

CUTOFF_HZ = 10.0
FILTER_ORDER = 4

LARGEST_CUTOFF = 0.4
"""Of the grid's rate: below the Nyquist frequency, where a slow log leaves no room for the corner above."""

HOLE_S = 0.5
HOLE_STEPS = 20
"""A hole in the log is a time step longer than both; nothing is filtered or interpolated across it."""

BLOCK = 1 << 16
"""Samples interpolated at a time."""

SPLINE_REACH = 20
"""Knots beyond a block that its spline takes along: a knot's influence falls by 3.7 per step, to 1e-11 here."""


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
        borders = [0, *np.searchsorted(t, [grid.t[0] for grid in self.grids[1:]]).tolist(), len(t)]
        for grid, values, (start, stop) in zip(self.grids, self.values, pairwise(borders), strict=True):
            for first in range(start, stop, BLOCK):
                rows = slice(first, min(first + BLOCK, stop))
                torque[rows] -= _interpolated(grid.t, values, t[rows], columns)


def grids_of(log: JointLog, rate_hz: float) -> tuple[Grid, ...]:
    """Return grids of this rate (of the log's own, if that is lower), one for each stretch of a log without a hole."""
    own_rate_hz = log.rate_hz
    return tuple(_grid(log.t, rows, min(rate_hz, own_rate_hz)) for rows in _stretches(log.t, 1 / own_rate_hz))


def torque_on_grids(grids: tuple[Grid, ...], torque: Callable[[Grid], Float]) -> GridTorque:
    """Evaluate a torque, given as a function of a grid, shape (k, j), on all grids."""
    return GridTorque(grids=grids, values=tuple(torque(grid) for grid in grids))


def position_on(grid: Grid, log: JointLog) -> Float:
    """Return the joints' positions on a grid, shape (k, j). [rad]"""
    reading = _Reading.at(grid.t, log.t[grid.rows])
    return np.column_stack([reading.of(log.q[grid.rows, joint]) for joint in range(log.q.shape[1])])


def velocity_on(grid: Grid, log: JointLog) -> tuple[Float, Float]:
    """Return the joints' low-pass filtered velocity [rad/s] and acceleration [rad/s^2] on a grid, each (k, j)."""
    mean = _cell_means(grid.t, log.t[grid.rows], log.dq[grid.rows])
    velocity = np.column_stack([_low_pass(mean[:, joint], grid.rate_hz) for joint in range(mean.shape[1])])
    return velocity, _derivative(velocity, float(grid.t[1] - grid.t[0]))


@dataclass(frozen=True, eq=False, slots=True)
class _Reading:
    """Where times lie between samples: found once, used for every joint."""

    lower: NDArray[np.int64]
    upper: NDArray[np.int64]
    share: Float

    @staticmethod
    def at(times: Float, t: Float) -> "_Reading":
        lower = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 1)
        upper = np.minimum(lower + 1, len(t) - 1)
        step = np.maximum(t[upper] - t[lower], np.finfo(float).tiny)
        return _Reading(lower, upper, np.clip((times - t[lower]) / step, 0, 1))

    def of(self, signal: Float) -> Float:
        """Interpolate a signal linearly."""
        below = signal[self.lower]
        read: Float = below + self.share * (signal[self.upper] - below)
        return read


def _stretches(t: Float, usual_step: float) -> Iterator[slice]:
    ends = np.flatnonzero(np.diff(t) > max(HOLE_S, HOLE_STEPS * usual_step)) + 1
    for first, last in pairwise([0, *ends.tolist(), len(t)]):
        yield slice(first, last)


def _grid(t: Float, rows: slice, rate_hz: float) -> Grid:
    start = float(t[rows.start])
    # A stretch of one sample has a grid of two times all the same, so that nothing else needs to know.
    stop = float(t[rows.stop - 1]) if rows.stop - rows.start > 1 else start + 1 / rate_hz
    intervals = int(np.ceil((stop - start) * rate_hz))
    return Grid(rows=rows, t=np.linspace(start, stop, intervals + 1), rate_hz=rate_hz)


def _interpolated(knots: Float, values: Float, t: Float, columns: list[int]) -> Float:
    from scipy.interpolate import CubicSpline

    first = max(int(np.searchsorted(knots, t[0])) - SPLINE_REACH, 0)
    last = int(np.searchsorted(knots, t[-1])) + SPLINE_REACH
    return np.asarray(CubicSpline(knots[first:last], values[first:last, columns])(t))


def _cell_means(grid: Float, t: Float, signals: Float) -> Float:
    """Return means over the cell of each grid time: they keep the integral, and are the anti-alias filter."""
    joints = range(signals.shape[1])
    if len(t) < 2 * len(grid):
        reading = _Reading.at(grid, t)
        return np.column_stack([reading.of(signals[:, joint]) for joint in joints])
    edges = np.concatenate([grid[:1], (grid[1:] + grid[:-1]) / 2, grid[-1:]])
    reading, half_step, width = _Reading.at(edges, t), np.diff(t) / 2, np.diff(edges)
    means = np.empty((len(grid), len(joints)))
    integral = np.zeros(len(t))
    for joint in joints:
        trapezoids = (signals[1:, joint] + signals[:-1, joint]) * half_step
        np.cumsum(trapezoids, out=integral[1:])
        means[:, joint] = np.diff(reading.of(integral)) / width
    return means


def _derivative(signals: Float, step: float) -> Float:
    """Differentiate columns by central differences of fourth order, of second order at the ends."""
    slope: Float = np.gradient(signals, step, axis=0)
    slope[2:-2] = (8 * (signals[3:-1] - signals[1:-3]) - (signals[4:] - signals[:-4])) / (12 * step)
    return slope


def _low_pass(signal: Float, rate_hz: float) -> Float:
    """Filter forwards and backwards: no phase shift, so no friction made out of a delay."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, min(CUTOFF_HZ, LARGEST_CUTOFF * rate_hz), fs=rate_hz, output="sos")
    return np.asarray(sosfiltfilt(sections, signal, padlen=min(int(rate_hz), len(signal) - 1)))
