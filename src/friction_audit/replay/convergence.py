"""When a compensation is right, how soon it gets there, and how it gets over a step of friction."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.replay.records import ESTIMATED
from friction_audit.replay.result import Recovery, ReplayHistory

RIGHT = 0.1
"""Share of the dissipation up to which what is left to the person, or given out, counts as right."""

IN_A_ROW = 3
"""So many cycles must be right, one after the other: a single one may be so by chance."""

UPDATES = 2
"""From this update of the coefficients on, the compensator is past its beginning."""


def share_left(history: ReplayHistory) -> Float:
    """Return what each cycle left to the person or gave out, over what friction took in it, shape (m,)."""
    usable = history.friction_j > 0.0
    return np.where(usable, np.abs(history.net_energy_j) / np.where(usable, history.friction_j, 1.0), np.inf)


def dissipation_removed(history: ReplayHistory, first: int = 0) -> float:
    """Return the share of the dissipation that compensation removed from a cycle on (0-based); NaN without cycles."""
    friction = float(history.friction_j[first:].sum())
    if not len(history.friction_j[first:]) or friction <= 0.0:
        return float("nan")
    return 1.0 - float(np.abs(history.net_energy_j[first:]).sum()) / friction


def first_updated(history: ReplayHistory) -> int:
    """Return the first cycle (0-based) that began with coefficients updated twice; their number if there is none."""
    updates = np.flatnonzero(history.status == ESTIMATED)
    return int(updates[UPDATES - 1]) + 1 if len(updates) >= UPDATES else len(history.status)


def first_right(history: ReplayHistory, first: int = 0) -> int | None:
    """Return the first cycle (0-based), not before ``first``, from which on IN_A_ROW are right; None if never."""
    right = share_left(history)[first:] <= RIGHT
    if len(right) < IN_A_ROW:
        return None
    runs = np.convolve(right, np.ones(IN_A_ROW), "valid") == IN_A_ROW
    return first + int(np.argmax(runs)) if runs.any() else None


LEAST_CHANGE = 0.25
"""A step of friction changes it by so much of what it was."""
SURE = 6.0
"""And by so many standard errors."""
AT_ONCE = 0.7
"""And so much of it within a cycle: warming up is no step."""


def find_recovery(history: ReplayHistory) -> Recovery | None:
    """Find the largest step of friction in a log and how the compensator got over it; None without one."""
    level = friction_level(history)
    found = find_step(level)
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


def friction_level(history: ReplayHistory) -> Float:
    """Return what friction took in each cycle over what constant Coulomb and viscous friction would take, (m,)."""
    columns = np.stack([history.path_rad, history.square_speed_rad2_s], axis=1)
    weight = 1.0 / np.maximum(history.path_rad, np.finfo(float).tiny)
    found = np.linalg.lstsq(columns * weight[:, None], history.friction_j * weight, rcond=None)[0]
    constant = columns @ found
    return np.divide(history.friction_j, constant, out=np.ones(len(constant)), where=constant > 0.0)


def find_step(level: Float) -> tuple[int, float] | None:
    """Return the first row after the largest step of a level, and after over before; None without a step.

    Args:
        level: Shape (m,), about constant before and after a step.
    """
    if len(level) < 2 * IN_A_ROW:
        return None
    splits: NDArray[np.int64] = np.arange(IN_A_ROW, len(level) - IN_A_ROW + 1)
    scores = np.array([_score(level[:row], level[row:]) for row in splits])
    row = int(splits[np.argmax(scores)])
    before, after = float(level[:row].mean()), float(level[row:].mean())
    near = float(np.median(level[row : row + IN_A_ROW]) - np.median(level[row - IN_A_ROW : row]))
    step = after - before
    large = before > 0.0 and abs(step) > LEAST_CHANGE * before
    sudden = abs(near) > AT_ONCE * abs(step) and near * step > 0.0
    return (row, after / before) if scores.max() > SURE and large and sudden else None


def _score(before: Float, after: Float) -> float:
    """Return the difference of two means over its standard error."""
    freedom = len(before) + len(after) - 2
    spread = float((before.var() * len(before) + after.var() * len(after)) / freedom)
    error = float(np.sqrt(spread * (1.0 / len(before) + 1.0 / len(after))))
    return abs(float(after.mean() - before.mean())) / max(error, 1e-9)
