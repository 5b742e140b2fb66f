"""Below what root mean square no model of the motion gets: the floor of the noise on the locked cycles."""

from collections.abc import Sequence

import numpy as np

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


def _left(ground: Ground, columns: Float) -> Float:
    """Residual of a fit to the working rows with a slight ridge, for curves over two axes may be copies."""
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scaled = columns / np.where(scale > 0, scale, 1.0)
    x, y = scaled[ground.working], ground.y[ground.working]
    factors = np.linalg.solve(x.T @ x + RIDGE * len(y) * np.eye(x.shape[1]), x.T @ y)
    return np.asarray(ground.y - scaled @ factors)
