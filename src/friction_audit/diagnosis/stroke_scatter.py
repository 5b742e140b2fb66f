"""Friction that is another now and then and follows no quantity: what a model leaves turns with the direction.

Noise of a sensor knows nothing of the direction of motion: a product of what is left at two moments is as large on
average whether the joint went the same way at both or not, whatever the noise's colour. Friction that is too high for a
while makes products of the same way larger, and of opposite ways smaller. With s the direction, r what is left and
c(l) the mean of s s' over pairs of moments that are l apart,

    D = sum of k(l) r r' (s s' - c(l))

over all pairs has mean zero without it. The sum of parts of the recording over its own root sum of squares is about
normal (V. de la Pena, T. L. Lai, Q.-M. Shao, Self-normalized processes, 2009).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

BIN_S = 0.05
REACH_S = 0.3
"""Pairs count by exp(-l / reach): friction that flips within a second is seen."""
PART_PER_REACH = 4.0
FEWEST_REVERSALS = 12
LEAST_Z = 3.0
"""One in seven hundred joints without it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StrokeScatter:
    """Friction that changes from stroke to stroke.

    Attributes:
        rms_nm: Root mean square of its change. [N m]
        reversals: How often the joint turned.
    """

    rms_nm: float
    reversals: int

    @property
    def message(self) -> str:
        """What people are told."""
        return f"friction varies between strokes by {self.rms_nm:.2g} N m rms, independently of everything recorded"


def find_stroke_scatter(left: Float, forwards: NDArray[np.bool_], t: Float) -> StrokeScatter | None:
    """Look whether what a model leaves turns with the direction.

    Args:
        left: Torque that is left, shape (m,). [N m]
        forwards: Whether the joint moves forwards, shape (m,).
        t: Ascending, shape (m,). [s]

    Returns:
        The scatter; None where there is none, or too few reversals to tell.
    """
    reversals = int(np.count_nonzero(np.diff(forwards)))
    if reversals < FEWEST_REVERSALS:
        return None
    excess, weight = _excess(left, np.where(forwards, 1.0, -1.0), ((t - t[0]) / BIN_S).astype(np.int64))
    parts = np.add.reduceat(excess, np.arange(0, len(excess), round(PART_PER_REACH * REACH_S / BIN_S)))
    size = float(np.sqrt(np.sum(parts**2)))
    if size == 0.0 or np.sum(parts) < LEAST_Z * size:
        return None
    return StrokeScatter(rms_nm=float(np.sqrt(np.sum(parts) / weight)), reversals=reversals)


def _excess(left: Float, sign: Float, place: NDArray[np.int64]) -> tuple[Float, float]:
    """What each bin of time gives to D, shape (b,), and by what a covariance of friction is multiplied in their sum."""
    from scipy.fft import irfft, next_fast_len, rfft

    bins = int(place[-1]) + 1
    length = next_fast_len(2 * bins, real=True)
    lag = np.arange(length)
    kernel = np.exp(-np.minimum(lag, length - lag) * BIN_S / REACH_S)
    rows, signs, plain, turned = (
        np.asarray(np.bincount(place, weights=each, minlength=bins), np.float64)
        for each in (np.ones(len(left)), sign, left, sign * left)
    )

    def pairs(values: Float) -> Float:
        return np.asarray(irfft(np.abs(rfft(values, length)) ** 2, length))

    def near(values: Float, weights: Float) -> Float:
        return np.asarray(irfft(rfft(values, length) * rfft(weights), length)[:bins])

    count = np.maximum(pairs(rows), 0.5)
    usual = pairs(signs) / count
    excess = turned * near(turned, kernel) - plain * near(plain, kernel * usual)
    return excess, float(np.sum(kernel * count * (1.0 - usual**2)))
