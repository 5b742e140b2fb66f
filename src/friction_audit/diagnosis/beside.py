"""One effect after another fitted beside the same columns, which are dealt with once.

With M the projection away from the columns, the factors of an effect W beside them are those of M W to M y
(R. Frisch, F. V. Waugh, Partial time regressions as compared with individual trends, Econometrica 1 (1933) 387).
"""

import numpy as np

from friction_audit.joint_log import Float

COPY = 1e-10
"""Singular value, of columns with a root mean square of 1 and over the root of their length, of what is a copy."""


class Beside:
    """Fits to one response beside columns that stay."""

    def __init__(self, columns: Float, y: Float) -> None:
        """Take the columns (n, b) and the response (n,)."""
        left, size, _ = np.linalg.svd(columns / _scale(columns), full_matrices=False)
        self.span = left[:, size > COPY * size[0]] if size.size else left
        self.response = self.free(y)

    @property
    def without(self) -> float:
        """Residual sum of squares of the columns alone."""
        return float(self.response @ self.response)

    def fit(self, own: Float) -> tuple[Float, float]:
        """Factors of an effect's columns (n, p), the smallest of those that do alike, (p,), and the sum of squares."""
        scale = _scale(own)
        # The triangle of columns and response has all that is asked of them, in p + 1 rows.
        both = np.vstack([self.free(own / scale).T, self.response]).T
        triangle = np.asarray(np.linalg.qr(both, mode="r"))
        left, size, right = np.linalg.svd(triangle[:, :-1], full_matrices=False)
        there = size > COPY * np.sqrt(len(own))
        along = left.T @ triangle[:, -1]
        factors = right.T @ np.where(there, along / np.where(there, size, 1.0), 0.0) / scale
        factors[_mean_square(own) == 0.0] = 0.0  # not the rounding of a zero, whose sign may be impossible
        rest = triangle[:, -1] - left[:, there] @ along[there]
        return factors, float(rest @ rest)

    def left_above_zero(self, own: Float) -> float:
        """Residual sum of squares of an effect's columns (n, p) whose factors are not below zero."""
        from scipy.optimize import nnls

        # The triangle of columns and response has their cross products, and few rows.
        _, triangle = np.linalg.qr(np.column_stack([self.free(own / _scale(own)), self.response]))
        _, rest = nnls(triangle[:, :-1], triangle[:, -1])
        return float(rest) ** 2

    def left(self, own: Float) -> Float:
        """What an effect's columns (n, p) leave, shape (n,)."""
        if not own.shape[1]:
            return self.response
        left, size, _ = np.linalg.svd(self.free(own / _scale(own)), full_matrices=False)
        span = left[:, size > COPY * np.sqrt(len(own))]
        return np.asarray(self.response - span @ (span.T @ self.response))

    def free(self, signal: Float) -> Float:
        """What the columns alone leave of signals, shape (n,) or (n, p)."""
        # Of transposes, for columns lie one behind the other.
        return np.asarray((signal.T - (signal.T @ self.span) @ self.span.T).T)


def _scale(columns: Float) -> Float:
    scale = np.sqrt(_mean_square(columns))
    return np.asarray(np.where(scale > 0, scale, 1.0))


def _mean_square(columns: Float) -> Float:
    """Of each column, shape (p,), without a copy of them."""
    return np.asarray(np.einsum("ij,ij->j", columns, columns) / len(columns))
