"""Friction that is another from stroke to stroke and follows no quantity: what a model leaves turns with the direction.

Noise of a sensor knows nothing of the direction of motion: the means that it leaves over neighbouring strokes are
independent, or alike where it remembers. Friction that is too high for a while pushes the means of neighbouring
strokes, which go opposite ways, apart. Their products have mean zero, or above, without it; the sum over its own
root sum of squares is about normal (V. de la Pena, T. L. Lai, Q.-M. Shao, Self-normalized processes, 2009).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

FEWEST_ROWS = 5
FEWEST_PAIRS = 12
LEAST_Z = 3.3
"""One in two thousand joints without it."""
LEAST_SHARE = 0.3
"""Of what a model leaves: a smaller scatter is told of no joint."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StrokeScatter:
    """Friction that changes from stroke to stroke.

    Attributes:
        rms_nm: Root mean square of its change. [N m]
        strokes: Pairs of neighbouring strokes that show it.
    """

    rms_nm: float
    strokes: int

    @property
    def message(self) -> str:
        """What people are told."""
        return f"friction is another from stroke to stroke, by {self.rms_nm:.2g} N m rms, and follows nothing recorded"


def find_stroke_scatter(left: Float, forwards: NDArray[np.bool_], run: NDArray[np.int64]) -> StrokeScatter | None:
    """Look whether what a model leaves turns with the direction.

    Args:
        left: Measured less simulated torque, shape (m,). [N m]
        forwards: Direction of each row, shape (m,).
        run: Number of the unbroken stretch of each row, shape (m,).

    Returns:
        The scatter; None where there is none, or too few strokes to tell.
    """
    stroke = np.cumsum(np.concatenate([[False], (np.diff(forwards) != 0) | (np.diff(run) != 0)]))
    rows = np.bincount(stroke)
    mean = np.bincount(stroke, weights=left) / rows
    way = forwards[np.searchsorted(stroke, np.arange(len(rows)))]
    long = rows >= FEWEST_ROWS
    opposite = long[1:] & long[:-1] & (way[1:] != way[:-1])
    product = (mean[1:] * mean[:-1])[opposite]
    size = float(np.sqrt(np.sum(product**2)))
    if len(product) < FEWEST_PAIRS or size == 0.0 or np.sum(product) > -LEAST_Z * size:
        return None
    rms = float(np.sqrt(-np.mean(product)))
    if rms < LEAST_SHARE * float(np.sqrt(np.mean(left**2))):
        return None
    return StrokeScatter(rms_nm=rms, strokes=len(product))
