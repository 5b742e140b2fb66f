"""Warm-up: what changes within the sessions, kept apart from what changes between them."""

from collections.abc import Sequence

import numpy as np

from friction_audit.drift.series import NORMAL_95
from friction_audit.drift.session import Session
from friction_audit.friction.history import UNDETERMINED, Coefficient


def change_within(sessions: Sequence[Session], joint: int, coefficient: str) -> Coefficient:
    """Return the relative change of a coefficient within a session, the mean over the sessions that tell it.

    A random-effects mean (DerSimonian and Laird 1986, with the interval of Hartung and Knapp 2001).
    """
    from statsmodels.stats.meta_analysis import combine_effects

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
    variance = ((rows[:, 2] - rows[:, 1]) / (2 * NORMAL_95)) ** 2
    found = combine_effects(rows[:, 0], variance, method_re="dl", use_t=True)
    low, high = found.conf_int(use_t=True)[3]
    return Coefficient(value=float(found.mean_effect_re), low=float(low), high=float(high))
