"""Models of the drift of one coefficient: steps, a ramp, or nothing but the reference and the last sessions."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.series import Series
from friction_audit.drift.shapes import ramp_shapes, robust_weight
from friction_audit.joint_log import Float

STRONG_EVIDENCE = 6.0
"""Difference of the information criteria from which one model is said to describe better (Kass and Raftery 1995)."""

PLACE_AND_SIZE = 2
"""What a step is free to choose; a ramp chooses its size."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Model:
    """Columns of a model and what is asked of it.

    Attributes:
        columns: Levels and slope first, the temperature last where it is used, shape (n, p).
        level: Combination that is the reference's level, shape (p,).
        change: Combination that is the change from the reference to the last sessions, shape (p,).
        free: What the model chose for itself.
    """

    columns: Float
    level: Float
    change: Float
    free: int


def steps_model(series: Series, places: Sequence[int], reference: Collection[int]) -> Model:
    """Return a level for each segment."""
    segment = np.searchsorted(np.asarray(places), np.arange(len(series.y)), side="right")
    return _levels(series, segment, reference, free=PLACE_AND_SIZE * len(places))


def ends_model(series: Series, reference: Collection[int]) -> Model:
    """Return a level for the reference, for as many last sessions, and for the others."""
    inside = np.isin(series.session, list(reference))
    later = np.flatnonzero(~inside)[-max(int(np.count_nonzero(inside)), 1) :]
    segment = np.where(inside, 0, 1)
    segment[later] = 2
    return _levels(series, np.unique(segment, return_inverse=True)[1], reference, free=0)


def _levels(series: Series, segment: NDArray[np.int64], reference: Collection[int], free: int) -> Model:
    levels = (segment[:, None] == np.arange(int(np.max(segment)) + 1)[None, :]).astype(float)
    return _ask(series, levels, reference, free)


def ramp_model(series: Series, reference: Collection[int]) -> Model:
    """Return a straight change, over the sessions or over the days, whichever describes better."""
    ramps = ramp_shapes(series)
    models = [_ask(series, np.column_stack([np.ones(len(series.y)), ramp]), reference, 1) for ramp in ramps.T]
    return min(models, key=lambda model: criterion(series, model))


def _ask(series: Series, columns: Float, reference: Collection[int], free: int) -> Model:
    inside = np.isin(series.session, list(reference))
    level = np.mean(columns[inside], axis=0) if np.any(inside) else columns[0]
    change = columns[-1] - level
    if series.temperature is not None:
        warmth = series.temperature - np.mean(series.temperature)
        columns = np.column_stack([columns, warmth])
        level, change = np.append(level, 0.0), np.append(change, 0.0)
    return Model(columns=columns, level=level, change=change, free=free)


def criterion(series: Series, model: Model) -> float:
    """Return the information criterion (Schwarz 1978) of a model, without what all models share."""
    weight = robust_weight(series)
    design, y = model.columns * weight[:, None], (series.y - np.mean(series.y)) * weight
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    n = len(y)
    return n * float(np.log(np.sum(left**2) / n + 1e-12)) + model.free * float(np.log(n))


def tell_apart(steps: float, ramp: float, count: int) -> str:
    """Return the shape that the criteria of steps and a ramp speak for."""
    if steps <= ramp - STRONG_EVIDENCE:
        return "step" if count == 1 else "steps"
    return "ramp" if ramp <= steps - STRONG_EVIDENCE else "step_or_ramp"
