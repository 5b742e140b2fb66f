"""Huber's weights for a linear regression: outliers count less.

The same weights as ``RLM`` of statsmodels (the tests compare them). Written here because the columns are few and the
rows many: normal equations take a tenth of the time, and loading statsmodels takes longer than reading an hour of log.
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


def huber_weights(design: Float, target: Float, instruments: Float | None = None) -> Float:
    """Return the weights of the rows in Huber's estimate, 1 except for outliers.

    Args:
        design: Columns of comparable length, shape (m, p).
        target: Shape (m,).
        instruments: What stands for columns that are noisy themselves, shape (m, p); None: the columns. Weights from a
            biased solution are biased, for they count less where noise and error have one sign.
    """
    own = instruments is None
    instruments = design if instruments is None else instruments
    smallest = np.finfo(float).eps * float(np.abs(target).max()) + np.finfo(float).tiny
    weights = np.ones(len(target))
    for _ in range(REWEIGHTINGS):
        weighted = instruments * weights[:, None]
        solution = np.linalg.pinv(weighted.T @ design, rcond=CUTOFF, hermitian=own) @ (weighted.T @ target)
        residual = np.abs(target - design @ solution).clip(min=smallest)
        weights = np.minimum(HUBER * SIGMA_PER_MEDIAN * np.median(residual) / residual, 1.0)
    return weights
