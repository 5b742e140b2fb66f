"""Below what root mean square no model of the motion gets: the floor of the noise on the locked cycles."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.curves import Curve
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.wanted_curves import wanted_curves
from friction_audit.joint_log import Float

RIDGE = 1e-3


def noise_floor(ground: Ground, curves: Sequence[Curve], *effects: Float) -> float:
    """Root mean square on locked cycles of the best of the model, it with a curve over one axis, and with all. [N m]

    Curves and model are fitted on the working cycles. It is an upper bound of the noise, for it holds what the curves
    do not learn; few cycles do not teach all of them at once.
    """
    parts = [ground.base, *effects, *(curve.group.shapes[0] for curve in curves)]
    ends = np.cumsum([0, *(part.shape[1] for part in parts)]).tolist()
    model, every = list(range(ends[1 + len(effects)])), list(range(ends[-1]))
    bent = [[*model, *range(first, last)] for first, last in pairwise(ends[1 + len(effects) :])]
    left = [ground.residual(*effects), *_left(ground, np.hstack(parts), ground.working, [*bent, every])]
    return min(float(np.sqrt(np.mean(residual[ground.locked] ** 2))) for residual in left)


def beside_wanted_curves(ground: Ground, *effects: Float) -> Float:
    """What the model and the curves that something missing has bent leave of all rows, fitted to all, (m,). [N m]

    To be looked at for what follows no quantity of the motion. All curves together would take most of that too.
    """
    model = np.hstack([ground.base, *effects])
    curves = [curve.group for curve in ground.curves]
    # Without the ridge of _left: a thousandth of friction and inertia would come round with the strokes.
    return Beside(np.hstack([model, wanted_curves(ground.y, model, curves, ground.run)]), ground.y).response


def _left(ground: Ground, columns: Float, fitted: NDArray[np.bool_], tried: Sequence[Sequence[int]]) -> Iterator[Float]:
    """Yield what some of the columns leave, fitted with a slight ridge, for curves over two axes may be copies.

    Args:
        ground: The joint.
        columns: Shape (m, p).
        fitted: Rows to fit to, shape (m,).
        tried: Numbers of the columns of each fit.
    """
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scaled = columns / np.where(scale > 0, scale, 1.0)
    x, y = scaled[fitted], ground.y[fitted]
    gram, right = x.T @ x + RIDGE * len(y) * np.eye(x.shape[1]), x.T @ y
    for some in tried:
        factors = np.zeros(len(gram))
        factors[some] = np.linalg.solve(gram[np.ix_(some, some)], right[some])
        yield np.asarray(ground.y - scaled @ factors)
