"""The numbers that enter an effect nonlinearly, once its name is found: from the grid to the best value between."""

from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

BEYOND_EDGE = 1.5
"""At the edge of the grid the search goes on by so many of its last steps."""
HARDLY_OFF = 0.1
"""Of the way to the next but one value of the grid: what is nearer is no end of a search."""
EVALUATIONS = 20
"""For each number: two or three turn along with each other."""
FIRST_STEP = 1.0
"""Of the simplex, as logit of the share of the way between the neighbours: from the middle to three quarters."""
CLOSE = 0.02
"""Of the corners of the simplex, in the same measure."""
SETTLED = 1e-6
"""Change of the misfit, as a share of it, that is not worth another evaluation."""


def refine(
    candidate: Effect,
    shape: Nonlinear,
    tried: Sequence[Nonlinear],
    ground: Ground,
    baseline: Nominal,
    base: Float,
) -> Nonlinear:
    """Make the residual on the working rows smallest between the neighbours on the grid (Nelder and Mead 1965).

    Args:
        candidate: The effect.
        shape: Its best shape on the grid.
        tried: The grid.
        ground: The joint.
        baseline: What columns may lean on.
        base: All other columns of the model on the rows, shape (m, b).
    """
    from scipy.optimize import minimize
    from scipy.special import expit

    free = _free(candidate, shape, tried)
    if not free:
        return shape
    low, high = np.array(list(free.values())).T
    w, y = ground.working, ground.y[ground.working]
    beside, nothing, rows = Beside(base[w], y), float(y @ y), ground.rows.keep(w)

    def misfit(at: Nonlinear) -> float:
        factors, left = beside.fit(rows.of(candidate.regressor(ground.data, baseline, at)))
        return left if candidate.admissible(factors, at) else nothing

    def inside(x: Float) -> Nonlinear:
        return {**shape, **dict(zip(free, (low + (high - low) * expit(x)).tolist(), strict=True))}

    def cost(x: Float) -> float:
        return misfit(inside(x))

    share = np.clip((np.array([shape[name] for name in free]) - low) / (high - low), 0.02, 0.98)
    begin = np.log(share / (1.0 - share))
    first = np.vstack([begin, begin - np.diag(np.where(begin > 0, FIRST_STEP, -FIRST_STEP))])
    own = misfit(shape)
    found = minimize(
        cost,
        begin,
        method="Nelder-Mead",
        options={
            "initial_simplex": first,
            "maxfev": EVALUATIONS * max(len(free), 2),
            "xatol": CLOSE,
            "fatol": SETTLED * own,
        },
    )
    return inside(found.x) if found.fun < own else shape


def _free(candidate: Effect, shape: Nonlinear, tried: Sequence[Nonlinear]) -> dict[str, tuple[float, float]]:
    """The range of each number that can be refined, by name: between neighbours on the grid, within its bounds."""
    known = {parameter.name: parameter for parameter in candidate.nonlinear}
    free = {}
    for name in shape:
        low, high = _neighbours(name, shape, tried)
        if (parameter := known.get(name)) is not None:
            low, high = max(low, parameter.lower), min(high, parameter.upper)
        if high > low and not (parameter is not None and parameter.whole):
            free[name] = low, high
    return free


def _skip_close(side: list[float], value: float) -> list[float]:
    """The values on one side, the nearest last, without one that is hardly off: there an earlier search had ended."""
    near = len(side) > 1 and abs(side[-1] - value) < HARDLY_OFF * abs(side[-2] - value)
    return side[:-1] if near else side


def _neighbours(name: str, shape: Nonlinear, tried: Sequence[Nonlinear]) -> tuple[float, float]:
    """The values of the grid on either side of the nearest one; a step beyond where it is the last."""
    grid = sorted({other[name] for other in tried if name in other})
    at = int(np.argmin(np.abs(np.array(grid) - shape[name])))
    if len(grid) == 1:
        return grid[0], grid[0]
    below = _skip_close([grid[0] - BEYOND_EDGE * (grid[1] - grid[0]), *grid[:at]], shape[name])
    above = _skip_close([grid[-1] + BEYOND_EDGE * (grid[-1] - grid[-2]), *grid[:at:-1]], shape[name])
    low, high = below[-1], above[-1]
    return (max(low, grid[0] / 2.0) if grid[0] > 0 else low), high
