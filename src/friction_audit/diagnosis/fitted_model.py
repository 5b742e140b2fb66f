"""The nominal model with some effects: fitted to all samples, held-out folds predicted, the test of what is missing.

The test is a wild cluster bootstrap of the largest studentised score: A. C. Cameron, J. B. Gelbach, D. L. Miller,
Review of Economics and Statistics 90 (2008) 414, with the null imposed and Rademacher weights per cycle; the maximum
over all columns controls the family-wise error (J. P. Romano, M. Wolf, Econometrica 73 (2005) 1237).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.gram import COPY, RIDGE, Gram, Training
from friction_audit.diagnosis.result import Gap
from friction_audit.diagnosis.samples import least_squares, without_each
from friction_audit.diagnosis.selection import Projected
from friction_audit.effects.joint_data import Nominal
from friction_audit.effects.registry import GRAVITY
from friction_audit.joint_log import Float, Int

DRAWS = 399  # of the bootstrap
ROUNDING = 1e-12  # of a root mean square that was added up in another order
SLIGHT = 1e-3  # ridge for curves over quantities that may be copies of each other


class FittedModel:
    """The model fitted to all samples, m of them, with k effects."""

    def __init__(self, training: Training, active: Sequence[Block]) -> None:
        self.training, self.active = training, active
        self.gram, self.problem = training.gram, training.gram.problem
        self.fit = training.fit(active)
        self.coefficients = self.fit.of_blocks
        self._known = self.gram.base_raw[self.gram.precision == 0.0]  # the nominal model, and an offset that may be any

    @cached_property
    def nominal(self) -> Nominal:
        """The nominal model as fitted together with the effects."""
        return self.problem.nominal.baseline(self.fit.coefficients[: len(self.problem.X)])

    @cached_property
    def torques(self) -> list[Float]:
        """Torque of each effect on the samples, shape (m,). [N m]"""
        return [c @ block.columns for block, c in zip(self.active, self.coefficients, strict=True)]

    @cached_property
    def sizes(self) -> Float:
        """Rms of each effect's torque free of the nominal model, and of an offset that may be any, shape (k,). [N m]"""
        return np.array([_rms_without(self._known, torque) for torque in self.torques])

    @cached_property
    def residual(self) -> Float:
        """What the model leaves of all samples, in the order of time, shape (m,). [N m]"""
        kept = self.fit.kept
        base = self.fit.coefficients[: len(kept)] @ self.gram.base_raw[kept]
        return np.asarray(self.problem.y - base - sum(self.torques))

    @cached_property
    def fine_residual(self) -> Float:
        """What the model leaves on the fine grid, shape (n,). [N m]"""
        data, left = self.problem.data, self.problem.data.torque - self.nominal.torque
        for block, c in zip(self.active, self.coefficients, strict=True):
            left -= block.effect.regressor(data, self.nominal, block.shape)[:, block.there] @ c
        return left

    @cached_property
    def inflations(self) -> Float:
        """Variance inflation factor of each effect's size by the nuisances and the other effects, shape (k,)."""
        fit, gram = self.fit, self.gram
        whole = (fit.factor @ fit.factor.T) * np.outer(fit.scale, fit.scale)
        known, rows, found = np.flatnonzero(gram.precision[fit.kept] == 0.0), np.arange(len(whole)), []
        owner = np.repeat(np.arange(-1, len(self.active)), [len(fit.kept), *(b.p for b in self.active)])
        for k, coefficients in enumerate(self.coefficients):
            own, others = rows[owner == k], rows[owner != k]
            cross = whole[:, own] @ coefficients
            free = [
                cross[own] @ coefficients - cross[one] @ np.linalg.solve(whole[np.ix_(one, one)], cross[one])
                for one in (known, others)
            ]
            found.append(free[0] / max(free[1], RIDGE * free[0]))
        return np.array(found)

    def whole(self, dictionary: Dictionary) -> tuple[list[Float], Float]:
        """Torque of each effect, shape (m,), and its size, shape (k,), with what an unknown chain may take. [N m]

        Of the chain's own effects only what it does not take is known: the rest of their coefficients is a guess.
        """
        torques, size = [*self.torques], self.sizes.copy()
        for k, (block, c) in enumerate(zip(self.active, self.coefficients, strict=True)):
            if (whole := self._with_chain(dictionary, block, c)) is not None:
                torques[k], size[k] = whole
        return torques, size

    def taken_by_chain(self, dictionary: Dictionary) -> float:
        """Largest ratio of an effect's rms to what an unknown chain leaves of it, at a point of each; 1 without one."""
        points: dict[str, list[Block]] = {}
        for block in self.gram.blocks if self.problem.with_chain else ():
            points.setdefault(block.name, []).append(block)
        ratios: list[float] = []
        for block in (own[len(own) // 2] for own in points.values()):
            c = np.ones(block.p)
            whole, left = self._with_chain(dictionary, block, c), _rms_without(self._known, c @ block.columns)
            ratios += [whole[1] / left] if whole is not None and left > 0.0 else []
        return max(ratios, default=1.0)

    def _with_chain(self, dictionary: Dictionary, block: Block, c: Float) -> tuple[Float, float] | None:
        """Torque of an effect, what a chain could take in it, and its rms free of the nominal model; None without one.

        None for the chain's own effects.
        """
        problem = self.problem.with_chain
        if problem is None or block.effect.axis == "neighbour" or block.name == GRAVITY:
            return None
        known = np.vstack([problem.X, problem.columns(np.ones((len(problem.data.t), 1)))])
        torque = c @ replace(dictionary, problem=problem).columns_at(block, block.shape, self.nominal)
        return torque, _rms_without(known, torque)


def _rms_without(known: Float, torque: Float) -> float:
    return float(np.sqrt(np.mean((torque - least_squares(known, torque) @ known) ** 2)))


class HeldOut(NamedTuple):
    """What is left of each sample, predicted by the folds that it is not in."""

    residual: Float  # in the order of time, shape (m,) [N m]
    innovation: Float  # of each sample likewise
    rms: float  # root mean square of the residual [N m]


def held_out(
    gram: Gram, active: Sequence[Block], extra: Float | None = None, replaced: Sequence[Block] = ()
) -> HeldOut:
    """Predict every fold from the others, with some effects and more columns, shape (k, m), those with a slight ridge.

    The nuisances of effects that are replaced are left out as well: what stands for an effect must not hide it.
    """
    kept = Training(gram).fit(active, [b.name for b in replaced]).kept
    more = np.empty((0, len(gram.y))) if extra is None else extra
    added, free = gram.whiten(more), np.zeros(sum(b.p for b in active))
    raw = np.vstack([gram.base_raw[kept][:, gram.order], *(b.stored for b in active), more[:, gram.order]])
    white = np.vstack([gram.base[kept], *(gram.of(b) for b in active), added])
    prior = np.concatenate([gram.precision[kept], free, SLIGHT * np.sum(added**2, axis=1)])
    grams = np.stack([white[:, f] @ white[:, f].T for f in gram.slices])
    coefficients = without_each(grams, np.stack([white[:, f] @ gram.y[f] for f in gram.slices]), prior)
    out = np.empty((2, len(gram.y)))
    for row, y, rows in ((0, gram.problem.y[gram.order], raw), (1, gram.y, white)):
        every = zip(coefficients, gram.slices, strict=True)
        out[row, gram.order] = np.concatenate([y[fold] - own @ rows[:, fold] for own, fold in every])
    return HeldOut(residual=out[0], innovation=out[1], rms=float(np.sqrt(np.mean(out[0] ** 2))))


class Gain(NamedTuple):
    """What an effect gains on cycles that its coefficients were not fitted on."""

    z: float  # slope of what is left without the effect on what it predicts, in cluster-robust standard errors
    p_value: float  # one-sided
    shrinks: bool  # whether the residual in torque shrinks too


def gains(gram: Gram, active: Sequence[Block]) -> list[Gain]:
    """Of each effect given the others, p-values by Holm.

    What an effect lives on may be few of the cycles: the slope of a calibration regression (J. A. Mincer, V. Zarnowitz,
    in Economic Forecasts and Expectations, NBER 1969) does not mind, a mean over cycles would.
    """
    from scipy.special import stdtr

    if not active:
        return []
    whole, place = held_out(gram, active), np.unique(gram.problem.samples.cycle, return_inverse=True)[1]
    m, found = int(place.max()) + 1, []
    for block in active:
        without = held_out(gram, [b for b in active if b is not block], replaced=active)
        predicted = without.innovation - whole.innovation
        size = max(float(predicted @ predicted), 1e-300)
        slope = float(predicted @ without.innovation) / size
        by_cycle = np.bincount(place, predicted * (without.innovation - slope * predicted))
        z = slope * size / max(float(np.sqrt(np.sum(by_cycle**2) * m / max(m - 1, 1))), 1e-300)
        found.append((z, float(stdtr(m - 1, -z)), without.rms > whole.rms))
    # As multipletests of statsmodels, which loads pandas in every process and collects garbage: half a second each.
    p_values = np.array([p for _, p, _ in found])
    order = np.argsort(p_values)
    adjusted = np.maximum.accumulate(p_values[order] * np.arange(len(order), 0, -1))[np.argsort(order)]
    return [Gain(z=z, p_value=min(float(p), 1.0), shrinks=s) for (z, _, s), p in zip(found, adjusted, strict=True)]


def gap(gram: Gram, active: Sequence[Block]) -> tuple[Gap, HeldOut, HeldOut]:
    """The gap in torque, and what the nominal and the augmented model leave.

    The noise is the held-out rms of the best of the plain model, that with a curve over one quantity, that with all.
    """
    before, after = held_out(gram, (), replaced=active), held_out(gram, active)
    columns = [c.columns for c in gram.problem.curves]
    tried = [np.vstack(columns), *columns] if columns else []
    floor = min([after.rms, *(held_out(gram, active, one).rms for one in tried)])
    return measure_gap(before.residual, after.residual, floor, gram.problem.samples.cycle), before, after


def measure_gap(before: Float, after: Float, floor: float, cycle: Int) -> Gap:
    """Compare residuals of both models on held-out cycles, shape (n,), each sample counting once.

    The standard error is by leaving out one cycle at a time (jackknife over cycles); NaN for a single cycle.
    """
    number = np.unique(cycle, return_inverse=True)[1]
    samples = np.bincount(number).astype(float)
    sums = np.stack([np.bincount(number, weights=r**2) for r in (before, after)])
    total, m = sums.sum(axis=1), len(samples)
    whole = np.sqrt(total / samples.sum())
    rest = np.sqrt((total[:, None] - sums) / np.maximum(samples.sum() - samples, 1.0))
    return Gap(
        before=float(whole[0]),
        after=float(whole[1]),
        floor=floor,
        shrink=float(_shrink(whole[0], whole[1], floor)),
        shrink_se=float(np.sqrt((m - 1) * np.var(_shrink(rest[0], rest[1], floor)))) if m > 1 else float("nan"),
        over_floor=float(whole[1] / floor) if floor > 0 else float("inf"),
        cycles=m,
    )


def _shrink(before: Float, after: Float, floor: float) -> Float:
    """Share explained of the residual above the noise floor; NaN where there is none."""
    open_gap = np.asarray(before) - floor
    wide = open_gap > ROUNDING * np.asarray(before)
    return np.where(wide, (before - after) / np.where(wide, open_gap, 1.0), np.nan)


class Screening(NamedTuple):
    """Outcome of the test."""

    p_value: float  # that nothing is missing
    curves: dict[str, float]  # the same of a curve over each quantity, adjusted for all, by name of the quantity


def wild_cluster_bootstrap(gram: Gram, active: Sequence[Block], seed: int) -> Screening:
    """Test the model with some effects against all other columns and curves."""
    training = Training(gram)
    given = Projected(training, active)
    basis, left = given.basis, given.left
    cycle = gram.problem.samples.cycle[gram.order]
    starts = np.flatnonzero(np.diff(cycle, prepend=cycle[0] - 1))
    own = np.add.reduceat(basis * left, starts, axis=1)
    # Of the blocks the same in parts, without a whitened copy; of copies of the model nothing is left.
    fit, back = training.fit(active), gram.sorted_noise.transposed(left)[0]
    of_blocks = [np.add.reduceat(rows * back, starts, axis=1) for _, rows in gram.chunks(gram.blocks)]
    along = np.linalg.solve(fit.factor, training.cross(active, fit))
    squares = np.empty(gram.used)
    for p, products in gram.own.items():
        squares[gram.starts[gram.widths == p][:, None] + np.arange(p)] = np.einsum("fupp->up", products)
    free = (1.0 - COPY) * squares > np.sum(along**2, axis=0)
    names, parts = [], [(np.vstack(of_blocks) - along.T @ own)[free]]
    for curve in gram.problem.curves:
        white = gram.whiten(curve.columns)
        parts.append(np.add.reduceat(white * left, starts, axis=1) - (white @ basis.T) @ own)
        names += [curve.axis.name] * len(curve.columns)
    scores = np.vstack(parts)
    norm = np.sqrt(np.maximum(np.sum(scores**2, axis=1), 1e-300))
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], (scores.shape[1], DRAWS))
    drawn, seen = np.abs(scores @ sign) / norm[:, None], np.abs(scores.sum(axis=1)) / norm
    largest = drawn.max(axis=0)

    of_curves = seen[np.count_nonzero(free) :]
    highest = {name: max(of_curves[k] for k, n in enumerate(names) if n == name) for name in dict.fromkeys(names)}
    highest["all"] = seen.max()
    p_values = {name: (1 + int(np.count_nonzero(largest >= value))) / (DRAWS + 1) for name, value in highest.items()}
    return Screening(p_value=p_values.pop("all"), curves=p_values)
