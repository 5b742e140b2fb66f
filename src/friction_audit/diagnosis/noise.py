"""Noise of the samples: AR(p) within unbroken stretches, and a model error that is larger where formulas are worse.

W. A. Fuller, Introduction to Statistical Time Series (1996), section 8; N. Levinson, J. Math. Phys. 25 (1947) 261.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float, Int

MOST_LAGS = 8  # of those with 50 pairs of samples, or half of a short log: Box and Jenkins ask for 50
LOADING = 0.05  # white part of the variance: plain AR weights frequencies that hold nothing but the filter's stop band
LARGEST_REFLECTION = 0.98  # autocovariances over broken stretches need not be positive definite


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NoiseModel:
    """AR(p) noise with unequal variances."""

    predictors: Float  # coefficients of the predictors of order 0 to p, shape (p + 1, p)
    scales: Float  # one over the standard deviation of their errors, shape (p + 1,)
    age: Int  # samples before each one in its stretch, at most p, shape (m,)
    weight: Float  # standard deviation of the noise over that with the model error, 0..1, shape (m,)
    effective_samples: float  # squared innovations of the residual: samples less what filter and loading took

    def whiten(self, columns: Float) -> Float:
        """Innovations of columns, shape (k, m)."""
        weighted = np.ascontiguousarray(np.atleast_2d(columns) * self.weight)
        return _whiten(weighted, self.predictors, self.scales, self.age)

    def transposed(self, innovations: Float) -> Float:
        """The transpose of whitening, on innovations, shape (k, m)."""
        rows = np.ascontiguousarray(np.atleast_2d(innovations))
        return np.asarray(_transposed(rows, self.predictors, self.scales, self.age) * self.weight)

    def log_likelihood(self, residual: Float) -> float:
        """Logarithm of the likelihood of a residual, shape (m,), at its best variance, up to a constant."""
        white = self.whiten(residual)
        return float(np.log(self.scales[self.age] * self.weight).sum() - 0.5 * white.size * np.log(np.mean(white**2)))

    @classmethod
    def fit(cls, age: Int, residuals: Sequence[Float], model_error: Float) -> "NoiseModel":
        """Fit to what models leave, and the standard deviation of the model error, shape (m,) each. [N m]

        Of several residuals that with the shortest autocorrelation time counts: what a model misses remembers longer
        than the noise.
        """
        found: list[tuple[float, NoiseModel]] = []
        later = [k for lag in range(MOST_LAGS + 1) if len(k := np.flatnonzero(age >= lag)) >= min(len(age) / 2, 50)]
        for residual in residuals:
            # The model error is part of what is left: what remains of the variance where it is small is the noise.
            calm = model_error <= np.median(model_error)
            whole, wrong = (float(np.mean(one[calm] ** 2)) for one in (residual, model_error))
            variance = max(whole - wrong, 0.25 * whole)
            weight = np.sqrt(variance / (variance + model_error**2))
            # An offset that is not in the model yet would pass for noise with a long autocorrelation time.
            scaled = (residual - np.average(residual, weights=weight**2)) * weight
            sums = np.array([scaled[k] @ scaled[k - lag] / len(k) for lag, k in enumerate(later)])
            sums[0] *= 1.0 + LOADING
            predictors, errors = levinson_durbin(sums)
            n = len(residual)
            criterion = [n * np.log(errors[k]) + 2 * k * n / (n - k - 2) for k in range(len(later))]  # AICc
            p = int(np.argmin(criterion))
            time = errors[p] / max((1.0 - predictors[p, :p].sum()) ** 2, 1e-9) / errors[0]
            noise = cls(
                predictors=predictors[: p + 1, : max(p, 1)].copy(),
                scales=1.0 / np.sqrt(errors[: p + 1]),
                age=np.minimum(age, p),
                weight=weight,
                effective_samples=float(n),
            )
            squared = float(np.sum(noise.whiten(residual) ** 2))
            found.append((time, replace(noise, effective_samples=min(squared, float(n)))))
        return min(found, key=lambda one: one[0])[1]


def levinson_durbin(covariance: Float) -> tuple[Float, Float]:
    """Predictors of all orders, shape (p + 1, p), and the variances of their errors, shape (p + 1,)."""
    p = len(covariance) - 1
    predictors, errors = np.zeros((p + 1, p)), np.empty(p + 1)
    errors[0] = covariance[0]
    for k in range(1, p + 1):
        before = predictors[k - 1, : k - 1]
        reflection = (covariance[k] - before @ covariance[k - 1 : 0 : -1]) / errors[k - 1]
        reflection = float(np.clip(reflection, -LARGEST_REFLECTION, LARGEST_REFLECTION))
        predictors[k, : k - 1] = before - reflection * before[::-1]
        predictors[k, k - 1] = reflection
        errors[k] = errors[k - 1] * (1.0 - reflection**2)
    return predictors, errors


@compiled("f8[:, ::1](f8[:, ::1], f8[:, ::1], f8[::1], i8[::1])")
def _whiten(columns: Float, predictors: Float, scales: Float, age: Int) -> Float:
    order, n = len(predictors) - 1, columns.shape[1]
    out = columns.copy()
    for k in range(columns.shape[0]):
        own, row = columns[k], out[k]
        # All as if they were old enough, lag by lag, which a processor does for several samples at once.
        for j in range(order):
            share, late, early = predictors[order, j], row[j + 1 :], own[: n - 1 - j]
            for m in range(len(late)):
                late[m] -= share * early[m]
        for i in range(n):
            row[i] *= scales[order]
            if age[i] >= order:
                continue
            total = own[i]
            for j in range(age[i]):
                total -= predictors[age[i], j] * own[i - 1 - j]
            row[i] = total * scales[age[i]]
    return out


@compiled("f8[:, ::1](f8[:, ::1], f8[:, ::1], f8[::1], i8[::1])")
def _transposed(rows: Float, predictors: Float, scales: Float, age: Int) -> Float:
    out = np.zeros_like(rows)
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            order = age[i]
            scaled = rows[k, i] * scales[order]
            out[k, i] += scaled
            for j in range(order):
                out[k, i - 1 - j] -= predictors[order, j] * scaled
    return out
