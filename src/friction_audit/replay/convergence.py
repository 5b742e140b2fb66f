"""When a compensation is right, and how soon it gets there."""

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.replay.records import ESTIMATED
from friction_audit.replay.result import ReplayHistory

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
