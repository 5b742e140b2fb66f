"""Nonlinear parameters between the points of the grid, and the values of all numbers with 95 % intervals.

The first by variable projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; the Jacobian of
L. Kaufman, BIT 15 (1975) 49. The intervals by a cluster jackknife over cycles: the model is linearised in its nonlinear
parameters at their estimate, and leaving out one cycle at a time moves all numbers together (A. C. Cameron,
D. L. Miller, Journal of Human Resources 50 (2015) 317). A coefficient that follows from the nonlinear parameters, as a
compliance from the stiffness, has their interval. A nonlinear parameter whose interval spans a decade, or its grid, is
not identifiable from the log.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.fitted_model import FittedModel
from friction_audit.diagnosis.gram import Gram, Training
from friction_audit.diagnosis.problem import SIGN_COLUMNS, SMOOTHED
from friction_audit.diagnosis.samples import without_each
from friction_audit.diagnosis.selection import PRIOR, Projected, occam
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
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
CONFIDENCE = 0.95
WIDEST = float(np.log(10.0)) / 2.0  # half of an interval in the logarithm of a parameter
WIDEST_STEPS = 4.0  # half of an interval of one that may be zero, in steps of its grid
PRIOR_STEPS = 10.0  # standard deviation of a parameter in steps of its grid, so that the solve has an answer
REACHES = (4 * DIFFERENCE, 1.0)  # in steps of the grid; moments within a rest, and impacts, need the longer one


class Scale:
    """The free parameters of a block, each as its logarithm where it is above zero, in units of the grid's spacing."""

    def __init__(self, dictionary: Dictionary, block: Block) -> None:
        self.dictionary, self.block, self.bounds = dictionary, block, dictionary.bounds(block)
        self.names = list(self.bounds)
        self.start = np.array([block.shape[name] for name in self.names])
        gap = np.array([dictionary.spacing(block, name) for name in self.names])
        self.log = np.array([self.bounds[n][0] > 0 and block.shape[n] > 0 for n in self.names], bool)
        relative = np.clip(gap / np.maximum(np.abs(self.start), 1e-12), 0.02, 1.0)
        self.unit = np.where(self.log, relative, gap)

    def at(self, x: Float) -> dict[str, float]:
        """Parameters at a point, within their bounds."""
        moved = np.where(self.log, self.start * np.exp(np.clip(x * self.unit, -4, 4)), self.start + x * self.unit)
        free = {n: float(np.clip(v, *self.bounds[n])) for n, v in zip(self.names, moved, strict=True)}
        return {**self.block.shape, **free}


class Point(NamedTuple):
    """A fit at x: -2 ln of the likelihood, whitened residual, orthonormal rows of the linear part."""

    x: Float
    cost: float
    coefficients: Float
    left: Float
    inside: Float
    columns: Float
    nominal: Nominal  # fitted with the effect where that acts on it


class Projection:
    """What an effect leaves, as a function of its nonlinear parameters; everything else is partialled out."""

    differences: tuple[float, ...] = (DIFFERENCE,)

    def __init__(self, scale: Scale, training: Training, others: Sequence[Block], baseline: Nominal) -> None:
        self.given = Projected(training, others)
        self.scale, self.dictionary, self.block = scale, scale.dictionary, scale.block
        self.gram, self.baseline, self.samples = training.gram, baseline, training.samples

    def at(self, x: Float, near: Point | None = None) -> Point:  # noqa: ARG002
        """Fit at a point; the cost is infinite where signs are impossible."""
        shape = self.scale.at(x)
        columns = self.dictionary.columns_at(self.block, shape, self.baseline)
        free = self.given.free(self.gram.whiten(columns))
        coefficients = np.linalg.lstsq(free @ free.T, free @ self.given.left, rcond=1e-10)[0]
        left = self.given.left - coefficients @ free
        possible = self.block.effect.possible(self.block.whole(coefficients), shape)
        cost = self.cost(float(left @ left)) if possible else np.inf
        inside = np.vstack([self.given.basis, np.linalg.qr(free.T)[0].T])
        return Point(x, cost, coefficients, left, inside, columns, self.baseline)

    def cost(self, rss: float) -> float:
        """2 ln of the likelihood, with its sign turned, up to a constant."""
        return self.samples * float(np.log(max(rss, 1e-300)))

    def gauss_newton(self, point: Point, difference: float) -> Point:
        """The first better point along a step with Kaufman's Jacobian, damped a little; the same without one."""
        here, ahead = self.scale.at(point.x), difference * np.eye(len(point.x))
        ahead[[self.scale.at(point.x + one) == here for one in ahead]] *= -1.0
        shapes = [here, *(self.scale.at(point.x + one) for one in ahead)]
        torques = self.gram.whiten(self.dictionary.torques_at(self.block, shapes, point.nominal, point.coefficients))
        slopes = (torques[1:] - torques[0]) / ahead.sum(axis=1)[:, None]
        slopes -= (slopes @ point.inside.T) @ point.inside
        normal = slopes @ slopes.T
        damping = 1e-3 * np.diag(np.maximum(np.diag(normal), 1e-12))
        step = np.linalg.lstsq(normal + damping, slopes @ point.left, rcond=1e-12)[0]
        step = np.clip(step, -LONGEST_STEP, LONGEST_STEP)
        trials = (self.at(point.x + part * step, point) for part in SHORTER)
        return next((trial for trial in trials if trial.cost < point.cost), point)

    def minimum(self) -> tuple[float, Block] | None:
        """Cost, with the penalty of Schwarz, and block at the minimum next to the start."""
        names = self.scale.names
        point = first = self.at(np.zeros(len(names)))
        if not np.isfinite(point.cost):
            return None
        # Where the torque jumps the cost has no slope: Brent's line search first (effects_unlogged_compensation_70003).
        jumps = [one.name for one in self.block.effect.nonlinear if one.jumps]
        for unit in np.eye(len(names))[[name in jumps for name in names]]:
            from scipy.optimize import minimize_scalar  # most diagnoses need none of it

            best = minimize_scalar(lambda x, unit=unit: self.at(x * unit).cost, bounds=(-1, 1), method="bounded")
            point = min(point, self.at(float(best.x) * unit), key=lambda one: one.cost)
        for difference in self.differences:
            for _ in range(STEPS):
                before, point = point, self.gauss_newton(point, difference)
                if before.cost - point.cost < DONE:
                    break
        if first.cost - point.cost < DONE and not self.block.effect.follows:
            return None
        penalty = len(names) * float(np.log(self.samples))
        return point.cost + penalty, self.block.moved(self.scale.at(point.x), point.columns)


class JointProjection(Projection):
    """The same for an effect that acts on the nominal torque: the nominal coefficients are fitted with it.

    Its torque follows from them and from its nonlinear parameters, without a coefficient of its own, and is built again
    from the nominal coefficients of every point.
    """

    differences = COARSE_TO_FINE

    def __init__(self, scale: Scale, training: Training, others: Sequence[Block], baseline: Nominal) -> None:
        super().__init__(scale, training, others, baseline)
        fit, gram = training.fit([*others, scale.block]), training.gram
        self.rows = np.vstack([gram.base[fit.kept], *(gram.of(other) for other in others)])
        self.precision = np.append(gram.precision[fit.kept], np.zeros(len(self.rows) - len(fit.kept)))
        self.inside = np.linalg.qr(self.rows.T)[0].T
        self.start = fit.coefficients[: len(self.rows)]

    def at(self, x: Float, near: Point | None = None) -> Point:
        """Fit at a point, from the nominal coefficients of another."""
        shape, rows, many = self.scale.at(x), self.rows, len(self.gram.problem.X)
        coefficients = self.start if near is None else near.coefficients
        size = np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))
        whole = (rows @ rows.T + np.diag(self.precision)) / size[:, None] / size
        for _ in range(INNER_STEPS):
            nominal = self.gram.problem.nominal.baseline(coefficients[:many])
            torque = self.dictionary.torques_at(self.block, [shape], nominal, coefficients)
            response = self.gram.y - self.gram.whiten(torque)[0]
            coefficients = np.linalg.lstsq(whole, rows @ response / size, rcond=1e-11)[0] / size
        left = response - coefficients @ rows
        cost = self.cost(float(left @ left + self.precision @ coefficients**2))
        columns = self.dictionary.columns_at(self.block, shape, nominal)
        nominal = self.gram.problem.nominal.baseline(coefficients[:many])
        return Point(x, cost, coefficients, left, self.inside, columns, nominal)


def refine(
    dictionary: Dictionary, training: Training, block: Block, others: Sequence[Block], baseline: Nominal
) -> Block | None:
    """The block at the nonlinear parameters that fit best given others; None where they are those it has."""
    kind = JointProjection if block.effect.follows else Projection
    scales = [Scale(dictionary, one) for one in (block, *_starts(training, block, others))]
    found = [kind(scale, training, others, baseline).minimum() for scale in scales if scale.names]
    return min((one for one in found if one is not None), key=lambda one: one[0], default=(0.0, None))[1]


def _starts(training: Training, block: Block, others: Sequence[Block]) -> list[Block]:
    """Points of an effect's grid next to which another minimum may lie: where the gain has a local maximum.

    The likelihood of a ripple has many over its order, and between points of the grid most of the gain
    is lost: without them torque_ripple_40003 is 2 % off. The best other sets of nonlinear parameters are starts too.
    """
    kinds: dict[frozenset[str], list[tuple[float, Block]]] = {}
    gains, coefficients = training.gain(others)
    for one, gain, possible in zip(training.gram.blocks, gains, training.gram.possible(coefficients), strict=True):
        if possible and one.shape and one.effect is block.effect and not one.refined:
            kinds.setdefault(frozenset(one.shape), []).append((float(gain), one))
    least = LEAST_GAIN * max((gain for kind in kinds.values() for gain, _ in kind), default=0.0)
    found = [start for kind in kinds.values() for start in _local_maxima(kind, block) if start[0] > least]
    return [one for _, one in sorted(found, key=lambda start: -start[0])[:MOST_STARTS]]


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
        own = [block.shape[name] for name in names]
        at = [np.interp(value, level, np.arange(len(level))) for value, level in zip(own, levels, strict=True)]
        best &= np.any(np.abs(place - np.array(at)[:, None]) > 1, axis=0)
    return [point for point, largest in zip(points, best.tolist(), strict=True) if largest]


class Estimates(NamedTuple):
    """Numbers with intervals."""

    nominal: dict[str, Coefficient]  # of the nominal columns as fitted together with the effects, by name
    effects: tuple[dict[str, Coefficient], ...]  # of each effect, by name: coefficients, then nonlinear parameters
    not_identifiable: tuple[tuple[str, ...], ...]  # of each effect, parameters with infinite intervals


def intervals(model: FittedModel, dictionary: Dictionary) -> Estimates:
    """Intervals of the nominal model and of all effects.

    A smoothed sign, whose width was chosen, takes part where it is as evident as an effect has to be.
    """
    gram, training, active, baseline = model.gram, model.training, model.active, model.nominal
    fit, sharp = model.fit, training.fit(active, SMOOTHED)
    if occam(training.samples * np.log(sharp.rss / fit.rss), SIGN_COLUMNS) < PRIOR:
        fit = sharp
    each = [(Scale(dictionary, block), c) for block, c in zip(active, fit.of_blocks, strict=True)]
    base, free = gram.base[fit.kept], [gram.of(block) for block in active if not block.effect.follows]
    slopes = [_slopes(gram, scale, c, baseline) for scale, c in each]
    rows = np.vstack([base, *free, *slopes])
    prior = np.zeros(len(rows))
    prior[: len(base)], prior[len(base) + sum(map(len, free)) :] = gram.precision[fit.kept], PRIOR_STEPS**-2.0
    half = _jackknife(gram, rows, prior)
    names = gram.problem.nominal.names
    nominal = {name: Coefficient.around(*one) for name, *one in zip(names, fit.coefficients, half, strict=False)}
    _, *widths = np.split(half, np.cumsum([len(base), *map(len, (*free, *slopes))])[:-1])
    linear, effects, missing = iter(widths), [], []
    # A delay that is found holds the recorder's own, evenly spread over one sample.
    recorder = 0.5 * CONFIDENCE * gram.problem.data.sample_s
    for (scale, c), width in zip(each, widths[len(free) :], strict=True):
        block, unit = scale.block, scale.unit * np.where(scale.log, scale.start, 1.0)
        nonlinear, unknown = _free(scale, np.hypot(width, recorder / unit) if block.effect.recorder else width)
        labels = [one.name for one, there in zip(block.effect.coefficients, block.there, strict=False) if there]
        if block.effect.follows:
            numbers = {labels[0]: _following(block, nonlinear)}
            unknown = (*unknown, *(name for name, one in numbers.items() if not np.isfinite(one.high)))
        else:
            numbers, lost = _linear(labels, c, next(linear), block.columns)
            unknown = (*unknown, *lost)
        effects.append(numbers | nonlinear)
        missing.append(unknown)
    return Estimates(nominal=nominal, effects=tuple(effects), not_identifiable=tuple(missing))


def _following(block: Block, nonlinear: dict[str, Coefficient]) -> Coefficient:
    """A coefficient that follows from the nonlinear parameters, from one end of their intervals to the other."""
    ends = [{name: getattr(c, end) for name, c in nonlinear.items()} for end in ("low", "high")]
    value, *limits = (block.effect.coefficient_of(at) for at in (block.shape, *ends))
    known = min(limits) <= value <= max(limits)  # one over an infinite stiffness is not between them
    return Coefficient(value=value, low=min(limits) if known else -np.inf, high=max(limits) if known else np.inf)


def _linear(labels: Sequence[str], c: Float, half: Float, columns: Float) -> tuple[dict[str, Coefficient], list[str]]:
    """Coefficients, and the names of those whose error alone makes more torque than the whole effect."""
    errors, torque = half * np.sqrt(np.mean(columns**2, axis=1)), float(np.sqrt(np.mean((c @ columns) ** 2)))
    found = {name: Coefficient.around(*one) for name, *one in zip(labels, c, half, strict=True)}
    return found, [name for name, error in zip(labels, errors.tolist(), strict=True) if not error <= torque]


def _free(scale: Scale, half: Float) -> tuple[dict[str, Coefficient], tuple[str, ...]]:
    """Nonlinear parameters with their intervals, and the names of those that are not identifiable."""
    found, unknown = {n: Coefficient.around(v, 0.0) for n, v in scale.block.shape.items()}, []
    for k, name in enumerate(scale.names):
        value, reach = scale.block.shape[name], float(half[k] * scale.unit[k])
        wide = reach > WIDEST if scale.log[k] else half[k] > WIDEST_STEPS
        if wide or not np.isfinite(reach):
            unknown.append(name)
            found[name] = Coefficient.around(value, np.inf)
        elif scale.log[k]:
            found[name] = Coefficient(value=value, low=float(value * np.exp(-reach)), high=float(value * np.exp(reach)))
        else:
            found[name] = Coefficient.around(value, reach)
    return found, tuple(unknown)


def _slopes(gram: Gram, scale: Scale, coefficients: Float, baseline: Nominal) -> Float:
    """Whitened derivatives of an effect's torque with respect to its nonlinear parameters, shape (k, m)."""
    out, dictionary, block = np.empty((len(scale.names), len(gram.y))), scale.dictionary, scale.block
    for k, unit in enumerate(np.eye(len(scale.names))):
        for reach in REACHES[-1:] if block.effect.transmits else REACHES:
            ends = [scale.at(x * unit) for x in (reach, -reach)]
            torques = dictionary.torques_at(block, ends, baseline, coefficients)
            out[k] = gram.whiten(torques[0] - torques[1])[0] / (2.0 * reach)
            if out[k] @ out[k] > PRIOR_STEPS**-2.0:
                break
    return out


def _jackknife(gram: Gram, rows: Float, prior: Float) -> Float:
    """Half widths of the intervals, shape (k,).

    The variance is CV3, around the full estimate (J. G. MacKinnon, M. O. Nielsen, M. D. Webb, Journal of Econometrics
    232 (2023) 272); Student's t has the effective number of cycles (A. V. Carter, K. T. Schnepel, D. G. Steigerwald,
    Review of Economics and Statistics 99 (2017) 698).
    """
    from scipy.special import stdtrit

    cycle = gram.problem.samples.cycle[gram.order]
    order = np.argsort(cycle, kind="stable")
    ends = np.append(np.flatnonzero(np.diff(cycle[order], prepend=cycle[order][0] - 1)), len(cycle))
    scale = np.sqrt(np.maximum(np.sum(rows**2, axis=1) + prior, 1e-300))
    scaled, y, prior = rows[:, order] / scale[:, None], gram.y[order], prior / scale**2
    grams = np.stack([scaled[:, a:b] @ scaled[:, a:b].T for a, b in pairwise(ends.tolist())])
    rights = np.stack([scaled[:, a:b] @ y[a:b] for a, b in pairwise(ends.tolist())])
    inverse = np.linalg.pinv(grams.sum(axis=0) + np.diag(prior), rcond=1e-12, hermitian=True)
    spread = without_each(grams, rights, prior) - inverse @ rights.sum(axis=0)
    m = len(grams)
    # Effective number of cycles of each number: a step, or the time of a warm-up, rests on a few of them.
    parts = np.einsum("ka,gab,bk->gk", inverse, grams, inverse)
    cycles = np.sum(parts, axis=0) ** 2 / np.maximum(np.sum(parts**2, axis=0), 1e-300)
    # What the prior alone holds does not move without a cycle: its width is that of the prior.
    held = np.diag(inverse) ** 2 * prior
    variance = (m - 1) / m * np.sum(spread**2, axis=0) + held
    return np.asarray(stdtrit(np.maximum(cycles - 1.0, 1.0), 0.5 + CONFIDENCE / 2) * np.sqrt(variance) / scale)
