"""Scatter between sessions beyond the intervals of their estimates: the random effect of a session."""

import numpy as np

from friction_audit.joint_log import Float

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


def steps_scatter(y: Float, error: Float) -> float:
    """Return the scatter that the differences of sessions in a row show; a few steps or a slow ramp do not matter.

    The variance of a difference is 2 tau^2 + s_i^2 + s_{i+1}^2.

    Args:
        y: Estimates in the order of the sessions, shape (n,).
        error: Their standard errors, shape (n,).
    """
    if len(y) <= 1:
        return 0.0
    spread = (MAD_TO_SD * float(np.median(np.abs(np.diff(y))))) ** 2
    own = float(np.median(error[1:] ** 2 + error[:-1] ** 2))
    return float(np.sqrt(max(spread - own, 0.0) / 2))


def residual_scatter(residual: Float, error: Float, freedom: int) -> float:
    """Return tau with which the weighted residuals are as large as they should be (Paule and Mandel 1982).

    Solves sum r_i^2 / (s_i^2 + tau^2) = degrees of freedom; 0 where the errors alone explain the residuals.

    Args:
        residual: Of a model of the drift, shape (n,).
        error: Standard errors, shape (n,).
        freedom: Sessions minus parameters.
    """
    from scipy.optimize import brentq

    def excess(tau: float) -> float:
        return float(np.sum(residual**2 / (error**2 + tau**2))) - freedom

    if freedom < 1 or excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, float(np.sqrt(np.sum(residual**2) / freedom)) + 1e-300, xtol=1e-12))
