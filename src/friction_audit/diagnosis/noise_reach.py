"""How far noise of the motion may have moved a number of a shape: as much noise again moves it on, and tells.

A far side on a spring rings with the noise of the position too, which no torque holds. Least squares make that small by
more damping and a softer spring, however many samples there are: no interval from the scatter of cycles knows of it.
How much it is, a fit to the motion with as much noise again shows (simulation and extrapolation: J. R. Cook, L. A.
Stefanski, Journal of the American Statistical Association 89 (1994) 1314). It is not in proportion to the noise, so
that nothing is taken off the value: the interval reaches as far on the other side.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.motion_noise import noisier
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

SEED = 0
"""The same log has the same interval."""
EVALUATIONS = 40
FIRST_STEP = 0.1
CLOSE = 2e-3
"""Of the corners of the simplex, in the logarithms of the numbers."""
SETTLED = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class Reach:
    """By what factors a number may be larger than was found, the smallest and the largest."""

    low: float
    high: float

    def widen(self, number: Coefficient, power: int = 1) -> Coefficient:
        """Let the interval of a number above zero, or of a power of the one that was moved, reach as far."""
        ends = (number.value * self.low**power, number.value * self.high**power)
        return replace(number, low=min(number.low, *ends), high=max(number.high, *ends))


def reach_of_noise(found: Found, ground: Ground, baseline: Nominal, others: Float) -> Reach:
    """Fit the shape once more on all rows, and once with as much noise of the motion again.

    Args:
        found: The effect, whose candidate names the number that noise moves.
        ground: The joint.
        baseline: What columns may lean on.
        others: All other columns of the model on the rows, shape (m, b).
    """
    name, *along = found.candidate.noise_biased
    free = (name, *(free for free in along if free not in found.shape or found.shape[free] > 0.0))
    shape = found.candidate.with_assumed(found.shape)
    noisy = replace(ground, data=noisier(ground.data, np.random.default_rng(SEED)))
    best = _fitted(shape, free, found, ground, baseline, others)
    moved = _fitted({**shape, **best}, free, found, noisy, baseline, others)
    here = best[name] / found.shape[name]
    factors = (1.0, here, here * best[name] / moved[name])
    return Reach(low=min(factors), high=max(factors))


def _fitted(
    shape: Nonlinear, free: Sequence[str], found: Found, ground: Ground, baseline: Nominal, others: Float
) -> dict[str, float]:
    """The free numbers, above zero, that leave least (Nelder and Mead 1965)."""
    from scipy.optimize import minimize

    beside, begin = Beside(others, ground.y), np.log([shape[name] for name in free])

    def numbers(x: Float) -> dict[str, float]:
        return dict(zip(free, np.exp(x).tolist(), strict=True))

    def cost(x: Float) -> float:
        one = {**shape, **numbers(x)}
        factors, left = beside.fit(ground.rows.of(found.candidate.regressor(ground.data, baseline, one)))
        return left if found.candidate.admissible(factors, one) else beside.without

    found_at = minimize(
        cost,
        begin,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.vstack([begin, begin + FIRST_STEP * np.eye(len(free))]),
            "maxfev": EVALUATIONS,
            "xatol": CLOSE,
            "fatol": SETTLED * beside.without,
        },
    )
    return numbers(found_at.x)
