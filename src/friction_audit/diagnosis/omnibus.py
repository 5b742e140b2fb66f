"""Is anything missing at all? A wild cluster bootstrap over cycles of the largest score among all candidates.

References:
    A. C. Cameron, J. B. Gelbach, D. L. Miller, Bootstrap-based improvements for inference with clustered errors,
    Review of Economics and Statistics 90 (2008) 414: the bootstrap with the null imposed.
    X. Shao, The dependent wild bootstrap, Journal of the American Statistical Association 105 (2010) 218: neighbours
    that are not independent get weights that are not.
    M. D. Webb, Reworking wild bootstrap-based inference for clustered errors, Canadian Journal of Economics 56
    (2023) 839 (working paper 2014): weights for few clusters.
    J. P. Romano, M. Wolf, Exact and approximate stepdown methods for multiple hypothesis testing, Journal of the
    American Statistical Association 100 (2005) 94: the maximum, and the step-down.
    J. P. Romano, M. Wolf, Balanced control of generalized error rates, Annals of Statistics 38 (2010) 598: a maximum in
    which every candidate has the same chance to be the largest by accident.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.cycle_scores import CycleScores
from friction_audit.diagnosis.groups import Group
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

Index = NDArray[np.int64]
FEW_CYCLES = 13
"""Below this number of cycles two-point signs give too few different draws (Webb 2023)."""
MEMORIES_PER_CLUSTER = 5.0
"""Integral times of the noise in a cluster: neighbours then correlate by about 0.1."""
LEAST_CLUSTERS = 12
"""Below this number of clusters the test loses more power than correlation costs in errors."""
FEW_TO_TEST = 30
"""Fewer cycles than this are cut into parts."""
MEMORIES_PER_PART = 1.5
"""Integral times of the noise in a part of a cycle: where cycles are few, power matters more than the correlation of
about 0.3 that neighbours then have."""
MEMORIES_TO_FORGET = 3.0
"""Integral times of the noise from which neighbouring clusters count as independent."""
MIN_SPARE_CYCLES = 3
"""Cycles that must remain beyond the number of base and candidate columns."""
WEBB = np.sqrt(np.array([1.5, 1.0, 0.5, 0.5, 1.0, 1.5])) * np.array([-1, -1, -1, 1, 1, 1])
"""The six points of Webb (2023), each with probability 1/6: mean 0, variance 1."""

CHANCE = 0.95
"""Quantile of a candidate's draws from which it is counted."""
TIE = 1e-9
"""Statistics that differ by less than this share are equal: one library or processor rounds them otherwise."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Omnibus:
    """Outcome of the test.

    Attributes:
        p_value: Probability, with nothing missing, of so large a maximum over all candidates and shapes.
        names: Names of the candidates.
        adjusted_p: Step-down family-wise p-value of each candidate, shape (m,).
        cycles: Number of cycles.
    """

    p_value: float
    names: tuple[str, ...]
    adjusted_p: Float
    cycles: int


def omnibus_test(  # noqa: PLR0913
    y: Float,
    base: Float,
    groups: Sequence[Group],
    cycle: Index,
    rng: np.random.Generator,
    *,
    draws: int = 999,
    remember: bool = False,
    weight: Float | None = None,
    at: Index | None = None,
) -> Omnibus:
    """Tests all candidates at once; the family-wise error holds under correlated candidates and serial dependence.

    With W the columns of a candidate free of the base and e the residual of the base, the score of cycle c is
    s_c = W_c' e_c and the statistic q = (sum s)' (sum s s')^-1 (sum s). A draw gives each cycle a weight g_c and refits
    the base to g_c e_c (Cameron, Gelbach and Miller 2008; ``cycle_scores``).
    Shapes of different width are compared through the p-value that q / cycles would have as
    Beta(p/2, (cycles - p)/2) variate, exact for independent normal scores; candidates by how far the largest of their
    shapes is above what chance gives that one in twenty draws (:func:`balanced`).

    Args:
        y: Response, shape (n,).
        base: Columns of the declared model, shape (n, b).
        groups: Candidates.
        cycle: Number of the cycle of each sample, or of its cluster where the noise remembers more than a fifth of a
            cycle (:func:`independent_clusters`), shape (n,).
        rng: Source of randomness.
        draws: Number of bootstrap draws.
        remember: Whether neighbours in the order of the numbers are not independent (:func:`neighbours_remember`).
        weight: What all samples of response, base and candidates are multiplied by, None for 1, shape (n,).
        at: Which samples of the candidates' columns these n are, all if None, shape (n,).

    Returns:
        The test.

    Raises:
        AnalysisError: No candidate, values that are not finite, or fewer cycles than columns allow.
    """
    _, number = np.unique(cycle, return_inverse=True)
    cycles = int(number.max()) + 1
    _check(cycles, base.shape[1], groups)
    weights = bootstrap_weights(rng, draws, cycles, remember=remember)
    scores = CycleScores(*_weighted(y, base, weight), number, cycles, weights, weight, at)
    largest = [scores.largest(group) for group in groups]
    observed, drawn = balanced(np.array([own for own, _ in largest]), np.array([drawn for _, drawn in largest]))
    return Omnibus(
        p_value=float((1 + np.sum(drawn.max(axis=0) >= _reached(observed.max()))) / (draws + 1)),
        names=tuple(group.name for group in groups),
        adjusted_p=step_down(observed, drawn),
        cycles=cycles,
    )


def independent_clusters(cycle: Index, integral_samples: float) -> Index:
    """Puts neighbouring cycles together until each cluster outlasts the memory of the noise.

    The bootstrap takes clusters for independent. Where the noise remembers a good part of a cycle, single cycles are
    not: the sums of neighbours correlate about as integral time / (2 duration).

    Args:
        cycle: Number of the cycle of each sample, in the order of time, shape (n,).
        integral_samples: Integral time of the noise's autocorrelation, n / n_eff. [samples]

    Returns:
        Number of the cluster of each sample, shape (n,): five integral times or more each, as far as twelve clusters
        remain.
    """
    numbers, position = np.unique(cycle, return_inverse=True)
    wanted = int(np.ceil(MEMORIES_PER_CLUSTER * integral_samples * len(numbers) / len(cycle)))
    clusters = max(min(len(numbers), LEAST_CLUSTERS), len(numbers) // max(1, wanted))
    return np.asarray(position * clusters // len(numbers), dtype=np.int64)


def cut_cycles(cycle: Index, integral_samples: float) -> Index:
    """Cuts the cycles of a short log into parts, for a test needs many; others are put together as independent.

    Args:
        cycle: Number of the cycle of each sample, in the order of time, shape (n,).
        integral_samples: Integral time of the noise's autocorrelation. [samples]

    Returns:
        Number of the part of each sample, shape (n,). Of fewer than 30 cycles, equal parts of each that outlast the
        noise's memory one and a half times, and at least as many as make twelve; of more, :func:`independent_clusters`.
    """
    numbers, first, position, length = np.unique(cycle, return_index=True, return_inverse=True, return_counts=True)
    if len(numbers) >= FEW_TO_TEST:
        return independent_clusters(cycle, integral_samples)
    most, least = (int(np.ceil(total / len(numbers))) for total in (FEW_TO_TEST, LEAST_CLUSTERS))
    parts = np.clip(length / (MEMORIES_PER_PART * max(integral_samples, 1.0)), least, most).astype(np.int64)
    parts = np.minimum(parts, length)
    place = np.arange(len(cycle)) - first[position]
    part = place * parts[position] // length[position]
    return np.asarray((np.cumsum(parts) - parts)[position] + part, dtype=np.int64)


def even_weights(residual: Float, cluster: Index, cycles: int) -> Float:
    """Weights of samples that keep a few lively clusters from deciding alone: one over the root of a cluster's rms.

    The score of a cluster in which something is missing grows with the square of its size there; few clusters of very
    different scores prove little. Where there are at least thirty cycles all samples count alike.

    Args:
        residual: What the base leaves, shape (n,).
        cluster: Number of the cluster of each sample, shape (n,).
        cycles: Number of cycles that the clusters were made from.
    """
    if cycles >= FEW_TO_TEST:
        return np.ones(len(residual))
    _, place, length = np.unique(cluster, return_inverse=True, return_counts=True)
    size = np.sqrt(np.bincount(place, weights=residual**2) / length)
    least = np.finfo(float).eps * max(float(size.max()), 1.0)
    return np.asarray(1.0 / np.sqrt(np.maximum(size, least))[place])


def neighbours_remember(cluster: Index, integral_samples: float) -> bool:
    """Whether the noise outlasts a third of a cluster, as where a log is too short for clusters that forget."""
    return len(cluster) / len(np.unique(cluster)) < MEMORIES_TO_FORGET * integral_samples


def bootstrap_weights(rng: np.random.Generator, draws: int, cycles: int, *, remember: bool = False) -> Float:
    """Weights of mean 0 and variance 1, shape (draws, cycles): signs, or Webb's six points for few cycles.

    Signs of neighbours that remember each other are those of normal variates with a correlation of a half (Shao 2010).
    """
    if remember:
        normal = rng.standard_normal((draws, cycles + 1))
        return np.where(normal[:, 1:] + normal[:, :-1] > 0.0, 1.0, -1.0)
    points = WEBB if cycles < FEW_CYCLES else np.array([-1.0, 1.0])
    return rng.choice(points, size=(draws, cycles))


def balanced(observed: Float, drawn: Float) -> tuple[Float, Float]:
    """Statistics less what each candidate reaches by chance in one draw of twenty (Romano and Wolf 2010).

    A candidate with a hundred shapes reaches high by chance; in a plain maximum it would hide one with a single shape.
    Far out, the tails of all of them fall alike, so that a shift is all that balance takes.

    Args:
        observed: Largest statistic of each candidate, shape (m,).
        drawn: The same under the null, shape (m, draws).

    Returns:
        Both, shifted. What was observed counts as one more draw, so that all of them are exchangeable.
    """
    chance = np.quantile(np.column_stack([observed, drawn]), CHANCE, axis=1)
    return observed - chance, drawn - chance[:, None]


def step_down(observed: Float, drawn: Float) -> Float:
    """Family-wise p-values by step-down maxima (Romano and Wolf 2005).

    Args:
        observed: Statistic of each hypothesis, shape (m,).
        drawn: The same under the null, shape (m, draws).

    Returns:
        Adjusted p-values, shape (m,).
    """
    order = np.argsort(-observed, kind="stable")
    # From the smallest statistic up: the maximum over all hypotheses that are not yet rejected.
    maxima = np.maximum.accumulate(drawn[order][::-1], axis=0)[::-1]
    p = (1.0 + np.sum(maxima >= _reached(observed[order][:, None]), axis=1)) / (drawn.shape[1] + 1.0)
    adjusted = np.empty_like(observed)
    adjusted[order] = np.maximum.accumulate(p)
    return adjusted


def _reached(observed: Float) -> Float:
    """What a draw must reach to count as equal: one with all signs alike is the observation itself, up to rounding."""
    return np.asarray(observed - TIE * np.abs(observed))


def _weighted(y: Float, base: Float, weight: Float | None) -> tuple[Float, Float]:
    """Response and base, both times the weights of the samples; the columns of the base with a norm of 1."""
    if not (np.all(np.isfinite(y)) and np.all(np.isfinite(base))):
        raise AnalysisError("omnibus test: response or base holds values that are not finite; leave those samples out")
    if weight is not None:
        y, base = y * weight, base * weight[:, None]
    norm = np.linalg.norm(base, axis=0)
    return y, base / np.where(norm > 0, norm, 1.0)


def _check(cycles: int, base: int, groups: Sequence[Group]) -> None:
    if not groups:
        raise AnalysisError("omnibus test: no candidate, expected at least one that the log can show")
    widest = max(shape.shape[1] for group in groups for shape in group.shapes)
    needed = base + widest + MIN_SPARE_CYCLES
    if cycles < needed:
        raise AnalysisError(
            f"omnibus test: {cycles} cycles, expected at least {needed} for {base} base and {widest} candidate columns;"
            " record more cycles"
        )
