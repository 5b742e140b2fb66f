"""Whether a log holds the motion that separates a hidden effect from the effects that compete with it.

The torque that the effect adds, on ideal sensors and at the samples of real ones, free of the nominal model and of the
best form of another effect, is what separates the two. Over the noise it is the noncentrality of the sharpest test:

    lambda = n_eff |what the other leaves|^2 / (m sigma^2),    m samples that hold as much as n_eff independent ones

Columns are those of the catalogue; the price of the test and the rest of the measure are its own.
"""

from dataclasses import replace
from heapq import nsmallest
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import chi2, ncx2

from benchmarks.hidden_effects.draw import Case, model_of, settings_of
from benchmarks.hidden_effects.limits import SampledJoint, integral_time, same_times, samples_of
from benchmarks.hidden_effects.strength import prepared
from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import least_squares as linear_fit
from friction_audit.effects.registry import effects, same_as
from friction_audit.effects.slow import ContactEvent
from friction_audit.joint_log import Float
from friction_audit.simulation.scenarios import simulate

POWER, WRONG_NAME = 0.9, 0.01  # of the test that rejects a competing effect, all of them together
ALIKE = 0.7  # correlation from which two effects compete
NEARLY_ALIKE = 0.5  # correlation on the grid from which nonlinear parameters are fitted between its points
STARTS = 3  # the misfit over the gap of a backlash has many valleys
EVALUATIONS = 12


class Competing(NamedTuple):
    """Another effect in the place of the truth: correlation of the torques (0..1), noncentrality of the test."""

    name: str
    correlation: float
    noncentrality: float


class Separation(NamedTuple):
    """All other effects that a log can show; how many numbers the truth takes, 0 where the log cannot show it."""

    competing: tuple[Competing, ...]
    numbers: int

    @property
    def close(self) -> tuple[str, ...]:
        """Names that the log does not separate from the truth."""
        alike = [one for one in self.competing if one.correlation > ALIKE]
        needed = noncentrality_for(max(self.numbers, 1), len(alike))
        return tuple(one.name for one in alike if one.noncentrality < needed)

    @property
    def separates(self) -> bool:
        """Whether the log shows the truth, and nothing else would do."""
        return self.numbers > 0 and not self.close


def noncentrality_for(numbers: int, competing: int) -> float:
    """Noncentrality with which chi squared of so many degrees of freedom is above the test's price at its power."""
    price = float(chi2.isf(WRONG_NAME / max(competing, 1), numbers))
    return float(brentq(lambda size: ncx2.sf(price, numbers, size) - POWER, 1e-3, 10.0 * price + 100.0))


def separate(case: Case) -> Separation:
    """How well the log of a case with one effect, its strength already scaled, separates it."""
    clean, _ = _both(case, 0.0)
    hidden, noisy = _both(case, 1.0)
    problem = _Free(hidden, case.effects[0])
    own = problem.blocks.get(case.effects[0])
    if not own:
        return Separation(competing=(), numbers=0)
    here, there = same_times(noisy.rows, hidden.rows)
    torque = np.zeros(len(noisy.rows.t))
    torque[here] = hidden.residual()[there]
    noise = noisy.residual(torque)
    n_eff = len(hidden.rows.t) / integral_time(noise, noisy.rows)
    floor, whole = _square(clean.residual()), _square(problem.y)
    found = []
    for name, blocks in problem.blocks.items():
        left = float(np.clip(problem.least(blocks) - floor, 0.0, whole - floor))
        alike = float(np.sqrt(1.0 - left / (whole - floor)))
        if name != case.effects[0]:
            found.append(Competing(name=name, correlation=alike, noncentrality=n_eff * left / _square(noise)))
    best = min(own, key=problem.left)
    return Separation(competing=tuple(found), numbers=best.p + best.numbers)


def _square(signal: Float) -> float:
    return float(np.mean(signal**2))


def _both(case: Case, scale: float) -> tuple[SampledJoint, SampledJoint]:
    """The joint on ideal sensors below the corner that noisy ones allow, and on those.

    Where an encoder's noise hides the direction, as next to a reversal, no test sees anything.
    """
    joint, model = case.number - 1, model_of(case)
    stated = None if model is None else model.joints[joint]
    noisy, ideal = (
        prepared(simulate(settings_of(case, (scale,), ideal=ideal), case.seed).log)[joint] for ideal in (False, True)
    )
    seen = samples_of(noisy, stated)
    at = np.clip(np.rint((ideal.t - noisy.t[0]) / noisy.step_s).astype(int), 0, len(noisy.t) - 1)
    ideal = replace(ideal, moving=ideal.moving & noisy.moving[at])
    return samples_of(ideal, stated, seen.rows.corner_hz), seen


class _Free:
    """Least squares of effects free of the nominal model."""

    def __init__(self, samples: SampledJoint, truth: str) -> None:
        asked = [one for one in effects() if one.name not in {ContactEvent.name, *same_as(truth)} - {truth}]
        nominal, zeros = samples.nominal, np.zeros(len(samples.rows.t), np.int64)
        problem = RegressionProblem(
            data=samples.data, samples=samples.rows, nominal=nominal, age=zeros, fold=zeros, curves=()
        )
        self.y, self.basis = samples.residual(), np.linalg.qr(nominal.columns)[0]
        self.baseline = nominal.baseline(linear_fit(nominal.columns.T, nominal.y))
        self.dictionary = Dictionary.build(problem, asked, self.baseline)
        self.blocks: dict[str, list[Block]] = {}
        for block in [*self.dictionary.blocks, *self.dictionary.scan_orders(self.y)]:
            self.blocks.setdefault(block.name, []).append(block)

    def residual(self, block: Block, columns: Float) -> Float:
        """What columns (p, m) of an effect leave; all of it where their coefficients are impossible."""
        free = columns - (columns @ self.basis) @ self.basis.T
        size = np.sqrt(np.mean(free**2, axis=1))
        scale = np.where(size > 0, 1.0 / np.where(size > 0, size, 1.0), 0.0)
        free *= scale[:, None]
        found = np.linalg.lstsq(free @ free.T, free @ self.y, rcond=1e-10)[0]
        return self.y - found @ free if block.possible(found * scale) else self.y

    def left(self, block: Block) -> float:
        """Mean square that a point of the grid leaves."""
        return _square(self.residual(block, block.columns))

    def least(self, blocks: list[Block]) -> float:
        """Mean square that the best possible form of an effect leaves, between the points of its grid too."""
        fits = list(map(self.left, blocks))
        if min(fits) > (1.0 - NEARLY_ALIKE**2) * _square(self.y):
            return min(fits)
        starts = nsmallest(STARTS, range(len(fits)), fits.__getitem__)
        return min([min(fits), *(self.fitted(blocks[k]) for k in starts)])

    def fitted(self, block: Block) -> float:
        """Variable projection from a point of the grid (scipy.optimize.least_squares)."""
        bounds = {k: v for k, v in self.dictionary.bounds(block).items() if v[0] < v[1]}
        if not bounds:
            return self.left(block)

        def residual(x: Float) -> Float:
            shape = {**block.shape, **dict(zip(bounds, x.tolist(), strict=True))}
            return self.residual(block, self.dictionary.columns_at(block, shape, self.baseline))

        low, high = np.array(list(bounds.values())).T
        start = np.clip([block.shape[name] for name in bounds], low, high)
        scale = np.maximum([self.dictionary.spacing(block, name) for name in bounds], 1e-9)
        step = np.full(len(start), 1e-3)
        found = least_squares(residual, start, bounds=(low, high), x_scale=scale, max_nfev=EVALUATIONS, diff_step=step)
        return _square(found.fun)
