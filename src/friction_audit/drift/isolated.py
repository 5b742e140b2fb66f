"""Isolated sessions: an estimate that none of its neighbours comes near is no drift, whatever it is."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.scatter import steps_scatter
from friction_audit.joint_log import Float

REACH = 2
"""So many sessions on each side are asked."""

FAR = 5.0
"""Standard deviations of a difference of two sessions."""

FEWEST = 5
"""With fewer sessions nobody can tell which one is the odd one."""


def find_isolated(y: Float, error: Float) -> NDArray[np.bool_]:
    """Find the sessions that differ from both neighbours on each side by far more than neighbours use to.

    A step has alike sessions on both of its sides, a ramp has neighbours on either side: neither is isolated. The
    first and the last session may be: one session after a step is told from a broken estimate by the next one.

    Args:
        y: Estimates in the order of the sessions, shape (n,).
        error: Their standard errors, shape (n,).
    """
    n = len(y)
    if n < FEWEST:
        return np.zeros(n, dtype=np.bool_)
    variance = error**2 + steps_scatter(y, error) ** 2
    near = np.zeros(n, dtype=np.bool_)
    for lag in range(1, REACH + 1):
        close = np.abs(y[lag:] - y[:-lag]) <= FAR * np.sqrt(variance[lag:] + variance[:-lag])
        near[lag:] |= close
        near[:-lag] |= close
    return ~near
