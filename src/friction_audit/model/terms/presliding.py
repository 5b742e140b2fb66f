"""Presliding: friction builds up like a spring over the path since a reversal, and gives way as Coulomb friction.

State z of P. R. Dahl, A solid friction model (1968), with the level of Coulomb friction for a unit:

    dz/dx = (1 - z sgn(dx))^n / reach

n = 0 is a stop (Prandtl's element); n = 1/2 after a reversal is a row of stops that yield one after the other, evenly
spread (W. D. Iwan, J. Appl. Mech. 33 (1966) 893); n = 1 is Dahl's usual one and the LuGre model at constant level
(C. Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419, eq. (1)-(3)), whose damping sigma_1 dz/dt is the
stiffness times a time. Rate-independent but for that damping.
"""

from collections.abc import Sequence
from math import exp

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term


def bristle(q: Float, reach_rad: float, exponent: float) -> Float:
    """Return the state z along a path, exact for a path straight between its samples, 0 at the start, shape (n,).

    Args:
        q: Positions, shape (n,). [rad]
        reach_rad: Displacement after which a spring as stiff as at z = 0 would be at the level. [rad]
        exponent: n; 0 gives way all at once, larger ones give way longer before.
    """
    return np.asarray(_bristle(np.ascontiguousarray(q, dtype=np.float64), float(reach_rad), float(exponent)))


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return what bristles in the place of Coulomb friction add, as a column: z + T dz/dt - sgn(dq)."""
    reach, exponent, damping = shape
    z = bristle(motion.q, reach, exponent)
    if damping > 0.0:
        z = z + damping * np.gradient(z, motion.t)
    return np.asarray(z - np.sign(motion.dq))[:, None]


@compiled()
def _bristle(q: Float, reach: float, exponent: float) -> Float:
    z = np.zeros(len(q))
    missing, sign = 1.0, 1.0
    for k in range(1, len(q)):
        path = (q[k] - q[k - 1]) / reach
        if path * sign < 0.0:
            sign, missing = -sign, 2.0 - missing
        missing = _give_way(missing, abs(path), exponent)
        z[k] = sign * (1.0 - missing)
    return z


@compiled()
def _give_way(missing: float, path: float, exponent: float) -> float:
    """Move 1 - z sgn(dx) on along a path in one direction: dm/dx = -m^n, solved exactly; it ends at zero."""
    if exponent == 1.0:
        return missing * exp(-path)
    if exponent == 0.0:
        return max(missing - path, 0.0)
    if missing <= 0.0 or path == 0.0:
        return missing
    bend = 1.0 - exponent
    left = missing**bend - bend * path
    return float(left ** (1.0 / bend)) if left > 0.0 else 0.0


TERM = Term(
    name="presliding",
    label="friction builds up after a reversal",
    linear=(Parameter(name="bristle_nm", unit="N m", meaning="Coulomb friction of the bristles", lower=0.0),),
    shape=(
        Parameter(
            name="reach_rad", unit="rad", meaning="Coulomb friction over stiffness at rest", lower=1e-6, upper=1.0
        ),
        Parameter(name="yielding_exponent", unit="1", meaning="how long before they give way", lower=0.0, upper=3.0),
        Parameter(name="bristle_damping_s", unit="s", meaning="damping over stiffness", lower=0.0, upper=1.0),
    ),
    basis=basis,
    forward="bristle",
)
