"""Friction that drives: of two curves over the speed that nearly cancel, one is none."""

from collections.abc import Sequence

import numpy as np

from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.ground import Ground
from friction_audit.joint_log import Float

COULOMB = "coulomb_nm"
SURELY = 2.0
"""Standard errors by which Coulomb friction must be below zero to be impossible."""


def driving(ground: Ground, effects: Sequence[Float]) -> int | None:
    """The effect beside which Coulomb friction comes out plainly below zero, and without which not.

    Two curves over the speed that nearly cancel leave their difference to Coulomb friction, which then would drive. A
    smoothed sign that is not quite the right one leaves a little: less than Coulomb friction is without it.

    Args:
        ground: The joint.
        effects: Columns of each effect on the rows, shape (m, p).

    Returns:
        Its number; None where there is none.
    """
    value, error = _coulomb(ground, effects)
    alone, _ = _coulomb(ground, [])
    if value + max(SURELY * error, alone) >= 0.0 or alone < 0.0:
        return None
    without = [_coulomb(ground, [*effects[:k], *effects[k + 1 :]])[0] for k in range(len(effects))]
    return int(np.argmax(without)) if max(without) >= 0.0 else None


def _coulomb(ground: Ground, effects: Sequence[Float]) -> tuple[float, float]:
    """Coulomb friction of the declared model over all cycles beside some columns, and its standard error. [N m]"""
    if COULOMB not in ground.declared.names:
        return 0.0, 0.0
    at, columns = ground.declared.names.index(COULOMB), np.hstack([ground.base, *effects])
    factors = least_squares(columns, ground.y)
    left = ground.y - columns @ factors
    spread = np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True)[at, at]
    return float(factors[at]), float(np.sqrt(ground.memory(*effects) * np.mean(left**2) * spread))
