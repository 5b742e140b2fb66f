"""How much a sample of a residual is worth: its memory, a filter that takes it away, and the floor of the noise.

References:
    C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473: initial positive sequence.
    J. Durbin, The fitting of time-series models, Review of the International Statistical Institute 28 (1960) 233.
    G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978) 461.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Index = NDArray[np.int64]
FEWEST_PAIRS = 0.1
"""Lags for which less than this share of the samples has a partner are not looked at."""
LONGEST_MEMORY = 500
HIGHEST_ORDER = 8
WHITE_FLOOR = 0.02
"""White noise added to the autocovariance, as a share of the variance. The data were low-passed below their Nyquist
frequency: there is nothing above the corner, and a filter that made even that band white would weigh it most."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Autoregression:
    """e[i] = sum of a[k] e[i-1-k] plus white noise.

    Attributes:
        coefficients: a, shape (p,).
        sigma: Standard deviation of the white part.
    """

    coefficients: Float
    sigma: float


def runs_of(used: NDArray[np.bool_], cycle: Index) -> Index:
    """Number the unbroken stretches of used samples of one cycle, -1 elsewhere, shape (n,)."""
    begins = used & (np.append(True, ~used[:-1]) | np.append(True, cycle[1:] != cycle[:-1]))
    return np.where(used, np.cumsum(begins) - 1, -1)


def autocovariance(residual: Float, run: Index, lags: int) -> tuple[Float, Index]:
    """Sum the products of samples of one run, about a mean of zero.

    Args:
        residual: Shape (n,).
        run: From ``runs_of``, shape (n,).
        lags: Largest lag.

    Returns:
        Sums of products and numbers of pairs for lags 0 to ``lags``, shape (lags + 1,) each.
    """
    sums, pairs = np.zeros(lags + 1), np.zeros(lags + 1, np.int64)
    kept = np.where(run >= 0, residual, 0.0)
    for lag in range(min(lags, len(residual) - 1) + 1):
        same = (run[lag:] == run[: len(run) - lag]) & (run[lag:] >= 0)
        sums[lag] = np.dot(kept[lag:] * same, kept[: len(run) - lag])
        pairs[lag] = same.sum()
    return sums, pairs


def integral_time(residual: Float, run: Index) -> float:
    """Samples that are worth one: 1 + 2 sum of the autocorrelations, at least 1 (initial positive sequence).

    Args:
        residual: Shape (n,).
        run: From ``runs_of``, shape (n,).
    """
    _, lengths = np.unique(run[run >= 0], return_counts=True)
    if not len(lengths):
        return 1.0
    sums, pairs = autocovariance(residual, run, int(min(lengths.max() - 1, LONGEST_MEMORY)))
    told = pairs >= max(FEWEST_PAIRS * pairs[0], 2)
    gamma = (sums / np.maximum(pairs, 1))[told]
    if len(gamma) == 1 or gamma[0] <= 0:
        return 1.0
    rho = gamma[: len(gamma) // 2 * 2] / gamma[0]
    pair_sums = rho[0::2] + rho[1::2]
    ends = np.flatnonzero(pair_sums <= 0)
    kept = pair_sums[: ends[0]] if len(ends) else pair_sums
    return max(2.0 * float(kept.sum()) - 1.0, 1.0)


def effective_samples(residual: Float, run: Index) -> float:
    """Return n / tau_int of the samples in runs."""
    return float((run >= 0).sum()) / integral_time(residual, run)


def fit_autoregression(
    residual: Float, run: Index, *, highest_order: int = HIGHEST_ORDER, white_floor: float = WHITE_FLOOR
) -> Autoregression:
    """Fit an AR(p) inside runs, p by Schwarz' criterion, each order of Durbin's recursion stable by construction.

    What an order is worth is counted in effective samples of the residual, so that a slow misfit of the model, which
    is a handful of independent facts, does not buy a long memory.

    Args:
        residual: Shape (n,).
        run: From ``runs_of``, shape (n,).
        highest_order: Largest p.
        white_floor: Share of white noise added.
    """
    sums, pairs = autocovariance(residual, run, highest_order)
    if sums[0] <= 0:
        return Autoregression(coefficients=np.zeros(0), sigma=0.0)
    # Divided by all samples and not by pairs, the sequence is that of a stationary process, so the filter is stable.
    gamma = sums / pairs[0]
    gamma[0] *= 1.0 + white_floor
    n_eff = effective_samples(residual, run)
    a, variance = np.zeros(0), float(gamma[0])
    best, best_score = (a, variance), n_eff * np.log(variance)
    for order in range(1, highest_order + 1):
        reflection = (gamma[order] - a @ gamma[order - 1 : 0 : -1]) / variance
        a = np.append(a - reflection * a[::-1], reflection)
        variance *= 1.0 - reflection**2
        score = n_eff * np.log(variance) + order * np.log(max(n_eff, 2.0))
        if score < best_score:
            best, best_score = (a, variance), score
    return Autoregression(coefficients=best[0], sigma=float(np.sqrt(best[1])))


def whiten(columns: Float, run: Index, noise: Autoregression) -> tuple[Float, NDArray[np.bool_]]:
    """Take the memory away from columns, shape (n,) or (n, p), never across the border of a run.

    Returns:
        Whitened columns, of the same shape, and the samples that have all predecessors in their run, shape (n,).
    """
    p = len(noise.coefficients)
    white = np.array(columns, np.float64)
    for lag, a in enumerate(noise.coefficients, start=1):
        white[lag:] -= a * columns[:-lag]
    whole = run >= 0
    if p:
        whole[:p] = False
        whole[p:] &= run[p:] == run[:-p]
    return white, whole


FOLDS = 5
KNOTS = 6
WAVES = 3
RIDGE = 1e-3


def noise_floor(torque: Float, motion: Float, base: Float, cycle: Index) -> float:
    """Root mean square that no model of the motion and the time gets below, from cycles it has not seen. [N m]

    A flexible curve of every motion variable for each direction is fitted on some cycles and tested on the others, and
    the smaller of its error and that of the base counts. It is an upper bound of the noise, for it holds what the
    curves do not learn; noise at standstill is a lower one, for the sensor of a moving joint sees vibration too.

    Args:
        torque: Shape (n,). [N m]
        motion: Velocity in the first column, then whatever else friction may depend on, shape (n, k).
        base: Columns of the declared model, shape (n, b).
        cycle: Number of the cycle of each sample, shape (n,).
    """
    flexible = np.column_stack([base, _curves(motion)])
    return min(_error_unseen(torque, columns, cycle) for columns in (base, flexible))


def _curves(motion: Float) -> Float:
    """Hats on quantiles of each variable, and waves over its span, each for both directions."""
    up = motion[:, :1] > 0
    columns = []
    for variable in motion.T:
        knots = np.unique(np.quantile(variable, np.linspace(0, 1, KNOTS)))
        if len(knots) == 1:
            continue
        hats = np.column_stack([np.interp(variable, knots, row) for row in np.eye(len(knots))])
        phase = np.pi * (variable - knots[0]) / (knots[-1] - knots[0])
        waves = np.column_stack([f(k * phase) for k in range(1, WAVES + 1) for f in (np.sin, np.cos)])
        columns += [hats * up, hats * ~up, waves]
    return np.column_stack(columns) if columns else np.zeros((len(motion), 0))


def _error_unseen(y: Float, columns: Float, cycle: Index) -> float:
    names, number = np.unique(cycle, return_inverse=True)
    fold = number % min(FOLDS, len(names))
    if len(names) == 1:
        return float(np.sqrt(np.mean(y**2)))
    scale = np.sqrt(np.mean(columns**2, axis=0)).clip(min=np.finfo(float).tiny)
    scaled = columns / scale
    parts = [(scaled[fold == k], y[fold == k]) for k in range(fold.max() + 1)]
    grams = [x.T @ x for x, _ in parts]
    rights = [x.T @ part for x, part in parts]
    total = 0.0
    for (x, part), gram, right in zip(parts, grams, rights, strict=True):
        normal = sum(grams) - gram
        ridge = RIDGE * (len(y) - len(part)) * np.eye(len(normal))
        total += float(np.sum((part - x @ np.linalg.solve(normal + ridge, sum(rights) - right)) ** 2))
    return float(np.sqrt(total / len(y)))
