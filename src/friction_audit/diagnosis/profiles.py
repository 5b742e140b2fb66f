"""Where a residual lies: its mean along every axis, and which axes it depends on."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.problem import Curve
from friction_audit.diagnosis.result import Profile
from friction_audit.joint_log import Float

BINS = 12
FEWEST_ROWS = 5
CLEAR = 2.0
"""Standard errors from which a bin is spoken of."""
FOLDS = 5
COPY = 1e-12
"""Eigenvalue, over the largest one, of the cross products of what is a copy."""


def profile_all(
    residual: Float,
    curves: Sequence[Curve],
    dq: Float,
    cycle: NDArray[np.int64],
    p_values: Mapping[str, float],
) -> tuple[Profile, ...]:
    """The residual along each axis, what takes most of it first.

    Args:
        residual: What a model leaves, shape (m,). [N m]
        curves: A curve per axis.
        dq: Velocity, shape (m,). [rad/s]
        cycle: Number of the cycle of each row, shape (m,).
        p_values: That nothing depends on an axis, by its name; NaN where it was not tested.
    """
    found = [_profile(residual, curve, dq, cycle, p_values.get(curve.axis.name, float("nan"))) for curve in curves]
    return tuple(sorted(found, key=lambda profile: -profile.share))


def _profile(residual: Float, curve: Curve, dq: Float, cycle: NDArray[np.int64], p_value: float) -> Profile:
    edges = np.unique(np.quantile(curve.values, np.linspace(0.0, 1.0, BINS + 1)))
    bins = np.clip(np.searchsorted(edges, curve.values, side="right") - 1, 0, len(edges) - 2)
    centre = np.array([_mean(curve.values[bins == k]) for k in range(len(edges) - 1)])
    up = dq > 0
    forwards, forwards_se = bin_means(residual, bins, cycle, up, len(centre))
    backwards, backwards_se = bin_means(residual, bins, cycle, ~up, len(centre))
    return Profile(
        axis=curve.axis.name,
        label=curve.axis.label,
        edges=edges,
        centre=centre,
        forwards=forwards,
        backwards=backwards,
        forwards_se=forwards_se,
        backwards_se=backwards_se,
        share=_share(residual, curve.columns.T, cycle),
        p_value=p_value,
        where=_where(curve.axis.name, edges, forwards, forwards_se, backwards, backwards_se),
    )


def _mean(values: Float) -> float:
    return float(values.mean()) if len(values) else float("nan")


def bin_means(
    residual: Float, bins: NDArray[np.int64], cycle: NDArray[np.int64], which: NDArray[np.bool_], count: int
) -> tuple[Float, Float]:
    """Mean of each bin and its standard error, the means of the cycles taken as independent.

    Args:
        residual: Shape (m,). [N m]
        bins: Number of the bin of each row, shape (m,).
        cycle: Number of the cycle of each row, shape (m,).
        which: Rows that count, shape (m,).
        count: Number of bins.

    Returns:
        Mean and standard error, NaN where a bin has hardly any row, shape (count,) each. [N m]
    """
    mean, error = np.full(count, np.nan), np.full(count, np.nan)
    for k in range(count):
        at = which & (bins == k)
        if at.sum() < FEWEST_ROWS:
            continue
        _, place = np.unique(cycle[at], return_inverse=True)
        number = np.bincount(place).astype(float)
        mean[k] = float(residual[at].mean())
        deviation = np.bincount(place, weights=residual[at] - mean[k])
        error[k] = float(np.sqrt(np.sum(deviation**2) * len(number) / max(len(number) - 1, 1)) / at.sum())
    return mean, error


def _share(residual: Float, columns: Float, cycle: NDArray[np.int64]) -> float:
    """Share of the mean square that the curve predicts of cycles it has not seen, at least 0."""
    numbers, place = np.unique(cycle, return_inverse=True)
    fold = place % min(FOLDS, len(numbers))
    left, scale = residual.copy(), np.sqrt(np.mean(columns**2, axis=0))
    scaled = columns / np.where(scale > 0, scale, 1.0)
    parts = [np.flatnonzero(fold == k) for k in range(int(fold.max()) + 1)]
    # A fit to the other folds needs no more of them than their cross products.
    grams = np.stack([(own := scaled[part]).T @ own for part in parts])
    rights = np.stack([residual[part] @ scaled[part] for part in parts])
    inverse = np.linalg.pinv(grams.sum(axis=0) - grams, rcond=COPY, hermitian=True)
    for part, factors in zip(parts, (inverse @ (rights.sum(axis=0) - rights)[:, :, None])[:, :, 0], strict=True):
        left[part] -= scaled[part] @ factors
    total = float(np.sum(residual**2))
    return max(0.0, 1.0 - float(np.sum(left**2)) / total) if total > 0 else 0.0


def _where(axis: str, edges: Float, up: Float, up_se: Float, down: Float, down_se: Float) -> str:
    """The stretch of the axis on which the residual is clear and large, and in which direction."""
    size = np.fmax(np.abs(up), np.abs(down))
    clear = (np.abs(up) > CLEAR * up_se) | (np.abs(down) > CLEAR * down_se)
    if not np.any(clear & np.isfinite(size)):
        return ""
    large = clear & (size >= 0.5 * np.nanmax(np.where(clear, size, np.nan)))
    first, last = int(np.flatnonzero(large)[0]), int(np.flatnonzero(large)[-1])
    span = _span(axis, float(edges[first]), float(edges[last + 1]), first == 0, last == len(large) - 1)
    return f"{span}, {_direction(up[large], up_se[large], down[large], down_se[large])}"


UNITS = {
    "speed": "rad/s",
    "position": "rad",
    "displacement": "rad after a reversal",
    "acceleration": "rad/s²",
    "time": "s",
    "load": "N m of load",
    "temperature": "°C",
    "neighbour": "rad/s² of a neighbour",
}


WORDS = {"displacement": "displacement since a reversal", "neighbour": "a neighbour's acceleration"}
"""Axes that are called otherwise in a sentence."""


def _span(axis: str, low: float, high: float, from_start: bool, to_end: bool) -> str:
    unit = UNITS[axis]
    below, above = ("before", "after") if axis == "time" else ("below", "above")
    if from_start and to_end:
        return "over the whole log" if axis == "time" else f"over the whole range of {WORDS.get(axis, axis)}"
    if from_start:
        return f"{below} {high:.3g} {unit}"
    if to_end:
        return f"{above} {low:.3g} {unit}"
    return f"from {low:.3g} to {high:.3g} {unit}"


def _direction(up: Float, up_se: Float, down: Float, down_se: Float) -> str:
    clear_up, clear_down = _clearness(up, up_se), _clearness(down, down_se)
    if min(clear_up, clear_down) > CLEAR:
        against = np.nansum(up) * np.nansum(down) < 0
        return "in both directions, " + ("against the motion" if against else "the same way in both")
    return "forwards only" if clear_up > clear_down else "backwards only"


def _clearness(mean: Float, error: Float) -> float:
    """Root mean square of a direction's bins in standard errors, about 1 where there is nothing; 0 if all are empty."""
    there = error > 0
    return float(np.sqrt(np.mean((mean[there] / error[there]) ** 2))) if there.any() else 0.0
