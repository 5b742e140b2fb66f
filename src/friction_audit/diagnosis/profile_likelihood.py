"""The number of a shape on which the misfit has many valleys: its best value, and an interval, by profile likelihood.

No derivative tells how well such a number is known. Of the values that are tried those are kept that the log does not
rule out:

    n_eff ln(RSS / RSS_best) < chi2_1 quantile at 0.95

(A. F. Venzon, S. H. Moolgavkar, A method for computing profile-likelihood-based confidence intervals, Journal of the
Royal Statistical Society C 37 (1988) 87). The ends lie at the next values tried, which the log does rule out, and
farther by what the candidate's formula assumes and nobody knows.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.declared import CONFIDENCE
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.valleys import around, valleys
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

BETWEEN = 4
"""Values that are tried once more between the neighbours of the best one."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Profiled:
    """The best shape on all rows, and the interval of its number."""

    shape: Nonlinear
    number: Coefficient


def profile_number(candidate: Effect, shape: Nonlinear, ground: Ground, baseline: Nominal, base: Float) -> Profiled:
    """Profile the rugged number, above zero, of a shape on all rows.

    Args:
        candidate: The effect.
        shape: The shape that was found.
        ground: The joint.
        baseline: What columns may lean on.
        base: All other columns of the model on the rows, shape (m, b).
    """
    from scipy.special import chdtri

    beside = Beside(base, ground.y)
    best = valleys(candidate, shape, around(shape[candidate.multimodal]), ground, baseline, beside)
    low, high = _neighbours(sorted(best), min(best, key=lambda value: best[value][0]))
    best |= valleys(candidate, shape, np.geomspace(low, high, BETWEEN + 2)[1:-1].tolist(), ground, baseline, beside)
    value = min(best, key=lambda value: best[value][0])
    worth = len(ground.y) / ground.memory(
        base, ground.rows.of(candidate.regressor(ground.data, baseline, best[value][1]))
    )
    least = best[value][0] * float(np.exp(chdtri(1, 1.0 - CONFIDENCE) / worth))
    every = sorted(best)
    kept = [k for k, tried in enumerate(every) if best[tried][0] <= least]
    low, high = every[max(kept[0] - 1, 0)], every[min(kept[-1] + 1, len(every) - 1)]
    blur = candidate.systematic_error(baseline, best[value][1])
    return Profiled(shape=best[value][1], number=Coefficient(value=value, low=max(low - blur, 0.0), high=high + blur))


def _neighbours(every: Sequence[float], value: float) -> tuple[float, float]:
    """The neighbours of a value."""
    at = every.index(value)
    return every[max(at - 1, 0)], every[min(at + 1, len(every) - 1)]
