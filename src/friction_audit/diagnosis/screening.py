"""Is anything missing: wild cluster bootstrap of the largest studentised score.

A. C. Cameron, J. B. Gelbach, D. L. Miller, Review of Economics and Statistics 90 (2008) 414, with the null imposed and
Rademacher weights per cycle; the maximum over all columns controls the family-wise error (J. P. Romano, M. Wolf,
Econometrica 73 (2005) 1237).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.gram import Gram, Training
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
    fit = Training(gram).fit(active)
    rows = np.vstack([gram.base[fit.kept], *(gram.of(b) for b in active)])
    basis = np.asarray(np.linalg.solve(fit.factor, rows / fit.scale[:, None]), np.float64)
    left = gram.y - fit.projected @ basis
    names, parts = [], [gram.rows[: gram.used]]
    for curve in gram.problem.curves:
        parts.append(gram.whiten(curve.columns))
        names += [curve.axis.name] * len(curve.columns)
    place = np.unique(gram.problem.samples.cycle[gram.order], return_inverse=True)[1].astype(np.int64)
    scores = np.vstack([_by_cycle(part, basis, left, place) for part in parts])
    norm = np.sqrt(np.maximum(np.sum(scores**2, axis=1), 1e-300))
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], (scores.shape[1], DRAWS))
    drawn, seen = np.abs(scores @ sign) / norm[:, None], np.abs(scores.sum(axis=1)) / norm
    largest = drawn.max(axis=0)

    def p_of(value: float) -> float:
        return float((1 + np.count_nonzero(largest >= value)) / (DRAWS + 1))

    own = seen[gram.used :]
    curves = {name: p_of(float(max(own[k] for k, n in enumerate(names) if n == name))) for name in dict.fromkeys(names)}
    return Screening(p_value=p_of(float(seen.max())), curves=curves)


def _by_cycle(columns: Float, basis: Float, left: Float, place: Index) -> Float:
    """Score of each column in each cycle, the model partialled out, shape (k, c)."""
    cycles = int(place.max()) + 1
    weighted = np.stack([left * (place == c) for c in range(cycles)])
    free = weighted - (weighted @ basis.T) @ basis
    return np.asarray(columns @ free.T)
