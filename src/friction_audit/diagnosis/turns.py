"""What is usual at a joint's reversals and rests: any error of friction is sudden there, and a push must be more."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Samples = NDArray[np.bool_]
MOST_OF_THEM = 0.9
"""Share of the reversals and rests that is usual; some of the others may be pushes."""
FEWEST = 5
"""Reversals and rests, below which nothing is usual."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Turns:
    """Reversals and rests, r of them, in n samples, as f filters see them.

    Attributes:
        number: Of the nearest one to each sample, in the order of time, shape (n,).
        seen: Whether a filter about a sample reaches into one, shape (f, n).
    """

    number: NDArray[np.int64]
    seen: Samples

    def usual(self, size: Float, touched: Samples) -> Float:
        """What nine of ten reach at most, infinite where there are hardly any, shape (f,).

        Args:
            size: What each filter gives, shape (f, n).
            touched: Those that do not count, shape (r,).
        """
        starts = np.searchsorted(self.number, np.arange(len(touched)))
        if not len(starts):
            return np.full(len(size), np.inf)
        largest = np.maximum.reduceat(np.where(self.seen, np.abs(size), -1.0), starts, axis=1)
        counts = (largest >= 0.0) & ~touched
        return np.array(
            [
                np.quantile(one[there], MOST_OF_THEM) if there.sum() >= FEWEST else np.inf
                for one, there in zip(largest, counts, strict=True)
            ]
        )


def nearest_turn(turning: Samples) -> NDArray[np.int64]:
    """Number of the stretch of turning samples that is nearest to each sample, shape (n,); 0 where there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], turning, [False]])))
    middle = 0.5 * (edges[::2] + edges[1::2] - 1)
    return np.searchsorted(0.5 * (middle[1:] + middle[:-1]), np.arange(len(turning))).astype(np.int64)
