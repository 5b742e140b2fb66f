"""How far the gap between model and measurement closed, on cycles that no choice was made on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

ROUNDING = 1e-12
"""Of a root mean square that was added up in another order."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Gap:
    """The gap before and after effects were added.

    Attributes:
        before: Root mean square of what the nominal model leaves. [unit of the response]
        after: The same for the augmented model.
        floor: Root mean square of the noise, below which nothing can be closed.
        shrink: (before - after) / (before - floor); NaN where the gap is at the floor from the start.
        shrink_se: Standard error of shrink from leaving out one cycle at a time, the floor taken as known.
        over_floor: after / floor; infinite for a floor of 0.
        cycles: Number of locked cycles.
    """

    before: float
    after: float
    floor: float
    shrink: float
    shrink_se: float
    over_floor: float
    cycles: int


def measure_gap(before: Float, after: Float, floor: float, cycle: NDArray[np.int64]) -> Gap:
    """Compares residuals on locked cycles.

    Args:
        before: Residual of the nominal model, shape (n,).
        after: Residual of the augmented model, shape (n,).
        floor: Root mean square of the noise.
        cycle: Number of the cycle of each sample, shape (n,).

    Returns:
        The gap, each sample counting once.
    """
    _, number = np.unique(cycle, return_inverse=True)
    samples = np.bincount(number).astype(float)
    sums = np.stack([np.bincount(number, weights=r**2) for r in (before, after)]).astype(float)
    total = sums.sum(axis=1)
    rms_before, rms_after = np.sqrt(total / samples.sum())
    return Gap(
        before=float(rms_before),
        after=float(rms_after),
        floor=floor,
        shrink=float(_shrink(rms_before, rms_after, floor)),
        shrink_se=_jackknife_se(sums, samples, floor),
        over_floor=float(rms_after / floor) if floor > 0 else float("inf"),
        cycles=len(samples),
    )


def _shrink(before: Float, after: Float, floor: float) -> Float:
    """Closed share of what can be closed; NaN where there is nothing to close."""
    open_gap = np.asarray(before) - floor
    wide = open_gap > ROUNDING * np.asarray(before)
    return np.where(wide, (before - after) / np.where(wide, open_gap, 1.0), np.nan)


def _jackknife_se(sums: Float, samples: Float, floor: float) -> float:
    """Standard error by leaving out one cycle at a time; NaN for a single cycle (jackknife over cycles)."""
    m = len(samples)
    if m == 1:
        return float("nan")
    before, after = np.sqrt((sums.sum(axis=1)[:, None] - sums) / (samples.sum() - samples))
    without = _shrink(before, after, floor)
    return float(np.sqrt((m - 1) / m * np.sum((without - without.mean()) ** 2)))
