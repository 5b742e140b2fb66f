"""The torque of the rigid-body model along a log: evaluated on a coarse grid of times, read off at the samples.

Gravity needs only the position, which is smooth and nearly free of noise: it is read off the log at the grid's times
and nothing is filtered. Inertial and Coriolis torque need the acceleration, so the velocity is low-pass filtered
without a phase shift before it is differentiated. The measured torque is never filtered: the energy sums multiply it
with the measured velocity.

How the corner was chosen, on a real arm moved by its own motors at up to 2 rad/s (a Panda, 21 s of excitation;
F_m regressed on sgn(dq), dq and an offset):

    corner [Hz]                           4      6      8      10     15     20     30
    rms of F_m, joint 2 [N m]             0.74   0.74   0.74   0.74   0.77   0.85   1.16
    Coulomb coefficient, joint 4 [N m]    0.461  0.456  0.456  0.456  0.454  0.452  0.450

The motion lies below 4 Hz. A vibration of the structure lies at 12 to 15 Hz, where M ddq of a rigid arm is wrong and
only adds noise. The coefficients hardly notice: from 6 to 30 Hz none moves by more than 0.015 N m, from energy cycles
none by more than 0.003 N m, and filtering the torque alike changes them as little. So the corner stands at 10 Hz,
above the motion and below the vibration.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float, JointLog

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

CUTOFF_HZ = 10.0
FILTER_ORDER = 4

LARGEST_CUTOFF = 0.4
"""Of the grid's rate: below the Nyquist frequency, where a slow log leaves no room for the corner above."""

HOLE_S = 0.5
HOLE_STEPS = 20
"""A hole in the log is a time step longer than both; nothing is filtered or interpolated across it."""

BLOCK = 1 << 16


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class GridMotion:
    """Motion on a uniform grid over one stretch of a log without a hole; k times, j joints.

    Attributes:
        t: Time, shape (k,). [s]
        q: Position, shape (k, j). [rad]
        dq: Low-pass filtered velocity, shape (k, j). [rad/s]
        ddq: Its derivative, shape (k, j). [rad/s^2]
    """

    t: Float
    q: Float
    dq: Float
    ddq: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class GridTorque:
    """A torque known on the grid, as one cubic spline per stretch."""

    starts: Float
    pieces: tuple["CubicSpline[np.float64]", ...]

    def at(self, t: Float) -> Float:
        """Return the torque at times of the log, shape (len(t), j). [N m]"""
        if len(self.pieces) == 1:
            return np.asarray(self.pieces[0](t))
        stretch = np.searchsorted(self.starts, t, side="right") - 1
        return np.concatenate([np.asarray(self.pieces[number](t[stretch == number])) for number in np.unique(stretch)])

    def subtract_from(self, torque: Float, t: Float, columns: list[int]) -> None:
        """Subtract the torque of some joints from an array in place, block by block.

        Args:
            torque: Shape (n, len(columns)), changed. [N m]
            t: Times of its rows, shape (n,). [s]
            columns: Joints (0-based) of its columns.
        """
        for first in range(0, len(t), BLOCK):
            rows = slice(first, first + BLOCK)
            torque[rows] -= self.at(t[rows])[:, columns]


def motion_on_grid(log: JointLog, rate_hz: float) -> tuple[GridMotion, ...]:
    """Return the motion of all joints on a grid of this rate (of the log's own rate, if that is lower).

    Args:
        log: The log.
        rate_hz: Rate of the grid. [Hz]
    """
    rate_hz = min(rate_hz, log.rate_hz)
    return tuple(_stretch_motion(log, rows, rate_hz) for rows in _stretches(log.t))


def torque_on_grid(motions: tuple[GridMotion, ...], torque: Callable[[GridMotion], Float]) -> GridTorque:
    """Evaluate a torque of the motion on the grid.

    Args:
        motions: The stretches of the log.
        torque: The torque of a stretch, shape (k, j). [N m]
    """
    from scipy.interpolate import CubicSpline

    pieces = tuple(CubicSpline(motion.t, torque(motion)) for motion in motions)
    return GridTorque(starts=np.array([motion.t[0] for motion in motions]), pieces=pieces)


def _stretches(t: Float) -> Iterator[slice]:
    step = np.diff(t)
    ends = np.flatnonzero(step > max(HOLE_S, HOLE_STEPS * float(np.median(step)))) + 1
    borders = [0, *ends.tolist(), len(t)]
    for first, last in pairwise(borders):
        yield slice(first, last)


def _stretch_motion(log: JointLog, rows: slice, rate_hz: float) -> GridMotion:
    from scipy.interpolate import CubicSpline

    t = log.t[rows]
    stop = max(float(t[-1]), float(t[0]) + 1 / rate_hz)
    grid = np.linspace(t[0], stop, int(np.ceil((stop - t[0]) * rate_hz)) + 1)
    joints = range(log.q.shape[1])
    q = np.column_stack([np.interp(grid, t, log.q[rows, joint]) for joint in joints])
    mean = np.column_stack([_cell_mean(grid, t, log.dq[rows, joint]) for joint in joints])
    dq = _low_pass(mean, rate_hz)
    return GridMotion(t=grid, q=q, dq=dq, ddq=np.asarray(CubicSpline(grid, dq)(grid, 1)))


def _cell_mean(grid: Float, t: Float, signal: Float) -> Float:
    """Return the mean of a signal over the cell of each grid time: keeps its integral, and is the anti-alias filter."""
    if len(t) < 2 * len(grid):
        return np.interp(grid, t, signal)
    integral = np.zeros(len(t))
    np.cumsum((signal[1:] + signal[:-1]) * np.diff(t) / 2, out=integral[1:])
    edges = np.concatenate([grid[:1], (grid[1:] + grid[:-1]) / 2, grid[-1:]])
    mean: Float = np.diff(np.interp(edges, t, integral)) / np.diff(edges)
    return mean


def _low_pass(signal: Float, rate_hz: float) -> Float:
    """Filter columns forwards and backwards: no phase shift, so no friction made out of a delay."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, min(CUTOFF_HZ, LARGEST_CUTOFF * rate_hz), fs=rate_hz, output="sos")
    padding = min(int(rate_hz), len(signal) - 1)
    return np.asarray(sosfiltfilt(sections, signal, axis=0, padlen=padding))
