"""JointData -> Rows: what a regression sees, torque and columns low-passed alike and thinned out.

A column is built on the fine grid, where the sign of the velocity is sharp, and then goes through the very filter
that the torque goes through; what a reversal smears in one it smears in the other. The corner stands at 25 Hz, above
what arms are moved with (below 4 Hz) and just below where a Panda's structure shakes (26 to 28 Hz), or lower, where the
noise of the acceleration, times the inertia, would come near that of the torque: there, it would pass for a spring.

Where a joint leaves a standstill there is a row of another kind: torque and columns at the moment of break-away,
carried on from the standstill before it (``breakaway``). It is noisier than the others, and weighs as much less.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.effects.breakaway import Breakaways, find_breakaways, torque_known
from friction_audit.effects.joint_data import CORNER_HZ, JointData
from friction_audit.joint_log import Float

LOWEST_CORNER_HZ = 8.0
QUIET_SHARE = 0.5
"""Of the torque's noise: what a regressor's may be. With a third, a delay of 4 ms is lost; with all of it, half of the
clean logs have a spring that is significant, if too small for a name."""
ROW_HZ = 100.0
STOPBAND_DB = 60.0
AT_A_TIME = 16
"""Products that a loop of a sum takes at once."""
MOST_UNCERTAIN = 0.02
"""Share of a row's weight that may come from samples without a certain direction."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Rows:
    """The samples of one joint that a model is fitted to, m of them.

    Attributes:
        kernel: Weights of the filter, shape (k,).
        corner_hz: Frequency of which half the amplitude passes. [Hz]
        every: Samples of the fine grid per row.
        used: Rows, of all that the filter gives, that count, shape (r,).
        t: Times, shape (m,). [s]
        y: Torque. [N m]
        cycle: Number of the cycle of each row.
        breakaways: Moments at which the joint left a standstill, k of them.
        breakaway_row: Row, of all that the filter gives, of each of them, shape (k,).
        breakaway_weight: Torque and columns of these rows are multiplied by this, that they be as noisy as the others.
    """

    kernel: Float
    corner_hz: float
    every: int
    used: NDArray[np.bool_]
    t: Float
    y: Float
    cycle: NDArray[np.int64]
    breakaways: Breakaways
    breakaway_row: NDArray[np.int64]
    breakaway_weight: float

    @property
    def weight(self) -> Float:
        """What torque and columns of each row were multiplied by, shape (m,)."""
        weight = np.ones(len(self.used))
        weight[self.breakaway_row] = self.breakaway_weight
        return np.asarray(weight[self.used])

    @property
    def step_s(self) -> float:
        """Spacing of rows that follow each other. [s]"""
        return float(np.min(np.diff(self.t))) if len(self.t) > 1 else 0.0

    def keep(self, kept: NDArray[np.bool_]) -> "Rows":
        """Some of the rows, shape (m,)."""
        used = self.used.copy()
        used[used] = kept
        return replace(self, used=used, t=self.t[kept], y=self.y[kept], cycle=self.cycle[kept])

    def of(self, columns: Float, out: Float | None = None) -> Float:
        """Filter and thin out columns of the fine grid, shape (n,) or (n, p), to shape (m,) or (m, p).

        Into ``out``, shape (p, m), where it is given: of it the outcome is a view then.
        """
        wanted = np.flatnonzero(self.used)
        filtered = filter_rows(columns, self.kernel, self.every, wanted, out)
        if len(self.breakaway_row):
            there = self.used[self.breakaway_row]
            place = np.searchsorted(wanted, self.breakaway_row[there])
            filtered[place] = self.breakaway_weight * self.breakaways.of(columns)[there]
        return filtered


def make_rows(data: JointData, corner_hz: float = CORNER_HZ) -> Rows:
    """Take the rows in which the direction of motion is certain, and those at which the joint breaks away.

    Args:
        data: The joint.
        corner_hz: Half of the amplitude passes here, or at a quarter of the rows' rate if that is lower. [Hz]
    """
    rate = 1.0 / data.step_s
    kernel, every, corner = row_filter(rate, corner_hz)
    doubt = filter_rows((~(data.moving & data.valid)).astype(float), np.abs(kernel), every)
    whole = filter_rows((~data.valid).astype(float), np.ones_like(kernel), every) < 0.5  # noqa: PLR2004 - none at all
    cycle = data.cycle[::every]
    used = (doubt <= MOST_UNCERTAIN) & whole & (cycle >= 0)
    breakaways = _breakaways(data)
    at = breakaways.onset // every
    used[at] = whole[at] & (cycle[at] >= 0)
    bare = Rows(
        kernel=kernel,
        corner_hz=corner,
        every=every,
        used=used,
        t=data.t[::every][used],
        y=np.zeros(0),
        cycle=cycle[used],
        breakaways=breakaways,
        breakaway_row=at,
        breakaway_weight=_relative_weight(breakaways.weights, data.step_s),
    )
    return replace(bare, y=bare.of(data.torque))


def row_filter(rate_hz: float, corner_hz: float) -> tuple[Float, int, float]:
    """Weights of the filter of rows, an odd number of them, samples per row, and the corner in fact. [Hz]

    Args:
        rate_hz: Of the samples.
        corner_hz: Half of the amplitude passes here, or at a quarter of the rows' rate if that is lower.
    """
    from scipy.signal import firwin, kaiserord

    every = max(int(rate_hz / ROW_HZ + 1e-9), 1)
    corner = min(corner_hz, rate_hz / every / 4)
    taps, beta = kaiserord(STOPBAND_DB, corner / (rate_hz / 2))
    return np.asarray(firwin(taps | 1, corner, window=("kaiser", beta), fs=rate_hz), np.float64), every, corner


def _breakaways(data: JointData) -> Breakaways:
    found = find_breakaways(data.q, data.dq, data.dead_speed_rad_s, data.step_s)
    return found.take(torque_known(data.torque, found, data.step_s))


def _relative_weight(weights: Float, step_s: float) -> float:
    """Noise that the rows' highest corner leaves of white noise, over that which other weights leave, at most 1.

    Where the corner is lower the torque's noise is hardly white: a lower weight would be too low.
    """
    return min(float(np.sqrt(2.0 * CORNER_HZ * step_s) / np.linalg.norm(weights)), 1.0)


def corner_for(data: JointData, inertia_kg_m2: float) -> float:
    """Frequency above which the noise of inertia times acceleration is more than half of that of the torque. [Hz]

    The position's noise, white, grows with the square of the frequency in its second derivative, the velocity's with
    the frequency, of the mean of both by both. Links' inertia that was taken away left the
    noise of all joints' accelerations in the torque.
    """
    order = 2 if data.derived_from == "q" else 1
    load = np.zeros(len(data.t)) if data.load is None else data.load
    torque = noise_density(data.torque + load, data.step_s, 0)
    own = inertia_kg_m2 * noise_density(data.ddq, data.step_s, order)
    inertial = float(np.hypot(own, noise_density(load, data.step_s, order)))
    crossing = (QUIET_SHARE * torque / inertial) ** (1.0 / order) if inertial > 0 else CORNER_HZ
    # f^2 / sqrt(f^2 + crossover^2) in the place of f, solved for f
    crossing = np.sqrt((crossing**2 + np.hypot(crossing**2, 2.0 * crossing * data.crossover_hz)) / 2.0)
    return float(np.clip(crossing, LOWEST_CORNER_HZ, CORNER_HZ))


def noise_density(signal: Float, step_s: float, order: int) -> float:
    """D of a noise whose amplitude density is D f^order up to a fifth of the rate, from second differences."""
    w = np.linspace(0.0, 0.4 * np.pi, 400)
    gain = float(np.sqrt(np.trapezoid((w / (2 * np.pi * step_s)) ** (2 * order) * (2 - 2 * np.cos(w)) ** 2, w)))
    bend = float(np.median(np.abs(np.diff(signal, n=2))))
    return bend / gain


def filter_rows(
    columns: Float,
    kernel: Float,
    every: int,
    wanted: NDArray[np.int64] | None = None,
    out: Float | None = None,
) -> Float:
    """Filter symmetrically, the ends held, and take every so many samples, first sample first, along axis 0.

    The same numbers as ``scipy.signal.upfirdn``, many times as fast: thousands of columns go through here.

    Args:
        columns: Shape (n,) or (n, p).
        kernel: Weights, an odd number of them.
        every: Samples per row.
        wanted: Numbers of the rows that are wanted, all if None, shape (m,).
        out: Where to write them, shape (p, m); a new array if None.
    """
    rows = np.arange((len(columns) - 1) // every + 1) if wanted is None else wanted
    side_by_side = np.ascontiguousarray(np.atleast_2d(columns.T), np.float64)
    # Weights of zero behind the others, for a processor takes many at a time and the rest one by one.
    whole = np.append(kernel, np.zeros(-len(kernel) % AT_A_TIME))
    written = np.empty((len(side_by_side), len(rows))) if out is None else out
    _filter(side_by_side, whole, len(kernel) // 2, every, rows, written)
    filtered = written.T
    return np.asarray(filtered if columns.ndim > 1 else filtered[:, 0])


@compiled(any_order=True)
def _filter(columns: Float, kernel: Float, centre: int, every: int, rows: NDArray[np.int64], out: Float) -> None:
    reach, last = len(kernel), columns.shape[1] - 1
    for j in range(len(columns)):
        column, k = columns[j], 0
        while k < len(rows):
            first = rows[k] * every - centre
            second, third, fourth = first + every, first + 2 * every, first + 3 * every
            if first >= 0 and k + 3 < len(rows) and rows[k + 3] == rows[k] + 3 and fourth + reach <= last + 1:
                # Four rows in a line share the weights that were read.
                a, b = column[first : first + reach], column[second : second + reach]
                c, d = column[third : third + reach], column[fourth : fourth + reach]
                total_a = total_b = total_c = total_d = 0.0
                for i in range(reach):
                    total_a += kernel[i] * a[i]
                    total_b += kernel[i] * b[i]
                    total_c += kernel[i] * c[i]
                    total_d += kernel[i] * d[i]
                out[j, k], out[j, k + 1], out[j, k + 2], out[j, k + 3] = total_a, total_b, total_c, total_d
                k += 4
            else:
                total = 0.0
                for i in range(reach):
                    total += kernel[i] * column[min(max(first + i, 0), last)]
                out[j, k] = total
                k += 1
