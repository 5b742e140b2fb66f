"""The numbers that enter an effect nonlinearly, once its name is found: from the grid to the best value between."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.rows import Rows
from friction_audit.joint_log import Float

BEYOND_EDGE = 1.5
"""At the edge of the grid the search goes on by so many of its last steps."""
EVALUATIONS = 40


def refine(
    candidate: Candidate,
    shape: Shape,
    tried: Sequence[Shape],
    data: JointData,
    baseline: Baseline,
    rows: Rows,
    working: NDArray[np.bool_],
    base: Float,
    y: Float,
) -> Shape:
    """Make the residual on the working rows smallest between the neighbours on the grid (Nelder and Mead 1965).

    Args:
        candidate: The effect.
        shape: Its best shape on the grid.
        tried: The grid.
        data: The joint.
        baseline: What columns may lean on.
        rows: The rows.
        working: Rows that may be looked at, shape (m,).
        base: All other columns of the model on the rows, shape (m, b).
        y: Response, shape (m,).
    """
    from scipy.optimize import minimize

    free = {name: _neighbours(name, shape, tried) for name in shape}
    names = [name for name, (low, high) in free.items() if high > low]
    if not names:
        return shape
    low, high = (np.array([free[name][side] for name in names]) for side in (0, 1))

    def at(x: Float) -> Shape:
        inside = low + (high - low) / (1.0 + np.exp(-x))
        return {**shape, **dict(zip(names, inside.tolist(), strict=True))}

    def misfit(x: Float) -> float:
        columns = np.hstack([base, rows.of(candidate.columns(data, baseline, at(x)))])[working]
        factors = least_squares(columns, y[working])
        possible = candidate.admissible(factors[base.shape[1] :], at(x))
        return float(np.sum((y[working] - columns @ factors) ** 2)) if possible else np.inf

    start = np.array([shape[name] for name in names])
    share = np.clip((start - low) / (high - low), 0.02, 0.98)
    begin = np.log(share / (1.0 - share))
    found = minimize(misfit, begin, method="Nelder-Mead", options={"maxfev": EVALUATIONS, "xatol": 0.02, "fatol": 0.0})
    return at(found.x) if found.fun < misfit(begin) else shape


def _neighbours(name: str, shape: Shape, tried: Sequence[Shape]) -> tuple[float, float]:
    """The values of the grid on either side of one number; a step beyond where it is the last."""
    grid = sorted({other[name] for other in tried if name in other})
    at = grid.index(shape[name])
    if len(grid) == 1:
        return grid[0], grid[0]
    low = grid[at - 1] if at > 0 else grid[0] - BEYOND_EDGE * (grid[1] - grid[0])
    high = grid[at + 1] if at + 1 < len(grid) else grid[-1] + BEYOND_EDGE * (grid[-1] - grid[-2])
    return (max(low, grid[0] / 2.0) if grid[0] > 0 else low), high
