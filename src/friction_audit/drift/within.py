"""Warm-up: what changes within the sessions, kept apart from what changes between them."""

from collections.abc import Sequence

import numpy as np

from friction_audit.drift.scatter import residual_scatter
from friction_audit.drift.series import NORMAL_95
from friction_audit.drift.session import Session
from friction_audit.friction.history import UNDETERMINED, Coefficient

ROUNDS = 4
"""Mean and scatter in turns; they settle at once."""


def change_within(sessions: Sequence[Session], joint: int, coefficient: str) -> Coefficient:
    """Return the relative change of a coefficient within a session, the mean over the sessions that tell it.

    A random-effects mean with the interval of Hartung and Knapp (2001), never narrower than the sessions' own allow.
    """
    from scipy.stats import t

    told = [
        summary.within[coefficient]
        for session in sessions
        for summary in session.joints
        if summary.joint == joint and coefficient in summary.within
    ]
    rows = np.array(
        [(c.value, c.low, c.high) for c in told if np.isfinite(c.value + c.low + c.high) and c.high > c.low]
    )
    if not len(rows):
        return UNDETERMINED
    if len(rows) == 1:
        return Coefficient(value=float(rows[0, 0]), low=float(rows[0, 1]), high=float(rows[0, 2]))
    error, freedom = (rows[:, 2] - rows[:, 1]) / (2 * NORMAL_95), len(rows) - 1
    scatter = 0.0
    for _ in range(ROUNDS):
        weight = 1.0 / (error**2 + scatter**2)
        mean = float(np.average(rows[:, 0], weights=weight))
        scatter = residual_scatter(rows[:, 0] - mean, error, freedom)
    spread = float(np.sum(weight * (rows[:, 0] - mean) ** 2)) / freedom
    half = float(t.ppf(0.975, freedom)) * float(np.sqrt(max(spread, 1.0) / np.sum(weight)))
    return Coefficient(value=mean, low=mean - half, high=mean + half)
