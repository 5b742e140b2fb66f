"""Sessions of an arm -> ArmDrift: joint by joint, what became of each coefficient."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np

from friction_audit.drift import regression, report
from friction_audit.drift.change_points import Step, find_isolated, find_steps, leave_outliers_out
from friction_audit.drift.change_test import COLLINEAR, Verdict, judge_family
from friction_audit.drift.covariates import CONFOUNDED, choose_comparable, shared, use_temperature
from friction_audit.drift.regression import Fit, Model, to_change, to_level
from friction_audit.drift.report import ArmDrift, CoefficientDrift, ControlPoint, DriftSettings
from friction_audit.drift.session import COEFFICIENTS, NORMAL_95, Order, Series, Session, make_series, put_in_order
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.preprocessing.interaction import Caution

SPEED_CHANGE = 1.25  # a speed of motion that changes less with a drift does not explain it
CERTAIN = 30.0  # statistic beyond which the noise of the numerator of t is negligible against that of its denominator


def analyse_arm(sessions: Sequence[Session], settings: DriftSettings) -> ArmDrift:
    """Find what changed between the sessions of one arm, in any order."""
    order = put_in_order(sessions)
    compared, left_out, limits = choose_comparable(order)
    reference, odd = choose_reference(compared, settings.baseline)
    family, warnings = _collect(order, compared)
    verdicts = _judge([series.take(series.kept) for series in family], settings)
    found: dict[int, list[CoefficientDrift]] = {}
    for series, verdict in zip(family, verdicts, strict=True):
        drift = describe_series(series, verdict, reference, order.sessions, settings)
        found.setdefault(series.joint, []).append(drift)
    names = {joint.joint: joint.name for session in reversed(order.sessions) for joint in session.joints}
    return ArmDrift(
        robot=order.sessions[0].robot,
        sessions=order.sessions,
        compared=compared,
        reference=reference,
        left_out=tuple(left_out.items()),
        joints=tuple(report.JointDrift(joint=n, name=names[n], coefficients=tuple(own)) for n, own in found.items()),
        ordered_by=order.by,
        autocorrelation=max((one.scatter.first for one in verdicts if one is not None), default=0.0),
        warnings=(*limits, *odd, *warnings),
    )


def choose_reference(
    compared: tuple[int, ...], baseline: int | tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[Caution, ...]]:
    """Return the sessions of the reference, so many first ones or these indices, and what is wrong with them."""
    if isinstance(baseline, int):
        return compared[: min(baseline, max(1, len(compared) // 2))], ()
    chosen = tuple(index for index in baseline if index in compared)
    missing = [str(index + 1) for index in baseline if index not in compared]
    if not chosen:
        first = choose_reference(compared, DriftSettings().baseline)[0]
        return first, (Caution("other_reference"),)
    lost = Caution("part_of_reference", numbers={"sessions": ", ".join(missing)})
    return chosen, (lost,) if missing else ()


def _collect(order: Order, compared: tuple[int, ...]) -> tuple[list[Series], list[Caution]]:
    """Return each coefficient of each joint, isolated sessions and those without a temperature set aside."""
    joints = sorted({joint.joint for index in compared for joint in order.sessions[index].joints})
    family: list[Series] = []
    warned: dict[Caution, set[int]] = {}
    for joint, coefficient in product(joints, COEFFICIENTS):
        series = make_series(order.sessions, compared, joint, coefficient, by_start=order.by == "start")
        series = replace(series, kept=~find_isolated(series.y, series.y_error))
        like, warning = use_temperature(series, order.sessions)
        family.append(leave_outliers_out(like))
        if warning is not None:
            warned.setdefault(warning, set()).add(joint)
    only = {one: write_joint_numbers(sorted(own)) if len(own) < len(joints) else "" for one, own in warned.items()}
    return family, [replace(one, numbers={**one.numbers, "only": who}) for one, who in only.items()]


def _judge(family: Sequence[Series], settings: DriftSettings) -> list[Verdict | None]:
    """Test the coefficients of an arm, all of whose sessions count; None for those with too few sessions."""
    # One degree of freedom is left given level, temperature and one change.
    fewest = [max(report.FEWEST_SESSIONS, regression.baseline_columns(series).shape[1] + 2) for series in family]
    testable = [i for i, series in enumerate(family) if len(series.y) >= fewest[i]]
    some = [family[i] for i in testable]
    test = plain = judge_family(some, settings) if some else []
    if any(series.temperature is not None for series in some):
        plain = judge_family([replace(series, temperature=None) for series in some], settings)
    pairs = zip(testable, test, plain, strict=True)
    verdicts = {i: found._replace(p_without_temperature=bare.p_value) for i, found, bare in pairs}
    return [verdicts.get(i) for i in range(len(family))]


def _shown(series: Series, y: Float, sessions: Sequence[Session]) -> dict[str, Any]:
    values = map(Coefficient.around, y, NORMAL_95 * series.y_error)
    return {
        "coefficient": series.coefficient,
        "sessions": tuple(series.session.tolist()),
        "values": tuple(to_level(one, series) for one in values),
        "isolated": tuple(series.session[~series.kept].tolist()),
        "within": regression.change_within([sessions[i] for i in series.session], series.joint, series.coefficient),
    }


def describe_series(
    series: Series,
    verdict: Verdict | None,
    reference: Collection[int],
    sessions: Sequence[Session],
    settings: DriftSettings,
) -> CoefficientDrift:
    """Return what became of a coefficient, its isolated sessions among the others; of too few sessions the values."""
    if verdict is None:
        own = [joint for session in sessions for joint in session.joints if joint.joint == series.joint]
        reasons = tuple(joint.reason for joint in own if joint.reason)
        return CoefficientDrift(**_shown(series, series.y, sessions), shape="too_few", drift=False, reasons=reasons)
    warm, growth, first = series.take(series.kept), verdict.scatter.growth, verdict.scatter.first
    inflation = (1.0 + first) / (1.0 - first)
    shape, model, steps, p_value = _find_shape(warm, verdict, reference, settings, inflation)
    if shape == "temperature":
        series = replace(series, temperature=None)
        model = regression.ends_model(series.take(series.kept), reference)
    counted = series.take(series.kept)
    fit = regression.fit_model(counted, model.columns, inflation)
    level = to_level(fit.interval(model.level), series)
    y = series.y
    if series.temperature is not None and counted.temperature is not None:
        y = y - fit.value[-1] * (series.temperature - np.mean(counted.temperature))
    # Where the model has the reference and the last sessions on one level, the sessions themselves give the change.
    ends = model if np.any(model.change) else regression.ends_model(counted, reference)
    last = fit if ends is model else regression.fit_model(counted, ends.columns, inflation)
    change = last.interval(ends.change) if np.any(ends.change) else UNDETERMINED
    smallest = smallest_change(counted, fit, critical=verdict.critical, growth=growth, power=settings.power)
    least, least_share = to_change(Coefficient.around(smallest, 0.0), level, series)
    absolute, total = to_change(change, level, series)
    over, slope = 1.0 if series.logarithmic else abs(level.value), UNDETERMINED
    if counted.temperature is not None and over:
        slope = fit.interval(np.eye(len(fit.value))[-1]).each(lambda end: end / over)
    relative_scatter = not series.logarithmic and not regression.is_near_zero(level)
    return CoefficientDrift(
        **_shown(series, y, sessions),
        level=level,
        shape=shape,
        p_value=p_value,
        temperature_slope=slope,
        temperature_c=float("nan") if counted.temperature is None else float(np.mean(counted.temperature)),
        trend_per_session=regression.slope_over(counted, counted.place, inflation),
        trend_per_day=regression.slope_over(counted, counted.day, inflation),
        trend_p_value=verdict.ramp_p_value,
        change_points=tuple(_change_points(counted, steps, fit, p_value)),
        control=make_chart(series, y, fit, level, reference, settings.alpha),
        change=absolute,
        total=total,
        scatter=fit.scatter / abs(level.value) if relative_scatter else fit.scatter,
        smallest_change=least.value,
        smallest_drift=least_share.value,
        drift=p_value <= settings.alpha,
        warmer_k=_warming(warm),
        by_temperature=verdict.p_without_temperature <= settings.alpha < p_value,
        speed_ratio=_speed_ratio(warm, model) if p_value <= settings.alpha else float("nan"),
    )


def _find_shape(
    series: Series, verdict: Verdict, reference: Collection[int], settings: DriftSettings, inflation: float
) -> tuple[str, Model, tuple[Step, ...], float]:
    """Return the shape of a series, the model that it is measured by, its steps, and the p-value of drift.

    The order of the sessions has to be rare, and the size beyond their errors, which may be larger than their scatter:
    the larger p-value counts (intersection-union test, Berger 1982), so that no interval of a drift holds zero.
    """
    p_value, ends, warmth = verdict.p_value, regression.ends_model(series, reference), series.temperature
    if p_value <= settings.alpha:
        steps = find_steps(series, settings, verdict.scatter.growth)
        shape, model, steps, of_size = _describe_drift(series, steps, reference, settings.alpha, inflation)
        p_value = max(p_value, of_size)
        if p_value <= settings.alpha:
            return shape, model, steps, p_value
    if warmth is None or verdict.p_without_temperature > settings.alpha:
        return "none", ends, (), p_value
    confounded = max(shared(column, warmth) for column in (series.place, *ends.columns.T[:-1])) > CONFOUNDED
    return "temperature" if confounded else "none", ends, (), p_value


def _describe_drift(
    series: Series, steps: tuple[Step, ...], reference: Collection[int], alpha: float, inflation: float
) -> tuple[str, Model, tuple[Step, ...], float]:
    """Return steps or a ramp, whichever describes a drift better, and the p-value of its size."""

    def p_values(model: Model, sizes: int) -> list[float]:
        fit = regression.fit_model(series, model.columns, inflation)
        return [fit.p_value(size) for size in np.diff(np.eye(len(fit.value)), axis=0)[:sizes]]

    segment = np.searchsorted([step.place for step in steps], np.arange(len(series.y)), side="right")
    levels = (segment[:, None] == np.arange(len(steps) + 1)).astype(float)
    stepped = regression.make_model(series, levels, reference, free=regression.PLACE_AND_SIZE * len(steps))
    of_steps = p_values(stepped, len(steps))
    weakest = int(np.argmax(of_steps))
    if len(steps) > 1 and of_steps[weakest] > alpha:  # a step whose interval holds zero is none
        return _describe_drift(series, steps[:weakest] + steps[weakest + 1 :], reference, alpha, inflation)
    shares = regression.ramp_columns(series).T  # of the change: over the sessions, over the days
    ramps = [regression.make_model(series, np.column_stack([1.0 - one, one]), reference, free=1) for one in shares]
    ramp = min(ramps, key=lambda model: regression.criterion(series, model))
    better = regression.criterion(series, stepped) - regression.criterion(series, ramp)  # of the ramp than of the steps
    shape = "ramp" if better > 0.0 else "step" if len(steps) == 1 else "steps"
    if not abs(better) >= regression.STRONG_EVIDENCE:
        shape = "step_or_ramp"
    if better > 0.0:
        return shape, ramp, (), p_values(ramp, 1)[0]
    return shape, stepped, steps, min(of_steps)


def _change_points(series: Series, steps: Sequence[Step], fit: Fit, p_value: float) -> Iterator[report.ChangePoint]:
    for (before, after), step in zip(pairwise(np.eye(len(fit.value))), steps, strict=False):
        level = to_level(fit.interval(before), series)
        session, low, high = series.session[[step.place, step.low, step.high]].tolist()
        change, relative = to_change(fit.interval(after - before), level, series)
        yield report.ChangePoint(
            session=session,
            low=low,
            high=high,
            before=level,
            after=to_level(fit.interval(after), series),
            change=change,
            relative=relative,
            p_value=max(step.p_value, p_value, fit.p_value(after - before)),
        )


def _warming(series: Series) -> float:
    """Return by how much the last fifth of the sessions is warmer than the first one. [K]"""
    if series.temperature is None:
        return float("nan")
    low, high = np.quantile(series.place, (0.2, 0.8))
    return float(np.mean(series.temperature[series.place >= high]) - np.mean(series.temperature[series.place <= low]))


def _speed_ratio(series: Series, model: Model) -> float:
    """Return the speed at the end of the change over that at its start, NaN where speed does not go with it."""
    column = model.columns @ model.change if np.any(model.change) else series.place
    end, start = column >= np.quantile(column, 0.8), column <= np.quantile(column, 0.2)
    ratio = float(np.median(series.speed[end]) / np.median(series.speed[start]))
    positive = bool(np.all(np.isfinite(series.speed))) and np.min(series.speed) > 0.0
    with_speed = positive and shared(column, np.log(series.speed)) > CONFOUNDED / 2
    return ratio if with_speed and abs(np.log(ratio)) > np.log(SPEED_CHANGE) else float("nan")


def make_chart(
    series: Series, y: Float, fit: Fit, level: Coefficient, reference: Collection[int], alpha: float
) -> tuple[ControlPoint, ...]:
    """Compare each session with the mean of the reference; limits hold for all sessions together."""
    from scipy.stats import t

    inside = np.isin(series.session, list(reference)) & series.kept
    if not np.any(inside) or fit.freedom < 1:
        return ()
    variance = (series.y_error**2 + fit.scatter**2) * max(1.0, fit.scale) ** 2
    weight = np.where(inside, 1.0 / variance, 0.0)
    mean, mean_variance = float(np.average(y, weights=weight)), float(1.0 / np.sum(weight))
    # Of a new session: its own error, the scatter around the drift, the error of the mean of the reference.
    spread = variance + np.where(inside, -mean_variance, mean_variance)
    half = float(t.isf(alpha / (2.0 * len(y)), fit.freedom)) * np.sqrt(np.maximum(spread, 0.0))
    outside = (np.abs(y - mean) > half) & (half > 0.0)
    ends = [Coefficient(value=one, low=-far, high=far) for one, far in np.column_stack([y - mean, half]).tolist()]
    pairs = [to_change(end, level, series) for end in ends]
    rows = zip(series.session.tolist(), pairs, outside.tolist(), strict=True)
    return tuple(ControlPoint(session=i, deviation=d, relative=r, outside=out) for i, (d, r), out in rows)


def smallest_change(series: Series, fit: Fit, *, critical: float, growth: float, power: float) -> float:
    """Return the straight change of y, start to end, that the test of the arm finds with a probability, the power."""
    from scipy.special import nctdtrinc
    from scipy.stats import chi2, t

    weight = 1.0 / (np.sqrt(series.y_error**2 + fit.scatter**2) * max(fit.scale, 1.0))
    base, ramp = regression.baseline_columns(series) * weight[:, None], regression.ramp_columns(series)[:, 0] * weight
    left, freedom = ramp - base @ np.linalg.lstsq(base, ramp, rcond=None)[0], len(ramp) - base.shape[1] - 1
    if freedom < 1 or left @ left <= COLLINEAR * (ramp @ ramp):
        return math.nan
    statistic = float(t.isf(np.exp(-critical), freedom))
    if statistic > CERTAIN:  # where the search of nctdtrinc may take for ever
        shift = statistic * math.sqrt(float(chi2.ppf(power, freedom)) / freedom)
    else:
        shift = float(nctdtrinc(freedom, 1.0 - power, statistic))  # noncentrality that passes the bound
    return shift * growth / float(np.linalg.norm(left))
