"""Values and intervals of the grown model's numbers, from all cycles, shapes included.

A shape's interval is that of one step of Gauss and Newton: the derivative of the effect's torque with respect to the
shape is one more column, and its factor is how far the shape is off. Where the misfit is rugged it is profiled instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.declared import coefficients
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.naming import Found
from friction_audit.discrepancy.profile_likelihood import profile_number
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

STEP = 1e-3
READ_TWICE = (("compliance_rad_per_nm", "spring_nm_per_rad", -1), ("delay_s", "delay_step_s", 1))
"""Factors that are a power of a number of their shape, for a shape that is right: by how much, and by when or how fast.
What a model does not get right, as the damping of a spring, pulls the two apart."""
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


def parameters_of(ground: Ground, found: Sequence[Found], baseline: Baseline) -> Parameters:
    """Fit everything together on all cycles."""
    found, profiled = _with_profiles(ground, found, baseline)
    base = ground.base.shape[1]
    linear = np.hstack([ground.base, *(f.columns for f in found)])
    factors = [c.value for c in coefficients(linear, ground.y, ground.rows.cycle)]
    slopes, at = [], base
    for f in found:
        width = f.columns.shape[1]
        slopes.append(_slopes(ground, f, baseline, np.array(factors[at : at + width])))
        at += width
    every = coefficients(np.hstack([linear, *slopes]), ground.y, ground.rows.cycle)
    declared = dict(zip(ground.declared.names, every[:base], strict=True))
    effects, at, after = [], base, linear.shape[1]
    for f, slope, numbers in zip(found, slopes, profiled, strict=True):
        width, shapes = f.columns.shape[1], slope.shape[1]
        named = zip(_factor_names(f), every[at : at + width], np.any(f.columns != 0.0, axis=0), strict=True)
        values = {name: coefficient for name, coefficient, there in named if there}
        free = every[after : after + shapes]
        values |= {name: _shifted(f.shape[name], step) for name, step in zip(f.shape, free, strict=True)}
        effects.append(_reaching_both(values) | numbers)
        at, after = at + width, after + shapes
    return Parameters(declared=declared, effects=tuple(effects))


def _with_profiles(
    ground: Ground, found: Sequence[Found], baseline: Baseline
) -> tuple[list[Found], list[dict[str, Coefficient]]]:
    """The effects with the best shapes on all cycles where those are rugged, and the intervals of such numbers."""
    told = list(found)
    profiled: list[dict[str, Coefficient]] = []
    for k, f in enumerate(told):
        name = f.candidate.rugged
        if not name:
            profiled.append({})
            continue
        others = np.hstack([ground.base, *(g.columns for g in told if g is not f)])
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


def _factor_names(found: Found) -> list[str]:
    term = found.candidate.term
    if term is not None:
        return [parameter.name for parameter in term.linear]
    return [f"factor_{k}_{unit}" for k, unit in enumerate(found.candidate.column_units, start=1)]


def _slopes(ground: Ground, found: Found, baseline: Baseline, factors: Float) -> Float:
    """Derivative of an effect's torque with respect to each number of its shape, shape (m, k)."""
    columns = [np.zeros((len(ground.y), 0))]
    for name, value in found.shape.items():
        step = STEP * max(abs(value), STEP)
        up, down = (
            ground.rows.of(found.candidate.columns(ground.data, baseline, {**found.shape, name: value + side * step}))
            for side in (1, -1)
        )
        columns.append(((up - down) @ factors / (2 * step))[:, None])
    return np.hstack(columns)


def _shifted(value: float, step: Coefficient) -> Coefficient:
    """A shape with the interval of its step; the value itself stays, for the torque was computed with it."""
    half = (step.high - step.low) / 2.0
    return Coefficient(value=value, low=value - half, high=value + half)
