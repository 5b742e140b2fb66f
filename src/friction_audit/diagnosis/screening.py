"""Is anything missing: wild cluster bootstrap of the largest studentised score.

A. C. Cameron, J. B. Gelbach, D. L. Miller, Review of Economics and Statistics 90 (2008) 414, with the null imposed and
Rademacher weights per cycle; the maximum over all columns controls the family-wise error (J. P. Romano, M. Wolf,
Econometrica 73 (2005) 1237).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.gram import COPY, Fit, Gram, Training
from friction_audit.diagnosis.problem import Index
from friction_audit.joint_log import Float

DRAWS = 399


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Screening:
    """Outcome of the test.

    Attributes:
        p_value: That nothing is missing.
        curves: The same of a curve over each quantity, adjusted for all, by name of the quantity.
    """

    p_value: float
    curves: dict[str, float]


def wild_cluster_bootstrap(gram: Gram, active: Sequence[Block], seed: int) -> Screening:
    """Test the model with some effects against all other columns and curves.

    Args:
        gram: Whitened columns.
        active: Effects in the model.
        seed: Of the draws.
    """
    training = Training(gram)
    fit = training.fit(active)
    rows = np.vstack([gram.base[fit.kept], *(gram.of(b) for b in active)])
    basis = np.asarray(np.linalg.solve(fit.factor, rows / fit.scale[:, None]), np.float64)
    left = gram.y - fit.projected @ basis
    cycle = gram.problem.samples.cycle[gram.order]
    starts = np.flatnonzero(np.diff(cycle, prepend=cycle[0] - 1))
    own = np.add.reduceat(basis * left, starts, axis=1)
    of_blocks, free = _by_cycle_of_blocks(training, active, fit, left, starts, own)
    names, parts = [], [of_blocks[free]]
    for curve in gram.problem.curves:
        white = gram.whiten(curve.columns)
        parts.append(np.add.reduceat(white * left, starts, axis=1) - (white @ basis.T) @ own)
        names += [curve.axis.name] * len(curve.columns)
    scores = np.vstack(parts)
    norm = np.sqrt(np.maximum(np.sum(scores**2, axis=1), 1e-300))
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], (scores.shape[1], DRAWS))
    drawn, seen = np.abs(scores @ sign) / norm[:, None], np.abs(scores.sum(axis=1)) / norm
    largest = drawn.max(axis=0)

    def p_of(value: float) -> float:
        return float((1 + np.count_nonzero(largest >= value)) / (DRAWS + 1))

    of_curves = seen[np.count_nonzero(free) :]
    curves = {
        name: p_of(float(max(of_curves[k] for k, n in enumerate(names) if n == name))) for name in dict.fromkeys(names)
    }
    return Screening(p_value=p_of(float(seen.max())), curves=curves)


def _by_cycle_of_blocks(
    training: Training, active: Sequence[Block], fit: Fit, left: Float, starts: Index, own: Float
) -> tuple[Float, NDArray[np.bool_]]:
    """Score of each column of the blocks in each cycle, the model partialled out; which columns are no copy of it.

    Args:
        training: Of all folds.
        active: Effects in the model.
        fit: Of the model.
        left: Its whitened residual, shape (m,).
        starts: First sample of each cycle, shape (c,).
        own: Scores of the model's orthonormal columns, shape (b, c).
    """
    gram = training.gram
    back = gram.transposed(left)[0]
    scores = [np.add.reduceat(rows * back, starts, axis=1) for _, rows in gram.chunks(gram.blocks)]
    along = np.linalg.solve(fit.factor, training.cross(active, fit))
    size = np.concatenate([np.diagonal(one.sum(axis=0)) for one in gram.own])
    return np.vstack(scores) - along.T @ own, size - np.sum(along**2, axis=0) > COPY * size
