"""Intervals of factors where the log does not tell the shape they belong to: over all shapes that it does not rule out.

No derivative tells how a factor changes along a number that the log leaves open. So the shapes of the grid are tried,
then those halfway from one that is kept to the next, and those are kept that the log does not rule out:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

(A. F. Venzon, S. H. Moolgavkar, A method for computing profile-likelihood-based confidence intervals, Journal of the
Royal Statistical Society C 37 (1988) 87).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.declared import CONFIDENCE, coefficients
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

NEXT = 4.0
"""Of the threshold, what a shape may lack whose way to one that is kept is halved: twice as far along a parabola."""


def over_kept_shapes(
    ground: Ground, found: Sequence[Found], k: int, baseline: Nominal, linear: Sequence[Coefficient]
) -> tuple[Coefficient, ...]:
    """Let all factors' intervals reach over those that they have with each shape that is kept.

    Args:
        ground: The joint.
        found: The effects.
        k: Which of them has a shape that the log does not tell.
        baseline: What columns may lean on.
        linear: Factors of the declared model and of all effects, with the shapes that were found.
    """
    before = np.hstack([ground.base, *(f.columns for f in found[:k])])
    behind = np.hstack([np.zeros((len(ground.y), 0)), *(f.columns for f in found[k + 1 :])])
    reached = tuple(linear)
    for own in _kept(ground, found[k], baseline, np.hstack([before, behind])):
        factors = coefficients(np.hstack([before, own, behind]), ground.y, ground.rows.cycle)
        reached = tuple(map(_over_both, reached, factors))
    return reached


def _over_both(one: Coefficient, other: Coefficient) -> Coefficient:
    return Coefficient(value=one.value, low=min(one.low, other.low), high=max(one.high, other.high))


def _kept(ground: Ground, found: Found, baseline: Nominal, others: Float) -> list[Float]:
    """Columns of the shapes that the log does not rule out, shape (m, p) each."""
    from scipy.special import chdtri

    beside = Beside(others, ground.y)
    alike = [shape for shape in found.candidate.grid(ground.data) if shape.keys() == found.shape.keys()]
    shapes = [found.shape, *alike]
    tried = [_tried(ground, found, baseline, beside, shape) for shape in shapes]
    most = float(chdtri(1, 1.0 - CONFIDENCE)) * ground.memory(others, found.columns) / len(ground.y)
    lacks = np.log([left for _, left in tried]) - np.log(min(left for _, left in tried))
    near = [shapes[i] for i in np.flatnonzero((lacks > most) & (lacks <= NEXT * most))]
    whole = [p.name for p in found.candidate.nonlinear if p.whole]
    kept = [shapes[i] for i in np.flatnonzero(lacks <= most)]
    between = [
        _halfway(one, other) | {name: one[name] for name in whole if name in one} for one in kept for other in near
    ]
    tried += [_tried(ground, found, baseline, beside, shape) for shape in between]
    least = min(left for _, left in tried) * np.exp(most)
    return [columns for columns, left in tried if left <= least]


def _tried(ground: Ground, found: Found, baseline: Nominal, beside: Beside, shape: Nonlinear) -> tuple[Float, float]:
    """Columns of a shape, and what they leave; of one that is not possible, everything."""
    columns = ground.rows.of(found.candidate.regressor(ground.data, baseline, shape))
    factors, left = beside.fit(columns)
    return columns, left if found.candidate.admissible(factors, shape) else beside.without


def _halfway(one: Nonlinear, other: Nonlinear) -> dict[str, float]:
    """The shape between two, by ratio where both are above zero."""
    return {
        name: float(np.sqrt(a * b)) if (a := one[name]) > 0.0 and (b := other[name]) > 0.0 else (a + other[name]) / 2.0
        for name in one
    }
