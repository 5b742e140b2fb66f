"""Weighted least squares on the energy balance of parts of cycles, with a jackknife over whole cycles.

    E_net = mu_c L + mu_v S + b dq + c_x G_x + c_y G_y + B d(v^2/2)

L is the path, S the integral of the squared speed (20), summed like the work as v over the position; the other columns
take up what is not friction: a torque offset, an error of gravity, and the kinetic energy at the borders of the parts.
"""

import math
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.energy_cycles import BALANCE, PAIRS, EnergyCycles

FRICTION = {"combined": ("coulomb", "viscous"), "coulomb": ("coulomb",), "viscous": ("viscous",)}
COLUMNS = ("coulomb", "viscous", "offset", "inertia", "gravity_x", "gravity_y")  # in the order of BALANCE
# A nuisance column counts if at least this share of its length is independent of the columns before it; a column that
# the motion hardly excites (gravity about a vertical axis) would add nothing but variance.
INDEPENDENT_SHARE = 0.02
CONFIDENCE = 0.95
HUBER = 1.345  # residuals beyond so many standard deviations lose weight: 95 % efficiency where the noise is normal
SIGMA_PER_MEDIAN = 1 / 0.6744897501960817  # standard deviation of a normal variable over its median absolute value
REWEIGHTINGS = 9
CUTOFF = 1e-14  # relative size below which a singular value of the normal matrix counts as zero
MOST_STROKES = 40  # left out one at a time with an unknown chain; of more, several together
RIDGE = 1e-10  # relative to unit columns: keeps a window without any motion of one kind solvable


class NormalEquations(NamedTuple):
    """Weighted equations of one joint, summed by group (a cycle, or a stroke)."""

    names: tuple[str, ...]  # names of columns; those of the friction model come first
    normal: Float  # A_g^T W A_g per group, shape (m, p, p)
    right: Float  # A_g^T W y_g per group, shape (m, p)
    scale: Float  # lengths by which the columns were divided, shape (p,)
    precision: Float = np.empty(0)  # of the coefficients of columns without a name, which come last

    def conditioning(self) -> tuple[float, float]:
        """Return the condition number of the scaled matrix and the correlation of the two friction coefficients."""
        # Not by eigenvalues: with instruments the matrix is not symmetric.
        normal, p = self.normal.sum(axis=0), len(self.names)
        others = np.linalg.solve(normal[p:, p:] + np.diag(self.precision), normal[p:, :p])
        _, values, rows = np.linalg.svd(normal[:p, :p] - normal[:p, p:] @ others)
        is_singular = values[-1] < len(values) * np.finfo(float).eps * values[0]
        condition = float("inf") if is_singular else float(np.sqrt(values[0] / values[-1]))
        if self.names[:2] != ("coulomb", "viscous"):
            return condition, float("nan")
        covariance = (rows.T / values.clip(min=RIDGE)) @ rows
        return condition, float(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]))


def normal_equations(cycles: EnergyCycles, model: str) -> NormalEquations:
    """Set up the equations of the cycles of one joint that count.

    The noise of an energy is the torque's noise weighted with the velocity, so its variance grows with the integral of
    the squared speed; each row is divided by its square root. Columns are scaled to unit length. Nuisance columns count
    that are independent of the ones before.
    """
    place = np.zeros((len(BALANCE), len(BALANCE)), np.int64)  # of each product among those of a cycle
    place[PAIRS] = place.T[PAIRS] = np.arange(len(PAIRS[0]))
    total = cycles.products.sum(axis=0)[place]
    scale = np.sqrt(np.diag(total))
    gram, used = total / np.outer(scale, scale).clip(min=np.finfo(float).tiny), [*map(COLUMNS.index, FRICTION[model])]
    for one in range(len(FRICTION["combined"]), len(COLUMNS)):
        by_others = np.linalg.lstsq(gram[np.ix_(used, used)], gram[used, one], rcond=None)[0]
        if gram[one, one] - gram[one, used] @ by_others > INDEPENDENT_SHARE**2:
            used.append(one)
    scale = scale[used]
    return NormalEquations(
        names=tuple(COLUMNS[one] for one in used),
        normal=cycles.products[:, place[np.ix_(used, used)]] / np.outer(scale, scale),
        right=cycles.products[:, place[used, -1]] / scale,
        scale=scale,
    )


class Fit(NamedTuple):
    """Solutions of w windows: values and standard errors of the p columns, shape (w, p), and degrees of freedom."""

    names: tuple[str, ...]
    value: Float
    error: Float
    freedom: int

    def coefficient(self, name: str, window: int = -1) -> Coefficient:
        """Return one coefficient with its interval; undetermined if it was not fitted."""
        if name not in self.names:
            return UNDETERMINED
        value, half = (float(part[window]) for part in self.column(name))
        return Coefficient.around(value, half)

    def column(self, name: str) -> tuple[Float, Float]:
        """Return the values of a column and the half widths of their intervals, shape (w,) each."""
        if name not in self.names:
            nothing = np.full(len(self.value), np.nan)
            return nothing, nothing
        column = self.names.index(name)
        return self.value[:, column], t_quantile(self.freedom) * self.error[:, column]


@cache
def t_quantile(freedom: int) -> float:
    """Return the half width of an interval of CONFIDENCE in standard errors (Abramowitz and Stegun, 26.7.3, 26.7.4)."""
    # Newton's method: to load scipy.special takes a fifth of all that `estimate` does with a short log.
    odd = freedom % 2
    k = np.arange(2 + odd, freedom - 1, 2)
    log_slope = math.log(2.0 / math.sqrt(math.pi)) + math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)
    angle, step = math.atan(1.95 / math.sqrt(freedom)), 1.0  # of less: from below, every step stays below
    while step > 1e-15 * angle:
        sine, cosine = math.sin(angle), math.cos(angle)
        share = sine * cosine**odd * (1.0 + float(np.cumprod((k - 1) / k * cosine**2).sum())) * (freedom > 1)
        share = 2.0 / math.pi * (angle + share) if odd else share
        step = (CONFIDENCE - share) / math.exp(log_slope + (freedom - 1) * math.log(cosine))
        angle += step
    return math.sqrt(freedom) * math.tan(angle)


def fit_windows(equations: NormalEquations, window: int) -> Fit:
    """Solve all windows of so many consecutive groups, m at most, each with a jackknife over its groups."""
    both = (equations.normal, equations.right)
    normal, right = (np.lib.stride_tricks.sliding_window_view(one, window, axis=0).sum(axis=-1) for one in both)
    windows = len(normal)
    ridge = np.diag(np.append(np.full(len(equations.names), RIDGE), equations.precision))
    value = _solve(normal + ridge, right)
    if windows == 1:
        variance = _solve(normal - equations.normal + ridge, right - equations.right).var(axis=0)[None]
    else:  # of a day's cycles one place in all windows at a time
        total, square = np.zeros_like(value), np.zeros_like(value)
        for first in range(window):
            place = slice(first, first + windows)
            change = _solve(normal - equations.normal[place] + ridge, right - equations.right[place]) - value
            total, square = total + change, square + change**2
        variance = (square / window - (total / window) ** 2).clip(min=0.0)
    error = np.sqrt((window - 1) * variance) / equations.scale
    return Fit(names=equations.names, value=value / equations.scale, error=error, freedom=max(window - 1, 1))


def _solve(normal: Float, right: Float) -> Float:
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0], np.float64)


class Rows(NamedTuple):
    """Rows of the regression, m rows and p columns, their instruments, strokes and places among all rows."""

    names: tuple[str, ...]
    columns: Float
    instruments: Float
    torque: Float
    more: dict[str, Float]  # columns that are fitted with them by turns
    stroke: Int
    place: Int
    chain: tuple[Float, Float] | None = None  # an orthonormal basis, shape (k, m), and its k standard deviations

    def whitened(self, columns: Float) -> Float:
        """Return columns, shape (m, q) or (m,), among whose noise the chain is no more."""
        if self.chain is None:
            return columns
        basis, size = self.chain
        return np.asarray(columns - ((basis @ columns).T * (1.0 - 1.0 / np.hypot(1.0, size)) @ basis).T)

    def free(self) -> "Rows":
        """Return the rows without the chain."""
        changed: dict[str, Any] = {
            name: self.whitened(getattr(self, name)) for name in ("columns", "instruments", "torque")
        }
        return self._replace(**changed, chain=None)


def fit_rows(rows: Rows) -> tuple[NormalEquations, Fit]:
    """Sum the rows by stroke with Huber's weights, and solve, with intervals by the factor that the weights ask for.

    A clipped residual does not answer to a change of the coefficients, which weights that are held do not show:
    standard errors grow by the mean weight over the share that is not clipped (P. J. Huber, Robust Statistics, 1981,
    7.6).
    """
    free = rows.free()
    scale = np.linalg.norm(free.columns, axis=0).clip(min=np.finfo(float).tiny)
    weights = huber_weights(free.columns / scale, free.torque, free.instruments / scale)
    scaled, instruments = rows.columns / scale, rows.instruments / scale
    first, precision = np.flatnonzero(np.diff(rows.stroke, prepend=-1)), np.empty(0)
    if rows.chain is not None:
        scaled, instruments = (np.hstack([one, rows.chain[0].T]) for one in (scaled, instruments))
        scale, precision = np.append(scale, np.ones(len(rows.chain[0]))), rows.chain[1] ** -2.0
        first = first[:: -(-len(first) // MOST_STROKES)]
    weighted = instruments * weights[:, None]
    strokes = [slice(*both) for both in pairwise([*first.tolist(), len(scaled)])]
    equations = NormalEquations(
        names=rows.names,
        normal=np.stack([weighted[one].T @ scaled[one] for one in strokes]),
        right=np.add.reduceat(weighted.T * rows.torque, first, axis=-1).T,
        scale=scale,
        precision=precision,
    )
    fit = fit_windows(equations, len(first))
    return equations, fit._replace(error=float(weights.mean() / np.mean(weights >= 1.0)) * fit.error)


def huber_weights(design: Float, target: Float, instruments: Float | None = None) -> Float:
    """Return the weights of the rows in Huber's estimate, 1 except for outliers.

    The weights of ``RLM`` of statsmodels (a test compares them), which knows no instruments, takes ten times as long
    on few columns and many rows, and takes longer to load than an hour of log to read. The columns of the design, of
    comparable length, shape (m, p), are noisy themselves where instruments stand for them: weights from a biased
    solution are biased, for they count less where noise and error have one sign.
    """
    instruments = design if instruments is None else instruments
    smallest = np.finfo(float).eps * float(np.abs(target).max()) + np.finfo(float).tiny
    weights = np.ones(len(target))
    for _ in range(REWEIGHTINGS):
        weighted = instruments * weights[:, None]
        solution = np.linalg.lstsq(weighted.T @ design, weighted.T @ target, CUTOFF)[0]
        residual = np.abs(target - design @ solution).clip(min=smallest)
        weights = np.minimum(HUBER * SIGMA_PER_MEDIAN * np.median(residual) / residual, 1.0)
    return weights
