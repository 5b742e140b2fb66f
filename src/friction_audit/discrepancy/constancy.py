"""Whether a named effect is as large in one half of the motion as in the other: a mechanism is, a relative of it not.

Reference: G. C. Chow, Tests of equality between sets of coefficients in two linear regressions, Econometrica 28 (1960)
591; the error of the difference counts the memory of the noise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.ground import Ground
from friction_audit.joint_log import Float

SURELY = 4.0
"""Standard errors of a difference that chance does not make: seven halvings of some effects are looked at."""
ANOTHER = 0.5
"""Difference over the mean from which an effect is not one: 1.7 times as large here as there. What a formula does not
get right of its own mechanism changes its size by less."""
LEAST_THERE = 0.1
"""Share of an effect's squares that each half must hold."""
OWN = 1e-3
"""Share of the difference's squares that no other column of the model may hold."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Half:
    """Rows of one half of the motion, shape (m,), and what to call it and the other."""

    inside: NDArray[np.bool_]
    here: str
    there: str


def find_inconstant(ground: Ground, named: Sequence[tuple[str, Float]]) -> tuple[str, ...]:
    """Say of each effect that is clearly larger in one half of the motion than in the other where it is.

    Each effect's torque, as fitted with everything together, is one column; times plus or minus a half in the two
    halves it is another, beside the declared model and all effects.

    Args:
        ground: The joint.
        named: Name and columns of each effect on the rows, shape (m, p).
    """
    model = np.hstack([ground.base, *(columns for _, columns in named)])
    factors, at = least_squares(model, ground.y), ground.base.shape[1]
    torques = []
    for _, columns in named:
        torques.append(columns @ factors[at : at + columns.shape[1]])
        at += columns.shape[1]
    beside = np.column_stack([ground.base, *torques])
    memory = ground.memory(*(columns for _, columns in named))
    found = []
    for k, (name, _) in enumerate(named):
        place = ground.base.shape[1] + k
        told = [(*_difference(ground.y, beside, place, half, memory), half) for half in _halves(ground)]
        share, z, half = max(told, key=lambda one: abs(one[1]) * (abs(one[0]) > ANOTHER))
        if abs(z) > SURELY and abs(share) > ANOTHER:
            more, less = (half.here, half.there) if share > 0.0 else (half.there, half.here)
            found.append(f"{name} is larger {more} than {less}, as no one mechanism is")
    return tuple(found)


def _halves(ground: Ground) -> Iterator[Half]:
    every, used = ground.rows.every, ground.rows.used
    dq, ddq = ground.data.dq[::every][used], ground.data.ddq[::every][used]
    axes = {curve.axis.name: curve.values for curve in ground.curves}
    yield Half(inside=dq > 0.0, here="forwards", there="backwards")
    yield Half(inside=ddq * dq > 0.0, here="while the joint speeds up", there="while it slows down")
    yield _above(np.abs(dq), "at high speed", "at low")
    yield _above(np.abs(ddq), "at high acceleration", "at low")
    yield _above(ground.rows.t, "late in the log", "early")
    for name, here, there in (
        ("position", "high in the range", "low in it"),
        ("displacement", "far from the last reversal", "near it"),
    ):
        if name in axes:
            yield _above(axes[name], here, there)


def _above(values: Float, here: str, there: str) -> Half:
    return Half(inside=values > np.median(values), here=here, there=there)


def _difference(y: Float, beside: Float, place: int, half: Half, memory: float) -> tuple[float, float]:
    """By how much an effect is larger inside than outside, over their mean, and over its standard error; 0 untold."""
    torque, others = beside[:, place], np.delete(beside, place, axis=1)
    split = torque * np.where(half.inside, 0.5, -0.5)
    own = torque - others @ least_squares(others, torque)
    free = split - beside @ least_squares(beside, split)
    there, whole = float(np.sum(own[half.inside] ** 2)), float(own @ own)
    size = float(free @ free)
    if not LEAST_THERE * whole < there < (1.0 - LEAST_THERE) * whole or size <= OWN * float(split @ split):
        return 0.0, 0.0
    columns = np.column_stack([beside, split])
    factors = least_squares(columns, y)
    left = y - columns @ factors
    error = float(np.sqrt(memory * np.mean(left**2) / size))
    mean = max(abs(float(factors[place])), float(np.finfo(float).tiny))
    return float(factors[-1]) / mean, float(factors[-1]) / max(error, float(np.finfo(float).tiny))
