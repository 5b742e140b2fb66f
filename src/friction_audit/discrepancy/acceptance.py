"""How much an effect removes, and whether its size is the same everywhere.

References:
    A. C. Cameron, J. B. Gelbach, D. L. Miller, Review of Economics and Statistics 90 (2008) 414.
    W. G. Cochran, The combination of estimates from different experiments, Biometrics 10 (1954) 101.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Index = NDArray[np.int64]
LEAST_GAIN = 0.005
"""Smallest gain of the root mean square that is worth a name."""
LEAST_STRENGTH = 1.0 / 3.0
"""An effect that falls below this share of its size in some part of the log is not one effect."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Stability:
    """Size of an effect in parts of the log, relative to its size in the whole.

    Attributes:
        strength: Of each part, 1 where it is as large as in the whole; NaN where the part cannot show it, shape (k,).
        se: Standard errors from cycles, shape (k,).
        p_value: That all are equal (Cochran's Q); NaN if fewer than two parts can show it.
    """

    strength: Float
    se: Float
    p_value: float

    def stable(self, alpha: float = 0.01) -> bool:
        """No part without the effect, and no more scatter than cycles explain, or too little of it to matter."""
        known = self.strength[np.isfinite(self.strength)]
        if len(known) == 0:
            return False
        even = bool(np.all((known > 1.0 - LEAST_STRENGTH) & (known < 1.0 + LEAST_STRENGTH)))
        return bool(np.all(known > LEAST_STRENGTH)) and (even or not self.p_value < alpha)


def rms_gain(before: float, after: float) -> float:
    """Share of the root mean square that an effect removes, from residual sums of squares before and after."""
    return 1.0 - float(np.sqrt(after / before)) if before > 0 else 0.0


def stability(
    y: Float, base: Float, effect: Float, cycle: Index, part: Index, weights: Float | None = None
) -> Stability:
    """Size of an effect in each part of the log: folds, halves (early and late), directions.

    The effect's torque as fitted on the whole is one column; its factor with the base refitted in each part is the
    strength there, so that the answer does not depend on how the effect's columns are written. Standard errors are
    cluster-robust over cycles with the correction C/(C-1) (Cameron, Gelbach and Miller 2008).

    Args:
        y: Response, shape (n,).
        base: All other columns of the model, shape (n, b).
        effect: Columns of the effect, shape (n, p).
        cycle: Number of the cycle of each sample, shape (n,).
        part: Number of the part of each sample, -1 for none, shape (n,).
        weights: Weight of each sample; 1 if None.

    Returns:
        Strengths of the parts in ascending order of their numbers.
    """
    root = np.ones(len(y)) if weights is None else np.sqrt(weights)
    y, base, effect = y * root, base * root[:, None], effect * root[:, None]
    torque = effect @ np.linalg.lstsq(np.hstack([base, effect]), y, rcond=None)[0][base.shape[1] :]
    size = float(torque @ torque) / len(y)
    parts = [part == k for k in np.unique(part[part >= 0])]
    pairs = [_strength(y[at], base[at], torque[at], cycle[at], size) for at in parts]
    strength, se = np.array(pairs).T
    return Stability(strength=strength, se=se, p_value=_cochran(strength, se))


def _strength(y: Float, base: Float, torque: Float, cycle: Index, size: float) -> tuple[float, float]:
    """Factor of one column with the base refitted, and its cluster-robust standard error; NaN if it cannot be seen."""
    free = torque - base @ np.linalg.lstsq(base, torque, rcond=None)[0]
    square = float(free @ free)
    _, number = np.unique(cycle, return_inverse=True)
    cycles = int(number.max()) + 1
    if cycles < 3 or square < 1e-6 * size * len(y):  # noqa: PLR2004 - two cycles have no spread to speak of
        return float("nan"), float("nan")
    factor = float(free @ y) / square
    rest = y - base @ np.linalg.lstsq(base, y, rcond=None)[0] - factor * free
    score = np.bincount(number, weights=free * rest)
    return factor, float(np.sqrt(cycles / (cycles - 1) * np.sum(score**2))) / square


def _cochran(strength: Float, se: Float) -> float:
    """P-value of Q = sum (b_k - mean)^2 / se_k^2 as chi square with k - 1 degrees of freedom (Cochran 1954)."""
    from scipy.stats import chi2

    known = np.isfinite(strength) & (se > 0)
    if known.sum() < 2:  # noqa: PLR2004 - one value equals itself
        return float("nan")
    w = 1.0 / se[known] ** 2
    mean = np.sum(w * strength[known]) / w.sum()
    return float(chi2.sf(np.sum(w * (strength[known] - mean) ** 2), known.sum() - 1))
