"""A step of Gauss and Newton along all numbers of all shapes at once, with the intervals that belong to it.

The derivative of an effect's torque with respect to a number of its shape is one more column, and its factor is how far
that number is off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.declared import coefficients
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

STEP = 1e-3
MOST_CHANGE = 3.0
"""Change of an effect's torque within the interval of a number of its shape, over that torque: beyond, the derivative
says nothing of the way there, and the log does not tell the number."""
MOST_SPREAD = 10.0
"""Half of the interval of a number that cannot be below zero, over the number: the log does not tell its size."""
UNKNOWN = Coefficient(value=0.0, low=-np.inf, high=np.inf)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Steps:
    """All numbers of a grown model.

    Attributes:
        linear: Factors of the declared model's columns, then of each effect's: their values with the shapes as they
            are, their intervals with shapes as unknown as they are.
        shapes: Of each effect, by name: how far each number of its shape is off, assumed ones last; 0 without bounds
            where the log does not tell it.
        bent: Of each effect, whether a number of its shape changes its torque so much within its interval that no
            derivative holds: the factors' intervals are those of this shape alone.
    """

    linear: tuple[Coefficient, ...]
    shapes: tuple[dict[str, Coefficient], ...]
    bent: tuple[bool, ...]


def steps_of(ground: Ground, found: Sequence[Found], baseline: Nominal) -> Steps:
    """Fit factors and steps together, on all cycles."""
    linear = np.hstack([ground.base, *(f.columns for f in found)])
    fitted = coefficients(linear, ground.y, ground.rows.cycle)
    slopes, names, at = [np.zeros((len(linear), 0))], [], ground.base.shape[1]
    most_change, most_spread = [np.zeros(0)], [np.zeros(0)]
    for f in found:
        factors = np.array([c.value for c in fitted[at : at + f.columns.shape[1]]])
        names.append(tuple(f.candidate.with_assumed(f.shape)))
        slopes.append(_slopes(ground, f, baseline, factors))
        most_change.append(np.repeat(MOST_CHANGE * _rms(f.columns @ factors), len(names[-1])))
        most_spread.append(MOST_SPREAD * _sizes(f))
        at += len(factors)
    most = np.stack([np.concatenate(most_change), np.concatenate(most_spread)])
    every, bent = _with_slopes(ground, linear, np.hstack(slopes), most)
    steps = iter(every[at:])
    ends = np.cumsum([len(own) for own in names])
    return Steps(
        linear=tuple(around(one.value, wide) for one, wide in zip(fitted, every, strict=False)),
        shapes=tuple({name: next(steps) for name in own} for own in names),
        bent=tuple(bool(bent[end - len(own) : end].any()) for own, end in zip(names, ends.tolist(), strict=True)),
    )


def around(value: float, wide: Coefficient) -> Coefficient:
    """A value with the half width of another interval: the value stays, for the torque was computed with it."""
    half = (wide.high - wide.low) / 2.0
    return Coefficient(value=value, low=value - half, high=value + half)


def _with_slopes(
    ground: Ground, linear: Float, slopes: Float, most: Float
) -> tuple[tuple[Coefficient, ...], NDArray[np.bool_]]:
    """Factors of the linear columns and of the slopes, those of slopes that the log does not tell without bounds.

    And which slopes change the torque too much within their interval, shape (s,).

    Args:
        ground: The joint.
        linear: Declared model and effects, shape (m, b).
        slopes: Derivatives with respect to each number of each shape, shape (m, s).
        most: What the interval of a number may hold: root mean square of the change of the effect's torque [N m], and
            half of its width; beyond, the log does not tell it, shape (2, s).
    """
    every = coefficients(np.hstack([linear, slopes]), ground.y, ground.rows.cycle)
    half = np.array([(one.high - one.low) / 2.0 for one in every[linear.shape[1] :]])
    bent: NDArray[np.bool_] = half * _rms(slopes) > most[0]
    told = ~bent & (half <= most[1])
    if not told.all():
        every = coefficients(np.hstack([linear, slopes[:, told]]), ground.y, ground.rows.cycle)
    steps = iter(every[linear.shape[1] :])
    return (*every[: linear.shape[1]], *(next(steps) if one else UNKNOWN for one in told)), bent


def _sizes(found: Found) -> Float:
    """Each number of a shape that cannot be below zero; infinite for one that can, shape (k,)."""
    shape = found.candidate.with_assumed(found.shape)
    above = [found.candidate.bounds(name)[0] >= 0.0 for name in shape]
    return np.where(above, np.abs(np.array(list(shape.values()), np.float64)), np.inf)


def _rms(columns: Float) -> Float:
    """Root mean square of each column."""
    return np.asarray(np.sqrt(np.mean(columns**2, axis=0)), np.float64)


def _slopes(ground: Ground, found: Found, baseline: Nominal, factors: Float) -> Float:
    """Derivative of an effect's torque with respect to each number of its shape, assumed ones last, shape (m, k).

    To one side alone at a bound: beyond it there is no such effect.
    """
    columns = [np.zeros((len(ground.y), 0))]
    shape = found.candidate.with_assumed(found.shape)
    for name, value in shape.items():
        step = STEP * max(abs(value), STEP)
        low, high = np.clip([value - step, value + step], *found.candidate.bounds(name)).tolist()
        down, up = (
            ground.rows.of(found.candidate.regressor(ground.data, baseline, {**shape, name: end}))
            for end in (low, high)
        )
        columns.append(((up - down) @ factors / (high - low))[:, None])
    return np.hstack(columns)
