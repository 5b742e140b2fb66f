"""A play or a spring together with the declared model's inertia and friction, which are behind it.

When flanks strike and how a spring rings depends on how fast the far side flew, and so on its friction and inertia to a
per cent. Fitted by turns, the transmission beside these as they are and these beside it as it is, neither finds its
way: what is wrong with the one is taken by the other. So all numbers are looked for at once, and the torque of the
declared model is that of the very numbers with which the transmission was computed. The misfit has many valleys along
each of them: differential evolution (R. Storn, K. Price, Journal of Global Optimization 11 (1997) 341) needs neither a
slope nor a single valley.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.sought import Sought, seek
from friction_audit.dynamics.transmission import LANES, FarSide
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float


class Effort(NamedTuple):
    """How far a search goes, and how long.

    Attributes:
        everywhere: Whether hidden shapes are looked for, and not what is near one of the grid.
        many: Tried in each generation: transmissions are followed side by side; with fewer, the valley is often not the
            lowest.
        generations: How many.
    """

    everywhere: bool
    many: int
    generations: int


NEARBY = Effort(everywhere=False, many=3 * LANES, generations=50)
EVERYWHERE = Effort(everywhere=True, many=6 * LANES, generations=60)
"""Of plays of 8 and 16 mrad half as many in fewer generations missed one; twice as many find no more."""
MUTATION = (0.4, 0.9)
WHOLE = 1.0
"""Of the numbers that change at a time: stiffer flanks go along with a wider play, and inertia with friction."""
SEED = 0
"""The same log has the same answer."""

Behind = Callable[[JointData, Sequence[FarSide], Sequence[Nonlinear]], Iterator[tuple[int, Float]]]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Fitted:
    """A shape, its columns on the rows, shape (m, p), and the declared model that it was fitted with."""

    shape: Nonlinear
    columns: Float
    baseline: Nominal


def fit_jointly(
    candidate: Effect, shape: Nonlinear, columns: Float, ground: Ground, others: Float, effort: Effort = NEARBY
) -> Fitted | None:
    """Find the shape and the declared model that leave least on the working rows; None if none leave less.

    Args:
        candidate: The effect; None is the answer too if nothing of the declared model is behind it.
        shape: One of its shapes, not far from the right one.
        columns: Those of this shape on the rows, shape (m, p).
        ground: The joint.
        others: All other effects in the model, shape (m, e).
        effort: How far it is looked for, and how long.
    """
    if not candidate.transmits:
        return None
    sought = seek(candidate, shape, ground, ground.baseline(others, columns), everywhere=effort.everywhere)
    numbers = _evolved(sought, _misfits(sought, candidate.transmitted, ground, others), effort)
    fitted = _fitted(sought, numbers, candidate, candidate.transmitted, ground, others)
    w = ground.working
    beside = Beside(np.hstack([ground.base, others])[w], ground.y[w])
    return fitted if beside.fit(fitted.columns[w])[1] < beside.fit(columns[w])[1] else None


def _evolved(sought: Sought, misfits: Callable[[Float], Float], effort: Effort) -> Float:
    """The best numbers of many generations, the first one spread over all that is allowed, shape (k,)."""
    from scipy.optimize import Bounds, differential_evolution
    from scipy.stats import qmc

    spread = qmc.LatinHypercube(len(sought.low), rng=np.random.default_rng(SEED)).random(effort.many)
    first = sought.low + (sought.high - sought.low) * spread
    if not effort.everywhere:
        first[0] = sought.start
    return np.asarray(
        differential_evolution(
            misfits,  # type: ignore[arg-type] # the stubs know of no function of many at a time
            Bounds(sought.low, sought.high),
            strategy="currenttobest1bin",
            init=first,
            maxiter=effort.generations,
            mutation=MUTATION,
            recombination=WHOLE,
            tol=0.0,
            polish=False,
            updating="deferred",
            vectorized=True,
            rng=np.random.default_rng(SEED),
        ).x
    )


def _misfits(sought: Sought, behind: Behind, ground: Ground, others: Float) -> Callable[[Float], Float]:
    """Return what leaves how much of the working rows' squares: numbers (k, s) -> shape (s,)."""
    own, working = _own_columns(sought, ground), ground.keep(ground.working)
    beside = Beside(np.hstack([working.base[:, ~own], others[ground.working]]), working.y)

    def misfits(numbers: Float) -> Float:
        every, rigid = numbers.T, working.base[:, own] @ sought.model_at(numbers)
        left = np.zeros(len(every))
        far, shapes = [sought.far_side_at(one) for one in every], [sought.shape_at(one) for one in every]
        for place, columns in behind(ground.data, far, shapes):
            rest = beside.response - beside.free(rigid[:, place] + working.rows.of(columns)[:, 0])
            left[place] = rest @ rest
        return left

    return misfits


def _fitted(sought: Sought, numbers: Float, candidate: Effect, behind: Behind, ground: Ground, others: Float) -> Fitted:
    """What numbers, shape (k,), stand for; other factors of the declared model as they fit best beside it."""
    own, w, shape = _own_columns(sought, ground), ground.working, sought.shape_at(numbers)
    ((_, fine),) = behind(ground.data, [sought.far_side_at(numbers)], [shape])
    factors = np.zeros(len(own))
    factors[own] = sought.model_at(numbers)
    rest = ground.y - ground.base @ factors - ground.rows.of(fine)[:, 0]
    more = np.hstack([ground.base[:, ~own], others])
    factors[~own] = least_squares(more[w], rest[w])[: int((~own).sum())]
    baseline = ground.declared.baseline(factors)
    columns = ground.rows.of(candidate.regressor(ground.data, baseline, shape))
    return Fitted(shape=shape, columns=columns, baseline=baseline)


def _own_columns(sought: Sought, ground: Ground) -> NDArray[np.bool_]:
    """Which columns of the declared model are looked for, shape (b,)."""
    return np.isin(ground.declared.names, sought.of_model)
