"""Nonlinear parameters between the points of the grid, by variable projection.

G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; the Jacobian of L. Kaufman, BIT 15 (1975) 49.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis.engine.dictionary import Block, Dictionary
from friction_audit.diagnosis.engine.gram import Training
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

STEPS = 4
HALVINGS = 3
DIFFERENCE = 0.05  # of the spacing of the grid, for finite differences
DONE = 0.2  # gain in 2 ln of the likelihood below which another step is not worth its columns


class Scale:
    """A nonlinear parameter as its logarithm where it is above zero, in units of the grid's spacing."""

    def __init__(self, dictionary: Dictionary, block: Block):
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


def refine(
    dictionary: Dictionary,
    training: Training,
    block: Block,
    others: Sequence[Block],
    baseline: Nominal,
    rebuilt: bool = False,
) -> Block | None:
    """The block at the nonlinear parameters that fit best beside others; None where they are those it has.

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
    gram = training.gram
    fit = training.fit(others)
    rows = np.vstack([gram.base[fit.kept], *(gram.of(b) for b in others)])
    basis = np.linalg.solve(fit.factor, rows / fit.scale[:, None])
    residual = gram.y - fit.projected @ basis
    n = training.samples

    def free_of(columns: Float) -> Float:
        white = gram.whiten(columns)
        return white - (white @ basis.T) @ basis

    def solve(x: Float) -> tuple[float, Float, Float, Float]:
        columns = dictionary.columns_at(block, scale.at(x), baseline)
        free = free_of(columns)
        coefficients = np.linalg.lstsq(free @ free.T, free @ residual, rcond=1e-10)[0]
        left = residual - coefficients @ free
        cost = (
            n * float(np.log(max(float(left @ left), 1e-300)))
            if block.effect.admissible(block.whole(coefficients), scale.at(x))
            else np.inf
        )
        return cost, coefficients, left, columns

    x = np.zeros(len(scale.names))
    cost, coefficients, left, columns = solve(x)
    first = cost
    if rebuilt:
        before = free_of(block.columns)
        known = residual - np.linalg.lstsq(before @ before.T, before @ residual, rcond=1e-10)[0] @ before
        first = n * float(np.log(max(float(known @ known), 1e-300)))
    for _ in range(STEPS):
        if not np.isfinite(cost):
            return None
        free = free_of(columns)
        inside = np.linalg.qr(free.T)[0]
        slopes = np.empty((len(x), len(left)))
        for k in range(len(x)):
            ahead = x.copy()
            ahead[k] += DIFFERENCE if scale.at(x + DIFFERENCE * np.eye(len(x))[k]) != scale.at(x) else -DIFFERENCE
            moved = dictionary.columns_at(block, scale.at(ahead), baseline)
            slope = coefficients @ free_of(moved - columns) / (ahead[k] - x[k])
            slopes[k] = slope - inside @ (inside.T @ slope)
        normal = slopes @ slopes.T
        damping = 1e-3 * np.diag(np.maximum(np.diag(normal), 1e-12))
        step = np.clip(np.linalg.lstsq(normal + damping, slopes @ left, rcond=1e-12)[0], -2.0, 2.0)
        for _ in range(HALVINGS):
            trial = solve(x + step)
            if trial[0] < cost:
                break
            step = step / 3.0
        else:
            break
        gained, x = cost - trial[0], x + step
        cost, coefficients, left, columns = trial
        if gained < DONE:
            break
    if first - cost < DONE:
        return None
    return Block(
        effect=block.effect,
        shape=scale.at(x),
        columns=columns,
        there=block.there,
        log_prior=block.log_prior,
        numbers=block.numbers,
        refined=True,
    )


def coefficients_beside(training: Training, others: Sequence[Block], columns: Float) -> Float:
    """Coefficients of the nominal model and nuisances fitted with some effects and more columns."""
    gram = training.gram
    kept = training.fit(others).kept
    rows = np.vstack([gram.base[kept], *(gram.of(b) for b in others), gram.whiten(columns)])
    prior = np.diag(np.append(gram.precision[kept], np.zeros(len(rows) - len(kept))))
    scale = np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))
    whole = (rows @ rows.T + prior) / scale[:, None] / scale
    return np.asarray(np.linalg.lstsq(whole, rows @ gram.y / scale, rcond=1e-11)[0] / scale)
