"""Values and intervals of the grown model's numbers, from all cycles, shapes included.

A shape's interval is that of one step of Gauss and Newton: the derivative of the effect's torque with respect to the
shape is one more column, and its factor is how far the shape is off. Where the misfit is rugged, and of a time
constant, it is profiled instead. The values stay those with which the torque was computed: a step along a shape that
the log hardly tells would give factors that belong to no shape.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.declared import coefficients
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.naming import Found
from friction_audit.discrepancy.noise_reach import reach_of_noise
from friction_audit.discrepancy.profile_likelihood import profile_number
from friction_audit.discrepancy.profile_moment import moment_interval
from friction_audit.discrepancy.profile_time import time_interval
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

STEP = 1e-3
READ_TWICE = (("compliance_rad_per_nm", "spring_nm_per_rad", -1), ("delay_s", "delay_step_s", 1))
"""Factors that are a power of a number of their shape, for a shape that is right: by how much, and by when or how fast.
What a model does not get right, as the damping of a spring, pulls the two apart."""
MOST_CHANGE = 3.0
"""Change of an effect's torque within the interval of a number of its shape, over that torque: beyond, the derivative
says nothing of the way there, and the log does not tell the number."""
MOST_SPREAD = 10.0
"""Half of the interval of a number that cannot be below zero, over the number: the log does not tell its size."""
FARTHEST = 2.0
"""From one reading to the other; beyond, the shape was an end of its grid and stands for all that lie behind it."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Parameters:
    """Numbers with 95 % intervals.

    Attributes:
        declared: Of the declared model's columns as fitted beside the effects, by name.
        effects: Of each effect, by name: linear factors, then shape.
    """

    declared: dict[str, Coefficient]
    effects: tuple[dict[str, Coefficient], ...]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Most:
    """What an interval of a number of a shape may hold, shape (s,) each.

    Attributes:
        change: Root mean square of the change of the effect's torque. [N m]
        spread: Half of its width.
    """

    change: Float
    spread: Float


def parameters_of(ground: Ground, found: Sequence[Found], baseline: Baseline) -> Parameters:
    """Fit everything together on all cycles."""
    found, profiled = _with_profiles(ground, found, baseline)
    base = ground.base.shape[1]
    linear = np.hstack([ground.base, *(f.columns for f in found)])
    fitted = coefficients(linear, ground.y, ground.rows.cycle)
    slopes, torques, sizes, at = [np.zeros((len(linear), 0))], [np.zeros(0)], [np.zeros(0)], base
    for f in found:
        width = f.columns.shape[1]
        factors = np.array([c.value for c in fitted[at : at + width]])
        slopes.append(_slopes(ground, f, baseline, factors))
        torques.append(np.repeat(_rms(f.columns @ factors), slopes[-1].shape[1]))
        sizes.append(_sizes(f))
        at += width
    most = _Most(change=MOST_CHANGE * np.concatenate(torques), spread=MOST_SPREAD * np.concatenate(sizes))
    every = _with_slopes(ground, linear, np.hstack(slopes), most)
    every = (*(_around(one.value, wide) for one, wide in zip(fitted, every, strict=False)), *every[len(fitted) :])
    declared = dict(zip(ground.declared.names, every[:base], strict=True))
    effects, at, after = [], base, linear.shape[1]
    for f, slope, numbers in zip(found, slopes[1:], profiled, strict=True):
        width, shapes = f.columns.shape[1], slope.shape[1]
        named = zip(_factor_names(f), every[at : at + width], np.any(f.columns != 0.0, axis=0), strict=True)
        values = {name: coefficient for name, coefficient, there in named if there}
        free = every[after : after + shapes]
        values |= {name: _around(f.shape[name], step) for name, step in zip(f.shape, free, strict=False)}
        effects.append(_through_noise(_reaching_both(values), f, found, ground, baseline) | numbers)
        at, after = at + width, after + shapes
    return Parameters(declared=declared, effects=tuple(effects))


def _with_slopes(ground: Ground, linear: Float, slopes: Float, most: _Most) -> tuple[Coefficient, ...]:
    """Factors of the linear columns and of the slopes, those of slopes that the log does not tell without bounds.

    Args:
        ground: The joint.
        linear: Declared model and effects, shape (m, b).
        slopes: Derivatives with respect to each number of each shape, shape (m, s).
        most: Beyond what the log does not tell a number.
    """
    every = coefficients(np.hstack([linear, slopes]), ground.y, ground.rows.cycle)
    half = np.array([(one.high - one.low) / 2.0 for one in every[linear.shape[1] :]])
    told = (half * _rms(slopes) <= most.change) & (half <= most.spread)
    if not told.all():
        every = coefficients(np.hstack([linear, slopes[:, told]]), ground.y, ground.rows.cycle)
    steps = iter(every[linear.shape[1] :])
    unknown = Coefficient(value=0.0, low=-np.inf, high=np.inf)
    return (*every[: linear.shape[1]], *(next(steps) if one else unknown for one in told))


def _sizes(found: Found) -> Float:
    """Each number of a shape that cannot be below zero; infinite for one that can, shape (k,)."""
    term = found.candidate.term
    above = () if term is None else tuple(p.name for p in term.shape if p.lower >= 0.0)
    shape = found.candidate.whole(found.shape)
    return np.array([abs(value) if name in above else np.inf for name, value in shape.items()], np.float64)


def _rms(columns: Float) -> Float:
    """Root mean square of each column."""
    return np.asarray(np.sqrt(np.mean(columns**2, axis=0)), np.float64)


def _with_profiles(
    ground: Ground, found: Sequence[Found], baseline: Baseline
) -> tuple[list[Found], list[dict[str, Coefficient]]]:
    """The effects with the best shapes on all cycles where those are rugged; intervals of those numbers and moments."""
    told = list(found)
    profiled: list[dict[str, Coefficient]] = []
    for k, f in enumerate(told):
        name = f.candidate.rugged
        others = np.hstack([ground.base, *(g.columns for g in told if g is not f)])
        if f.candidate.moment:
            interval = moment_interval(f.candidate, f.shape, ground, baseline, others)
            profiled.append({f.candidate.moment: interval})
            continue
        if f.candidate.fading:
            profiled.append({f.candidate.fading: time_interval(f, ground, baseline, others)})
            continue
        if not name:
            profiled.append({})
            continue
        best = profile_number(f.candidate, name, f.shape, ground, baseline, others)
        columns = ground.rows.of(f.candidate.columns(ground.data, baseline, best.shape))
        told[k] = replace(f, shape=best.shape, columns=columns)
        profiled.append({name: best.number})
    return told, profiled


def _reaching_both(values: dict[str, Coefficient]) -> dict[str, Coefficient]:
    """The numbers of an effect; of one that is read twice the better known reading, with an interval that reaches both.

    Noise in what a factor is multiplied with makes it too small, and leaves alone what says when.
    """
    told = dict(values)
    for name, shape, power in READ_TWICE:
        if name not in values or values[shape].low * values[shape].high <= 0.0:
            continue
        one, ends = values[name], sorted(end**power for end in (values[shape].low, values[shape].high))
        other = Coefficient(value=values[shape].value ** power, low=ends[0], high=ends[1])
        if 1.0 / FARTHEST <= one.value / other.value <= FARTHEST:
            better = min((one, other), key=lambda reading: reading.high - reading.low)
            told[name] = Coefficient(value=better.value, low=min(one.low, ends[0]), high=max(one.high, ends[1]))
    return told


def _through_noise(
    values: dict[str, Coefficient], found: Found, every: Sequence[Found], ground: Ground, baseline: Baseline
) -> dict[str, Coefficient]:
    """The numbers of an effect, those that noise of the motion moves with intervals that reach as far."""
    name = found.candidate.noisy
    if not name or values[name].low == -np.inf:
        return values
    others = np.hstack([ground.base, *(one.columns for one in every if one is not found)])
    reach = reach_of_noise(found, ground, baseline, others)
    twice = {factor: power for factor, shape, power in READ_TWICE if shape == name and factor in values}
    return {
        **values,
        name: reach.widen(values[name]),
        **{factor: reach.widen(values[factor], power) for factor, power in twice.items()},
    }


def _factor_names(found: Found) -> list[str]:
    term = found.candidate.term
    if term is not None:
        return [parameter.name for parameter in term.linear[: found.columns.shape[1]]]
    return [f"factor_{k}_{unit}" for k, unit in enumerate(found.candidate.column_units, start=1)]


def _slopes(ground: Ground, found: Found, baseline: Baseline, factors: Float) -> Float:
    """Derivative of an effect's torque with respect to each number of its shape, assumed ones last, shape (m, k)."""
    columns = [np.zeros((len(ground.y), 0))]
    shape = found.candidate.whole(found.shape)
    for name, value in shape.items():
        step = STEP * max(abs(value), STEP)
        up, down = (
            ground.rows.of(found.candidate.columns(ground.data, baseline, {**shape, name: value + side * step}))
            for side in (1, -1)
        )
        columns.append(((up - down) @ factors / (2 * step))[:, None])
    return np.hstack(columns)


def _around(value: float, wide: Coefficient) -> Coefficient:
    """A value with the half width of another interval: the value stays, for the torque was computed with it."""
    half = (wide.high - wide.low) / 2.0
    return Coefficient(value=value, low=value - half, high=value + half)
