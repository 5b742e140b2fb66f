"""Huber's weights for a linear regression: outliers count less.

The same weights as ``RLM`` of statsmodels (the tests compare them). Written here because the columns are few and the
rows many: normal equations take a tenth of the time, and loading statsmodels takes longer than reading an hour of log.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.friction.paper import Equations
from friction_audit.joint_log import Float

HUBER = 1.345
"""Residuals beyond this many standard deviations lose weight: 95 % efficiency where the noise is normal."""

SIGMA_PER_MEDIAN = 1 / 0.6744897501960817
"""Standard deviation of a normal variable over the median of its absolute value."""

REWEIGHTINGS = 9
CUTOFF = 1e-14
"""Relative size below which a singular value of the normal matrix counts as zero."""


def huber_weights(design: Float, target: Float, instruments: Float | None = None) -> Float:
    """Return the weights of the rows in Huber's estimate, 1 except for outliers.

    Args:
        design: Columns of comparable length, shape (m, p).
        target: Shape (m,).
        instruments: What stands for columns that are noisy themselves, shape (m, p); None: the columns. Weights from a
            biased solution are biased, for they count less where noise and error have one sign.
    """
    own = instruments is None
    instruments = design if instruments is None else instruments
    smallest = np.finfo(float).eps * float(np.abs(target).max()) + np.finfo(float).tiny
    weights = np.ones(len(target))
    for _ in range(REWEIGHTINGS):
        weighted = instruments * weights[:, None]
        solution = np.linalg.pinv(weighted.T @ design, rcond=CUTOFF, hermitian=own) @ (weighted.T @ target)
        residual = np.abs(target - design @ solution).clip(min=smallest)
        weights = np.minimum(HUBER * SIGMA_PER_MEDIAN * np.median(residual) / residual, 1.0)
    return weights


BLOCK_S = 0.02
"""The position is averaged over so long: the finer part of its noise and resolution goes. [s]"""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Instruments:
    """Motion by the position at m rows.

    Attributes:
        velocity: Shape (m,). [rad/s]
        acceleration: Shape (m,). [rad/s^2]
    """

    velocity: Float
    acceleration: Float


def block_length(step_s: float) -> int:
    """Return how many samples are averaged, an odd number so that the average has a middle."""
    return 2 * int(0.5 * BLOCK_S / step_s) + 1


def reach(block: int) -> int:
    """Return how many samples before and after a row its instruments need."""
    return block + block // 2


def instruments_at(t: Float, q: Float, index: NDArray[np.int64], block: int) -> Instruments:
    """Difference the averages of three neighbouring blocks of the position.

    Args:
        t: Time, shape (n,). [s]
        q: Position, shape (n,). [rad]
        index: Samples at the rows, ``reach(block)`` from both ends at least, shape (m,).
        block: Samples per block.
    """
    around = index[:, None] + np.arange(-reach(block), reach(block) + 1)
    before, here, after = q[around].reshape(len(index), 3, block).mean(axis=2).T
    first, middle, last = t[around].reshape(len(index), 3, block).mean(axis=2).T
    left, right = (here - before) / (middle - first), (after - here) / (last - middle)
    return Instruments(velocity=(after - before) / (last - first), acceleration=2.0 * (right - left) / (last - first))


CONFIDENCE = 0.95
RIDGE = 1e-10
"""Relative to unit columns: keeps a window without any motion of one kind solvable, changes nothing else."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Fit:
    """Solutions of w windows: values and standard errors of the p columns, shape (w, p), and degrees of freedom."""

    names: tuple[str, ...]
    value: Float
    error: Float
    freedom: int

    def coefficient(self, name: str, window: int = -1) -> Coefficient:
        """Return one coefficient with its interval."""
        if name not in self.names:
            return UNDETERMINED
        value, half = self.column(name)
        return Coefficient(
            value=float(value[window]), low=float((value - half)[window]), high=float((value + half)[window])
        )

    def column(self, name: str) -> tuple[Float, Float]:
        """Return the values of a column and the half widths of their intervals, shape (w,) each."""
        if name not in self.names:
            nothing = np.full(len(self.value), np.nan)
            return nothing, nothing
        column = self.names.index(name)
        quantile = float(stdtrit(self.freedom, 0.5 + CONFIDENCE / 2))
        return self.value[:, column], quantile * self.error[:, column]


def fit_windows(equations: Equations, window: int) -> Fit:
    """Solve every window of consecutive cycles, with a jackknife over its cycles.

    Args:
        equations: Equations of m cycles.
        window: Cycles per window, at most m.

    Returns:
        Solutions of the m - window + 1 windows, in order.
    """
    normal = _sliding_sum(equations.normal, window)
    right = _sliding_sum(equations.right, window)
    value = _solve(normal, right)
    error = np.sqrt((window - 1) * _without_one(equations, normal, right, window).var(axis=0))
    return Fit(
        names=equations.names, value=value / equations.scale, error=error / equations.scale, freedom=max(window - 1, 1)
    )


def _without_one(equations: Equations, normal: Float, right: Float, window: int) -> Float:
    """Solve every window without its first cycle, without its second, and so on: shape (window, w, p)."""
    windows = len(normal)
    if windows == 1:
        return _solve(normal - equations.normal, right - equations.right)[:, None]
    places = (slice(first, first + windows) for first in range(window))
    return np.stack([_solve(normal - equations.normal[place], right - equations.right[place]) for place in places])


def _sliding_sum(blocks: Float, window: int) -> Float:
    total = np.zeros((len(blocks) + 1, *blocks.shape[1:]))
    np.cumsum(blocks, axis=0, out=total[1:])
    return np.asarray(total[window:] - total[:-window], np.float64)


def _solve(normal: Float, right: Float) -> Float:
    size = normal.shape[-1]
    return np.asarray(np.linalg.solve(normal + RIDGE * np.eye(size), right[..., None])[..., 0], np.float64)


def conditioning(equations: Equations) -> tuple[float, float]:
    """Return the condition number of the scaled matrix and the correlation of the two friction coefficients."""
    normal = equations.normal.sum(axis=0)
    values, vectors = np.linalg.eigh(normal)
    condition = float(np.sqrt(values[-1] / values[0])) if values[0] > 0 else float("inf")
    if equations.names[:2] != ("coulomb", "viscous"):
        return condition, float("nan")
    # Rounding may leave eigenvalues of a singular matrix below zero, and variances with them.
    covariance = (vectors / values.clip(min=RIDGE)) @ vectors.T
    return condition, float(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]))
