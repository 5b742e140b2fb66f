"""Robust linear regression with autocorrelation-consistent errors.

Huber's M-estimate by reweighting, and the covariance of Newey and West: the same numbers as ``RLM`` and ``WLS`` of
statsmodels (the tests compare them). Written here because the columns are few and the rows many: normal equations take
a tenth of the time, and loading statsmodels takes longer than reading an hour of log.
"""

import numpy as np

from friction_audit.joint_log import Float

HUBER = 1.345
"""Residuals beyond this many standard deviations lose weight: 95 % efficiency where the noise is normal."""

SIGMA_PER_MEDIAN = 1 / 0.6744897501960817
"""Standard deviation of a normal variable over the median of its absolute value."""

REWEIGHTINGS = 9
CUTOFF = 1e-14
"""Relative size below which a singular value of the normal matrix counts as zero."""


def huber_weights(design: Float, target: Float) -> Float:
    """Return the weights of the rows in Huber's estimate, 1 except for outliers.

    Args:
        design: Columns of comparable length, shape (m, p).
        target: Shape (m,).
    """
    smallest = np.finfo(float).eps * float(np.abs(target).max()) + np.finfo(float).tiny
    weights = np.ones(len(target))
    for _ in range(REWEIGHTINGS):
        solution, _ = solve_weighted(design, target, weights)
        residual = np.abs(target - design @ solution).clip(min=smallest)
        weights = np.minimum(HUBER * SIGMA_PER_MEDIAN * np.median(residual) / residual, 1.0)
    return weights


def solve_weighted(design: Float, target: Float, weights: Float) -> tuple[Float, Float]:
    """Return the weighted least-squares solution, shape (p,), and the inverse of its normal matrix, shape (p, p)."""
    weighted = design * weights[:, None]
    inverse = np.asarray(np.linalg.pinv(weighted.T @ design, rcond=CUTOFF, hermitian=True), np.float64)
    return inverse @ (weighted.T @ target), inverse


def newey_west_errors(scores: Float, inverse: Float, lags: int) -> Float:
    """Return standard errors of a least-squares solution whose rows are correlated over some lags, shape (p,).

    Args:
        scores: Weight times residual times row of the design, in order of time and evenly spaced, shape (m, p).
        inverse: Inverse of the normal matrix, shape (p, p).
        lags: Largest lag; correlations count less and less up to it (Bartlett).
    """
    middle = scores.T @ scores
    for lag in range(1, lags + 1):
        together = scores[lag:].T @ scores[:-lag]
        middle += (1 - lag / (lags + 1)) * (together + together.T)
    return np.asarray(np.sqrt(np.diag(inverse @ middle @ inverse)), np.float64)
