"""Friction that drives: of two curves over the speed that nearly cancel, one is none."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Ground
from friction_audit.joint_log import Float

COULOMB = "coulomb_nm"
SURELY = 2.0
"""Standard errors by which Coulomb friction must be below zero to be impossible."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Fit:
    """Coulomb friction of the declared model over all cycles, beside some effects.

    Attributes:
        coulomb_nm: Its size. [N m]
        error_nm: Its standard error. [N m]
        left: Sum of squares that is left. [(N m)^2]
    """

    coulomb_nm: float
    error_nm: float
    left: float


def driving(ground: Ground, effects: Sequence[Float]) -> int | None:
    """The effect beside which Coulomb friction comes out plainly below zero, and without which not.

    Two curves over the speed that nearly cancel leave their difference to Coulomb friction, which then would drive:
    the one that explains less is none. A smoothed sign that is not quite the right one leaves a little: less than
    Coulomb friction is without it.

    Args:
        ground: The joint.
        effects: Columns of each effect on the rows, shape (m, p).

    Returns:
        Its number; None where there is none.
    """
    if COULOMB not in ground.declared.names:
        return None
    beside, alone = _fit(ground, effects), _fit(ground, [])
    if beside.coulomb_nm + max(SURELY * beside.error_nm, alone.coulomb_nm) >= 0.0 or alone.coulomb_nm < 0.0:
        return None
    fits = [_fit(ground, [*effects[:k], *effects[k + 1 :]]) for k in range(len(effects))]
    left = [fit.left if fit.coulomb_nm >= 0.0 else np.inf for fit in fits]
    return int(np.argmin(left)) if min(left) < np.inf else None


def _fit(ground: Ground, effects: Sequence[Float]) -> Fit:
    at, columns = ground.declared.names.index(COULOMB), np.hstack([ground.base, *effects])
    factors = least_squares(columns, ground.y)
    rest = ground.y - columns @ factors
    spread = np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True)[at, at]
    error = float(np.sqrt(ground.memory(*effects) * np.mean(rest**2) * spread))
    return Fit(coulomb_nm=float(factors[at]), error_nm=error, left=float(rest @ rest))
