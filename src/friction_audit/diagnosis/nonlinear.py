"""Nonlinear parameters between the points of the grid, by variable projection.

G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; the Jacobian of L. Kaufman, BIT 15 (1975) 49.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.gram import Training
from friction_audit.diagnosis.selection import Projected
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

STEPS = 4
SHORTER = (1.0, 1 / 3, 1 / 9)  # parts of a step that are tried
LONGEST_STEP = 2.0  # in steps of the grid
DIFFERENCE = 0.05  # of the spacing of the grid, for finite differences
DONE = 0.2  # gain in 2 ln of the likelihood below which another step is left out


class Scale:
    """A nonlinear parameter as its logarithm where it is above zero, in units of the grid's spacing."""

    def __init__(self, dictionary: Dictionary, block: Block) -> None:
        """Take the free parameters of a block."""
        self.bounds = dictionary.bounds(block)
        self.names = list(self.bounds)
        self.start = np.array([block.shape[name] for name in self.names])
        gap = np.array([dictionary.spacing(block, name) for name in self.names])
        self.log = np.array([self.bounds[n][0] > 0 and block.shape[n] > 0 for n in self.names], bool)
        relative = np.clip(gap / np.maximum(np.abs(self.start), 1e-12), 0.02, 1.0)
        self.unit = np.where(self.log, relative, gap)
        self.shape = block.shape

    def at(self, x: Float) -> dict[str, float]:
        """Parameters at a point, within their bounds."""
        moved = np.where(self.log, self.start * np.exp(np.clip(x * self.unit, -4, 4)), self.start + x * self.unit)
        free = {n: float(np.clip(v, *self.bounds[n])) for n, v in zip(self.names, moved, strict=True)}
        return {**self.shape, **free}


class Projection:
    """What an effect leaves, as a function of its nonlinear parameters; everything else is partialled out."""

    def __init__(
        self, dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
    ) -> None:
        """Partial out the nominal model, the nuisances and other effects."""
        self.given = Projected(training, others)
        self.residual = self.given.left
        self.dictionary, self.gram, self.block, self.baseline = dictionary, training.gram, block, baseline
        self.samples = training.samples

    def free(self, columns: Float) -> Float:
        """Whitened columns without the rest of the model."""
        return self.given.free(self.gram.whiten(columns))

    def columns(self, shape: Nonlinear) -> Float:
        """Columns of the effect."""
        return self.dictionary.columns_at(self.block, shape, self.baseline)

    def fit(self, columns: Float) -> tuple[Float, Float]:
        """Coefficients, and what is left."""
        free = self.free(columns)
        coefficients = np.linalg.lstsq(free @ free.T, free @ self.residual, rcond=1e-10)[0]
        return coefficients, self.residual - coefficients @ free

    def cost(self, left: Float) -> float:
        """2 ln of the likelihood, with its sign turned, up to a constant."""
        return self.samples * float(np.log(max(float(left @ left), 1e-300)))

    def at(self, scale: Scale, x: Float) -> "Point":
        """Fit at a point; the cost is infinite where signs are impossible."""
        shape = scale.at(x)
        columns = self.columns(shape)
        coefficients, left = self.fit(columns)
        possible = self.block.effect.admissible(self.block.whole(coefficients), shape)
        return Point(x, self.cost(left) if possible else np.inf, coefficients, left, columns)

    def gauss_newton(self, scale: Scale, point: "Point") -> Float:
        """A step of Gauss and Newton with Kaufman's Jacobian, damped a little."""
        inside = np.linalg.qr(self.free(point.columns).T)[0]
        slopes = np.empty((len(point.x), len(point.left)))
        for k, unit in enumerate(np.eye(len(point.x))):
            free_ahead = scale.at(point.x + DIFFERENCE * unit) != scale.at(point.x)
            ahead = DIFFERENCE if free_ahead else -DIFFERENCE
            moved = self.columns(scale.at(point.x + ahead * unit))
            slope = point.coefficients @ self.free(moved - point.columns) / ahead
            slopes[k] = slope - inside @ (inside.T @ slope)
        normal = slopes @ slopes.T
        damping = 1e-3 * np.diag(np.maximum(np.diag(normal), 1e-12))
        step = np.linalg.lstsq(normal + damping, slopes @ point.left, rcond=1e-12)[0]
        return np.asarray(np.clip(step, -LONGEST_STEP, LONGEST_STEP))


class Point(NamedTuple):
    """A fit at some nonlinear parameters."""

    x: Float
    cost: float
    coefficients: Float
    left: Float
    columns: Float


def refine(
    dictionary: Dictionary,
    training: Training,
    block: Block,
    others: Sequence[Block],
    baseline: Nominal,
    rebuilt: bool = False,
) -> Block | None:
    """The block at the nonlinear parameters that fit best given others; None where they are those it has.

    Args:
        dictionary: Builds columns.
        training: What is fitted.
        block: Where to start.
        others: The active set without it.
        baseline: The nominal model that its columns follow from.
        rebuilt: Whether its columns are compared with those that it has now, of an older nominal model.
    """
    scale = Scale(dictionary, block)
    if not scale.names:
        return None
    problem = Projection(dictionary, training, block, others, baseline)
    point = problem.at(scale, np.zeros(len(scale.names)))
    first = problem.cost(problem.fit(block.columns)[1]) if rebuilt else point.cost
    if not np.isfinite(point.cost):
        return None
    for _ in range(STEPS):
        better = _line_search(problem, scale, point)
        gained = 0.0 if better is None else point.cost - better.cost
        point = better or point
        if gained < DONE:
            break
    if first - point.cost < DONE:
        return None
    return block.moved(scale.at(point.x), point.columns)


def _line_search(problem: Projection, scale: Scale, point: Point) -> Point | None:
    """The first better point along a step; None without one."""
    step = problem.gauss_newton(scale, point)
    for part in SHORTER:
        trial = problem.at(scale, point.x + part * step)
        if trial.cost < point.cost:
            return trial
    return None


def coefficients_given(training: Training, others: Sequence[Block], columns: Float) -> Float:
    """Coefficients of the nominal model and nuisances fitted with some effects and more columns."""
    gram = training.gram
    kept = training.fit(others).kept
    rows = np.vstack([gram.base[kept], *(gram.of(b) for b in others), gram.whiten(columns)])
    prior = np.diag(np.append(gram.precision[kept], np.zeros(len(rows) - len(kept))))
    scale = np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))
    whole = (rows @ rows.T + prior) / scale[:, None] / scale
    return np.asarray(np.linalg.lstsq(whole, rows @ gram.y / scale, rcond=1e-11)[0] / scale)
