"""Strokes of a joint: direction, and displacement and time since the last reversal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.joint_data import JointData
from friction_audit.joint_log import Float

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Strokes:
    """Strokes on a grid of n samples.

    Attributes:
        direction: -1, 1, or 0 before the first motion, shape (n,).
        displacement: Position less that at the last reversal, 0 before the first motion, shape (n,). [rad]
        elapsed: Time since the last reversal, or since the first sample, shape (n,). [s]
        reversals: Samples at which the direction turns, the first motion not among them, shape (r,).
    """

    direction: Float
    displacement: Float
    elapsed: Float
    reversals: Index


def strokes(data: JointData) -> Strokes:
    """Cut the motion at its reversals; a direction holds until the opposite one is certain (hysteresis)."""
    direction = _held_direction(data.dq, data.dead_speed_rad_s)
    turns = np.flatnonzero(np.diff(direction) != 0) + 1
    starts = _first_with_new_sign(data.dq, turns, direction[turns])
    for start, turn in zip(starts, turns, strict=True):
        direction[start:turn] = direction[turn]
    since = np.zeros(len(data.t), dtype=np.int64)
    since[starts] = starts
    since = np.maximum.accumulate(since)
    displacement = np.where(direction == 0, 0.0, data.q - data.q[since])
    later = starts[1:] if len(turns) and turns[0] > 0 else starts
    return Strokes(direction=direction, displacement=displacement, elapsed=data.t - data.t[since], reversals=later)


def _held_direction(dq: Float, dead_speed: float) -> Float:
    """Sign of the velocity, held through what is too slow to have one, shape (n,)."""
    sign = np.where(np.abs(dq) > dead_speed, np.sign(dq), 0.0)
    last = np.maximum.accumulate(np.where(sign != 0, np.arange(len(dq)), -1))
    return np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)


def _first_with_new_sign(dq: Float, turns: Index, direction: Float) -> Index:
    """First sample from which the velocity has the new sign up to each turn, 0 if it always had."""
    samples = np.arange(len(dq))
    not_up, not_down = (np.maximum.accumulate(np.where(side * dq <= 0.0, samples, -1)) for side in (1.0, -1.0))
    return np.asarray(np.where(direction > 0.0, not_up[turns - 1], not_down[turns - 1]) + 1, np.int64)
