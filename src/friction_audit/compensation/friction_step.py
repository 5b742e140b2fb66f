"""A step of friction within a log, and how a compensator gets over it."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.measures import IN_A_ROW, first_right
from friction_audit.compensation.result import Recovery, ReplayHistory
from friction_audit.joint_log import Float

LEAST_CHANGE = 0.25
"""A step of friction changes it by so much of what it was."""

SURE = 50.0
"""F ratio of two laws over one: what has no step reaches 10 at most, also where the split is chosen after the fact."""

AT_ONCE = 0.7
"""So much of it happens from one cycle to the next: warming up is no step."""

TOO_ALIKE = 1e-6
"""Squared sine between the columns below which they are one."""


def find_recovery(history: ReplayHistory) -> Recovery | None:
    """Find the largest step of friction in a log and how the compensator got over it; None without one."""
    found = find_step(history.path_rad, history.square_speed_rad2_s, history.friction_j)
    if found is None:
        return None
    row, change = found
    right = first_right(history, row)
    return Recovery(
        step_s=float(history.start_s[row]),
        change=change,
        cycles=None if right is None else right - row,
        seconds=float("nan") if right is None else float(history.start_s[right] - history.start_s[row]),
    )


def find_step(path: Float, square: Float, friction: Float) -> tuple[int, float] | None:
    """Return the first cycle after a step of friction, and friction after over before; None without a step.

    Before and after it, Coulomb and viscous friction of their own describe the cycles: the split where they do so best.

    Args:
        path: Path of each cycle, shape (m,). [rad]
        square: Integral of its squared velocity, shape (m,). [rad^2/s]
        friction: What friction took in it, shape (m,). [J]
    """
    cycles = len(path)
    if cycles < 2 * IN_A_ROW or not path.min() > 0.0 or not friction.any():
        return None
    rows = np.stack([np.ones(cycles), square / path, friction / path], axis=1)
    whole = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)
    splits: NDArray[np.int64] = np.arange(IN_A_ROW, cycles - IN_A_ROW + 1)
    before, after = whole[splits - 1], whole[-1] - whole[splits - 1]
    left = _fit(before)[1] + _fit(after)[1]
    best = int(np.argmin(left))
    row = int(splits[best])
    one = float(_fit(whole[-1:])[1][0])
    ratio = (one - left[best]) / 2.0 / max(left[best] / max(cycles - 4, 1), np.finfo(float).eps * one)
    law, later = _fit(before[best : best + 1])[0][0], _fit(after[best : best + 1])[0][0]
    columns = rows[:, :2]
    change = float((columns @ later).sum() / (columns @ law).sum())
    level = np.divide(rows[:, 2], columns @ law, out=np.ones(cycles), where=columns @ law != 0.0)
    near = float(np.median(level[row : row + IN_A_ROW]) - np.median(level[row - IN_A_ROW : row]))
    step = change - 1.0
    sudden = near * step > 0.0 and abs(near) > AT_ONCE * abs(step)
    return (row, change) if ratio > SURE and change > 0.0 and abs(step) > LEAST_CHANGE and sudden else None


def _fit(moments: Float) -> tuple[Float, Float]:
    """Fit the mean friction torque of cycles by a constant and a multiple of their mean speed.

    Args:
        moments: Sums of the products of one, speed and torque, shape (s, 3, 3).

    Returns:
        The two coefficients, shape (s, 2), and the squares left over, shape (s,).
    """
    count, speed, square = moments[:, 0, 0], moments[:, 0, 1], moments[:, 1, 1]
    torque, both, energy = moments[:, 0, 2], moments[:, 1, 2], moments[:, 2, 2]
    determinant = count * square - speed * speed
    apart = determinant > TOO_ALIKE * count * square
    safe = np.where(apart, determinant, 1.0)
    constant = np.where(apart, (torque * square - both * speed) / safe, torque / count)
    slope = np.where(apart, (count * both - speed * torque) / safe, 0.0)
    return np.stack([constant, slope], axis=1), np.maximum(energy - constant * torque - slope * both, 0.0)
