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

STEPS = 12  # of a ramp that ends as a step (effects_friction_step_30009)
INNER_STEPS = 2  # of the nominal coefficients; the torque of a link hardly changes with them away from reversals
SHORTER = (1.0, 1 / 3, 1 / 9)  # parts of a step that are tried
LONGEST_STEP = 2.0  # in steps of the grid
DIFFERENCE = 0.05  # of the spacing of the grid, for finite differences
COARSE_TO_FINE = (0.3, 0.1)  # the same of a link, whose impacts come and go (C. T. Kelley, Implicit Filtering, 2011)
LEAST_GAIN = 0.5  # of the largest on the grid; half a step off, a point of a grid keeps more of its maximum
MOST_STARTS = 4
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


class Point(NamedTuple):
    """A fit at x: -2 ln of the likelihood, whitened residual, orthonormal rows of the linear part."""

    x: Float
    cost: float
    coefficients: Float
    left: Float
    inside: Float
    columns: Float


class Projection:
    """What an effect leaves, as a function of its nonlinear parameters; everything else is partialled out."""

    def __init__(
        self, dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
    ) -> None:
        """Partial out the nominal model, the nuisances and other effects."""
        self.given = Projected(training, others)
        self.dictionary, self.gram, self.block, self.baseline = dictionary, training.gram, block, baseline
        self.samples = training.samples

    def at(self, scale: Scale, x: Float, near: Point | None = None) -> Point:  # noqa: ARG002
        """Fit at a point; the cost is infinite where signs are impossible."""
        shape = scale.at(x)
        columns = self.dictionary.columns_at(self.block, shape, self.baseline)
        free = self.given.free(self.gram.whiten(columns))
        coefficients = np.linalg.lstsq(free @ free.T, free @ self.given.left, rcond=1e-10)[0]
        left = self.given.left - coefficients @ free
        possible = self.block.effect.admissible(self.block.whole(coefficients), shape)
        cost = self.cost(float(left @ left)) if possible else np.inf
        inside = np.vstack([self.given.basis, np.linalg.qr(free.T)[0].T])
        return Point(x, cost, coefficients, left, inside, columns)

    def cost(self, rss: float) -> float:
        """2 ln of the likelihood, with its sign turned, up to a constant."""
        return self.samples * float(np.log(max(rss, 1e-300)))

    def torques(self, point: Point, shapes: Sequence[Nonlinear]) -> Float:
        """Torque of the effect at other nonlinear parameters, its coefficients those of a point, shape (k, m)."""
        columns = (self.dictionary.columns_at(self.block, shape, self.baseline) for shape in shapes)
        return np.stack([point.coefficients @ one for one in columns])

    def gauss_newton(self, scale: Scale, point: Point, difference: float) -> Float:
        """A step of Gauss and Newton with Kaufman's Jacobian, damped a little."""
        here, ahead = scale.at(point.x), difference * np.eye(len(point.x))
        ahead[[scale.at(point.x + one) == here for one in ahead]] *= -1.0
        torques = self.gram.whiten(self.torques(point, [here, *(scale.at(point.x + one) for one in ahead)]))
        slopes = (torques[1:] - torques[0]) / ahead.sum(axis=1)[:, None]
        slopes -= (slopes @ point.inside.T) @ point.inside
        normal = slopes @ slopes.T
        damping = 1e-3 * np.diag(np.maximum(np.diag(normal), 1e-12))
        step = np.linalg.lstsq(normal + damping, slopes @ point.left, rcond=1e-12)[0]
        return np.asarray(np.clip(step, -LONGEST_STEP, LONGEST_STEP))


class JointProjection(Projection):
    """The same for an effect that acts on the nominal torque: the nominal coefficients are fitted with it.

    Its torque follows from them and from its nonlinear parameters, without a coefficient of its own, and is built again
    from the nominal coefficients of every point.
    """

    def __init__(
        self, dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
    ) -> None:
        """Take the nominal model, the nuisances and other effects."""
        super().__init__(dictionary, training, block, others, baseline)
        fit, gram = training.fit([*others, block]), training.gram
        self.rows = np.vstack([gram.base[fit.kept], *(gram.of(other) for other in others)])
        self.precision = np.append(gram.precision[fit.kept], np.zeros(len(self.rows) - len(fit.kept)))
        self.inside = np.linalg.qr(self.rows.T)[0].T
        self.start = fit.coefficients[: len(self.rows)]

    def at(self, scale: Scale, x: Float, near: Point | None = None) -> Point:
        """Fit at a point, from the nominal coefficients of another."""
        shape = scale.at(x)
        coefficients = self.start if near is None else near.coefficients
        for _ in range(INNER_STEPS):
            nominal = self._nominal(coefficients)
            response = self.gram.y - self.gram.whiten(self.dictionary.torques_at(self.block, [shape], [nominal]))[0]
            coefficients = _ridge(self.rows, response, self.precision)
        left = response - coefficients @ self.rows
        cost = self.cost(float(left @ left + self.precision @ coefficients**2))
        return Point(x, cost, coefficients, left, self.inside, self.dictionary.columns_at(self.block, shape, nominal))

    def _nominal(self, coefficients: Float) -> Nominal:
        return self.gram.problem.nominal.baseline(coefficients[: len(self.gram.problem.X)])

    def torques(self, point: Point, shapes: Sequence[Nonlinear]) -> Float:
        """Torque of the effect at other nonlinear parameters, the nominal coefficients those of a point, (k, m)."""
        return self.dictionary.torques_at(self.block, shapes, [self._nominal(point.coefficients)] * len(shapes))


def refine(
    dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
) -> Block | None:
    """The block at the nonlinear parameters that fit best given others; None where they are those it has.

    Args:
        dictionary: Builds columns.
        training: What is fitted.
        block: Where to start; other local maxima of the grid are starts too.
        others: The active set without it.
        baseline: The nominal model that its columns follow from, unless that is fitted with it.
    """
    found = [
        _minimum(dictionary, training, one, others, baseline) for one in (block, *_starts(training, block, others))
    ]
    return min((one for one in found if one is not None), key=lambda one: one[0], default=(0.0, None))[1]


def _starts(training: Training, block: Block, others: Sequence[Block]) -> list[Block]:
    """Points of an effect's grid next to which another minimum may lie: where the gain has a local maximum.

    The likelihood of a ripple has many over its order, and between points of the grid most of the gain
    is lost: without them torque_ripple_40003 is 2 % off. The best other sets of nonlinear parameters are starts too.
    """
    kinds: dict[frozenset[str], list[tuple[float, Block]]] = {}
    for one, gain, coefficients in zip(training.gram.blocks, *training.gain(others), strict=True):
        if one.shape and one.effect is block.effect and not one.refined and one.possible(coefficients):
            kinds.setdefault(frozenset(one.shape), []).append((float(gain), one))
    found = [start for kind in kinds.values() for start in _local_maxima(kind, block)]
    least = LEAST_GAIN * max((gain for kind in kinds.values() for gain, _ in kind), default=0.0)
    found.sort(key=lambda start: -start[0])
    return [one for gain, one in found if gain > least][:MOST_STARTS]


def _local_maxima(points: Sequence[tuple[float, Block]], block: Block) -> list[tuple[float, Block]]:
    """Points of one set of nonlinear parameters with a larger gain than their neighbours, but for those of a block."""
    names = sorted(points[0][1].shape)
    values = np.array([[one.shape[name] for name in names] for _, one in points])
    levels = [np.unique(column) for column in values.T]
    place = np.array([np.searchsorted(level, column) for level, column in zip(levels, values.T, strict=True)])
    gain = np.array([gain for gain, _ in points])
    near = np.all(np.abs(place[:, :, None] - place[:, None, :]) <= 1, axis=0)
    best = gain >= np.max(np.where(near, gain, -np.inf), axis=1)
    if set(block.shape) == set(names):
        at = [
            np.interp(block.shape[name], level, np.arange(len(level)))
            for name, level in zip(names, levels, strict=True)
        ]
        best &= np.any(np.abs(place - np.array(at)[:, None]) > 1, axis=0)
    return [point for point, largest in zip(points, best.tolist(), strict=True) if largest]


def _minimum(
    dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
) -> tuple[float, Block] | None:
    """Cost, with the penalty of Schwarz, and block at the minimum next to a start."""
    scale = Scale(dictionary, block)
    if not scale.names:
        return None
    kind = Projection if not block.effect.follows else JointProjection
    problem = kind(dictionary, training, block, others, baseline)
    point = first = problem.at(scale, np.zeros(len(scale.names)))
    if not np.isfinite(point.cost):
        return None
    # Where the torque jumps the cost has no slope: Brent's line search first (effects_unlogged_compensation_70003).
    for unit in np.eye(len(scale.names))[[name in block.effect.jumps for name in scale.names]]:
        from scipy.optimize import minimize_scalar  # most diagnoses need none of it

        best = minimize_scalar(lambda x, unit=unit: problem.at(scale, x * unit).cost, bounds=(-1, 1), method="bounded")
        point = min(point, problem.at(scale, float(best.x) * unit), key=lambda one: one.cost)
    for difference in (DIFFERENCE,) if kind is Projection else COARSE_TO_FINE:
        for _ in range(STEPS):
            better = _line_search(problem, scale, point, difference)
            gained = 0.0 if better is None else point.cost - better.cost
            point = better or point
            if gained < DONE:
                break
    if kind is Projection and first.cost - point.cost < DONE:
        return None
    penalty = len(scale.names) * float(np.log(training.samples))
    return point.cost + penalty, block.moved(scale.at(point.x), point.columns)


def _line_search(problem: Projection, scale: Scale, point: Point, difference: float) -> Point | None:
    """The first better point along a step; None without one."""
    step = problem.gauss_newton(scale, point, difference)
    for part in SHORTER:
        trial = problem.at(scale, point.x + part * step, point)
        if trial.cost < point.cost:
            return trial
    return None


def _ridge(rows: Float, y: Float, precision: Float) -> Float:
    """Coefficients of least squares with normal priors about zero."""
    scale = np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))
    whole = (rows @ rows.T + np.diag(precision)) / scale[:, None] / scale
    return np.asarray(np.linalg.lstsq(whole, rows @ y / scale, rcond=1e-11)[0] / scale)
