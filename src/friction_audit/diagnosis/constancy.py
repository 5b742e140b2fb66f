"""Whether a named effect is as large in one half of the motion as in the other: a mechanism is, a relative of it not.

Reference: G. C. Chow, Tests of equality between sets of coefficients in two linear regressions, Econometrica 28 (1960)
591; the error of the difference counts the memory of the noise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Ground
from friction_audit.joint_log import Float

SURELY = 4.0
"""Standard errors of a difference that chance does not make: seven halvings of some effects are looked at."""
ANOTHER = 0.5
"""Difference over the mean from which an effect is not one: 1.7 times as large here as there. What a formula does not
get right of its own mechanism changes its size by less."""
LEAST_THERE = 0.1
"""Share of an effect's squares that each half must hold."""
LEAST_OF_MOTION = 0.5
"""Share of an effect's squares in a half that must come of the motion and not of its noise: elsewhere its factor is not
told."""
OWN = 1e-3
"""Share of the difference's squares that no other column of the model may hold."""
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Half:
    """Rows of one half of the motion, shape (m,), and what to call it and the other."""

    inside: NDArray[np.bool_]
    here: str
    there: str


def find_inconstant(
    ground: Ground, named: Sequence[tuple[str, Float]], noise: Sequence[Float] | None = None
) -> tuple[str, ...]:
    """Say of each effect that is clearly larger in one half of the motion than in the other where it is.

    Each effect's torque, as fitted with everything together, is one column; times plus or minus a half in the two
    halves it is another, beside the declared model and all effects. Where some of its columns is noise of the motion,
    its factor is too small by that share of the squares (regression calibration), in each half by its own.

    Args:
        ground: The joint.
        named: Name and columns of each effect on the rows, shape (m, p).
        noise: Of its columns, each of its shape; none where None.
    """
    model = np.hstack([ground.base, *(columns for _, columns in named)])
    factors, at = least_squares(model, ground.y), ground.base.shape[1]
    torques, shakes = [], []
    for k, (_, columns) in enumerate(named):
        own = factors[at : at + columns.shape[1]]
        torques.append(columns @ own)
        shakes.append(np.zeros(len(columns)) if noise is None else noise[k] @ own)
        at += columns.shape[1]
    beside = np.column_stack([ground.base, *torques])
    memory = ground.memory(*(columns for _, columns in named))
    found = []
    for k, (name, _) in enumerate(named):
        place = ground.base.shape[1] + k
        told = [(*_difference(ground.y, beside, place, half, memory, shakes[k]), half) for half in _halves(ground)]
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


def _difference(y: Float, beside: Float, place: int, half: Half, memory: float, noise: Float) -> tuple[float, float]:
    """By how much an effect is larger inside than outside, over their mean, and over its standard error; 0 untold."""
    torque, others = beside[:, place], np.delete(beside, place, axis=1)
    own = torque - others @ least_squares(others, torque)
    of_motion = [1.0 - _square(noise[rows]) / max(_square(own[rows]), TINY) for rows in (half.inside, ~half.inside)]
    if min(of_motion) < LEAST_OF_MOTION:
        return 0.0, 0.0
    torque, own = (column * np.where(half.inside, *of_motion) for column in (torque, own))
    split = torque * np.where(half.inside, 0.5, -0.5)
    beside = np.column_stack([others, torque])
    free = split - beside @ least_squares(beside, split)
    there, whole, size = _square(own[half.inside]), _square(own), _square(free)
    if not LEAST_THERE * whole < there < (1.0 - LEAST_THERE) * whole or size <= OWN * _square(split):
        return 0.0, 0.0
    columns = np.column_stack([beside, split])
    factors = least_squares(columns, y)
    left = y - columns @ factors
    error = float(np.sqrt(memory * np.mean(left**2) / size))
    return float(factors[-1]) / max(abs(float(factors[-2])), TINY), float(factors[-1]) / max(error, TINY)


def _square(signal: Float) -> float:
    return float(signal @ signal)
