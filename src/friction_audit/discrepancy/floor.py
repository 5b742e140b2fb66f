"""Below what root mean square no model of the motion gets: the floor of the noise on the locked cycles."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.curves import Curve
from friction_audit.discrepancy.ground import Ground
from friction_audit.joint_log import Float

RIDGE = 1e-3


def noise_floor(ground: Ground, curves: Sequence[Curve], *effects: Float) -> float:
    """Root mean square on locked cycles of the best of the model, it with a curve over one axis, and with all. [N m]

    Curves and model are fitted on the working cycles. It is an upper bound of the noise, for it holds what the curves
    do not learn; few cycles do not teach all of them at once.
    """
    model = np.hstack([ground.base, *effects])
    bent = [curve.group.shapes[0] for curve in curves]
    tried = [*(np.hstack([model, columns]) for columns in bent), np.hstack([model, *bent])]
    left = [ground.residual(*effects), *(_left(ground, columns) for columns in tried)]
    return min(float(np.sqrt(np.mean(residual[ground.locked] ** 2))) for residual in left)


def beside_all_curves(ground: Ground, *effects: Float) -> Float:
    """What the model and the curves over all axes together leave of all rows, fitted to all of them, shape (m,). [N m]

    To be looked at for what follows no quantity of the motion.
    """
    columns = np.hstack([ground.base, *effects, *(curve.group.shapes[0] for curve in ground.curves)])
    return _left(ground, columns, np.ones_like(ground.working))


def _left(ground: Ground, columns: Float, fitted: NDArray[np.bool_] | None = None) -> Float:
    """Residual of a fit to the working or other rows with a slight ridge, for curves over two axes may be copies."""
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scaled = columns / np.where(scale > 0, scale, 1.0)
    rows = ground.working if fitted is None else fitted
    x, y = scaled[rows], ground.y[rows]
    factors = np.linalg.solve(x.T @ x + RIDGE * len(y) * np.eye(x.shape[1]), x.T @ y)
    return np.asarray(ground.y - scaled @ factors)
