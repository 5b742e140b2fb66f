"""What became of one coefficient of one joint."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.drift.change_points import Search, Step, find_steps
from friction_audit.drift.control_chart import make_chart, smallest_change
from friction_audit.drift.covariates import TOGETHER, shared, without_temperature
from friction_audit.drift.memory import Memory
from friction_audit.drift.regression import (
    Fit,
    Model,
    change_within,
    criterion,
    ends_model,
    find_trend,
    fit_model,
    is_near_zero,
    ramp_model,
    steps_model,
    tell_apart,
    temperature_slope,
    to_change,
    to_level,
    to_relative,
)
from friction_audit.drift.report import ChangePoint, CoefficientDrift
from friction_audit.drift.session import NORMAL_95, Series, Session
from friction_audit.drift.settings import DriftSettings
from friction_audit.drift.words import Circumstances, describe, describe_too_few
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float

SPEED_CHANGE = 1.25
"""A speed of motion that changes less with a drift does not explain it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Verdict:
    """What the test of the arm says of one series.

    Attributes:
        p_value: Family-wise.
        ramp_p_value: The same of a straight trend alone.
        p_without_temperature: As if no temperature were known; the same as ``p_value`` where none is used.
        critical: Score that the test asks for.
        memory: Autocorrelation of the scatter.
    """

    p_value: float
    ramp_p_value: float
    p_without_temperature: float
    critical: float
    memory: Memory


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Described:
    """The shape of a series, with the model that it was measured by."""

    shape: str
    model: Model
    steps: tuple[Step, ...]


def too_few(series: Series, sessions: Sequence[Session]) -> CoefficientDrift:
    """Return what can be said of a series with too few sessions: its values."""
    drift = CoefficientDrift(
        coefficient=series.coefficient,
        sessions=tuple(int(index) for index in series.session),
        values=_values(series, series.y),
        isolated=tuple(int(index) for index in series.session[~series.kept]),
        shape="too_few",
        within=change_within([sessions[i] for i in series.session], series.joint, series.coefficient),
        drift=False,
        message="",
    )
    own = [joint for session in sessions for joint in session.joints if joint.joint == series.joint]
    return replace(drift, message=describe_too_few(drift, [joint.reason for joint in own if joint.reason]))


def describe_series(
    series: Series, verdict: Verdict, reference: Collection[int], sessions: Sequence[Session], settings: DriftSettings
) -> CoefficientDrift:
    """Return what became of a coefficient.

    Args:
        series: With its isolated sessions.
        verdict: Of the test of the arm.
        reference: Indices of the sessions of the reference.
        sessions: All sessions of the arm, in order.
        settings: How drift is looked for.
    """
    warm = series.counted()
    found = _find_shape(warm, verdict, reference, settings)
    if found.shape == "temperature":
        series = without_temperature(series)
        found = replace(found, model=ends_model(series.counted(), reference))
    counted = series.counted()
    fit = fit_model(counted, found.model.columns, verdict.memory.inflation)
    level = to_level(fit.interval(found.model.level), series)
    y = _at_like_temperature(series, counted, fit)
    change = _change(counted, found.model, fit, reference, verdict.memory.inflation)
    smallest = smallest_change(
        counted, fit, critical=verdict.critical, growth=verdict.memory.growth, power=settings.power
    )
    least = Coefficient(value=smallest, low=smallest, high=smallest)
    trend = find_trend(counted, verdict.memory.inflation)
    drift = CoefficientDrift(
        coefficient=series.coefficient,
        sessions=tuple(int(index) for index in series.session),
        values=_values(series, y),
        isolated=tuple(int(index) for index in series.session[~series.kept]),
        level=level,
        shape=found.shape,
        p_value=verdict.p_value,
        temperature_slope=temperature_slope(fit, counted, abs(level.value)),
        temperature_c=float("nan") if counted.temperature is None else float(np.mean(counted.temperature)),
        trend_per_session=trend.per_session,
        trend_per_day=trend.per_day,
        trend_p_value=verdict.ramp_p_value,
        change_points=_change_points(counted, found, fit, verdict.p_value),
        control=make_chart(series, y, fit, level, reference, settings.alpha),
        change=to_change(change, level, series),
        total=to_relative(change, level, series),
        scatter=_scatter(fit, level, series),
        smallest_change=to_change(least, level, series).value,
        smallest_drift=to_relative(least, level, series).value,
        within=change_within([sessions[i] for i in series.session], series.joint, series.coefficient),
        drift=verdict.p_value <= settings.alpha,
        message="",
    )
    return replace(drift, message=describe(drift, sessions, _circumstances(warm, found, verdict, settings)))


def _change(series: Series, model: Model, fit: Fit, reference: Collection[int], inflation: float) -> Coefficient:
    """Return the change of y from the reference to the last sessions.

    By the model; where it has them on one level, by the sessions themselves; NaN if all are of the reference.
    """
    if np.any(model.change):
        return fit.interval(model.change)
    ends = ends_model(series, reference)
    return fit_model(series, ends.columns, inflation).interval(ends.change) if np.any(ends.change) else UNDETERMINED


def _find_shape(series: Series, verdict: Verdict, reference: Collection[int], settings: DriftSettings) -> Described:
    if verdict.p_value > settings.alpha:
        ends = ends_model(series, reference)
        together = verdict.p_without_temperature <= settings.alpha and _follows_temperature(series, ends)
        return Described(shape="temperature" if together else "none", model=ends, steps=())
    search = Search(
        alpha=settings.alpha, permutations=settings.permutations, seed=settings.seed, growth=verdict.memory.growth
    )
    steps = find_steps(series, search)
    stepped, ramp = steps_model(series, [step.place for step in steps], reference), ramp_model(series, reference)
    scores = criterion(series, stepped), criterion(series, ramp)
    shape = tell_apart(*scores, len(steps))
    straight = shape == "ramp" or (shape == "step_or_ramp" and scores[1] < scores[0])
    return Described(shape=shape, model=ramp if straight else stepped, steps=() if straight else steps)


def _follows_temperature(series: Series, ends: Model) -> bool:
    """Return whether the temperature went with the sessions so closely that it hides any drift."""
    if series.temperature is None:
        return False
    shapes = (series.place, *ends.columns.T[:-1])
    return max(shared(shape, series.temperature) for shape in shapes) > TOGETHER


def _at_like_temperature(series: Series, counted: Series, fit: Fit) -> Float:
    if series.temperature is None or counted.temperature is None:
        return series.y
    return np.asarray(series.y - fit.value[-1] * (series.temperature - np.mean(counted.temperature)))


def _values(series: Series, y: Float) -> tuple[Coefficient, ...]:
    half = NORMAL_95 * series.y_error
    rows = zip(y, y - half, y + half, strict=True)
    return tuple(
        to_level(Coefficient(value=float(value), low=float(low), high=float(high)), series) for value, low, high in rows
    )


def _scatter(fit: Fit, level: Coefficient, series: Series) -> float:
    if series.logarithmic or is_near_zero(level):
        return fit.scatter
    return fit.scatter / abs(level.value)


def _change_points(series: Series, found: Described, fit: Fit, p_value: float) -> tuple[ChangePoint, ...]:
    points = []
    for k, step in enumerate(found.steps):
        before, after = np.eye(len(fit.value))[[k, k + 1]]
        level = to_level(fit.interval(before), series)
        points.append(
            ChangePoint(
                session=int(series.session[step.place]),
                low=int(series.session[step.low]),
                high=int(series.session[step.high]),
                before=level,
                after=to_level(fit.interval(after), series),
                relative=to_relative(fit.interval(after - before), level, series),
                p_value=max(step.p_value, p_value),
            )
        )
    return tuple(points)


def _circumstances(series: Series, found: Described, verdict: Verdict, settings: DriftSettings) -> Circumstances:
    """Return what changed beside the coefficient."""
    moved = np.any(found.model.change)
    shape = found.model.columns @ found.model.change if moved else series.place
    end, start = shape >= np.quantile(shape, 0.8), shape <= np.quantile(shape, 0.2)
    warmer = float("nan")
    if series.temperature is not None:
        warmer = float(np.mean(series.temperature[series.place >= np.quantile(series.place, 0.8)]))
        warmer -= float(np.mean(series.temperature[series.place <= np.quantile(series.place, 0.2)]))
    drifts = verdict.p_value <= settings.alpha
    ratio = float(np.median(series.speed[end]) / np.median(series.speed[start])) if drifts else float("nan")
    with_speed = drifts and _goes_with_speed(series, shape) and abs(np.log(ratio)) > np.log(SPEED_CHANGE)
    return Circumstances(
        warmer_k=warmer,
        by_temperature=verdict.p_without_temperature <= settings.alpha < verdict.p_value,
        speed_ratio=ratio if with_speed else float("nan"),
    )


def _goes_with_speed(series: Series, shape: Float) -> bool:
    if not np.all(np.isfinite(series.speed)) or np.min(series.speed) <= 0.0:
        return False
    return shared(shape, np.log(series.speed)) > TOGETHER / 2
