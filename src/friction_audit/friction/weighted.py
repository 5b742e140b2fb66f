"""The default estimator: weighted least squares over parts of cycles, intervals from a jackknife over cycles.

Rows of one cycle share its errors (coloured torque noise, the speed at a common border, whatever the model lacks), so
a row is not a piece of independent evidence but a cycle is. Leaving out one cycle at a time gives a variance that is
right whatever the correlation inside a cycle (the CR3 cluster-robust variance), and slightly too large, never too
small, with few cycles.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from friction_audit.friction.equations import Equations
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

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
