"""Values and intervals of the grown model's numbers, from all cycles, shapes included.

Shapes are those that fit all cycles best, near those that were found (``all_cycles``). Their intervals are those of one
more step of Gauss and Newton (``shape_steps``); where the misfit is rugged, and of a time constant, they are profiled
instead. The values stay those with which the torque was computed: a step along a shape that the log hardly tells would
give factors that belong to no shape.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.all_cycles import settled
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.kept_shapes import over_kept_shapes
from friction_audit.diagnosis.naming import Found
from friction_audit.diagnosis.noise_reach import reach_of_noise
from friction_audit.diagnosis.profile_likelihood import profile_number
from friction_audit.diagnosis.profile_moment import moment_interval
from friction_audit.diagnosis.profile_time import time_interval
from friction_audit.diagnosis.shape_steps import Steps, around, steps_of
from friction_audit.effects.joint_data import Nominal
from friction_audit.friction.history import Coefficient

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


def parameters_of(ground: Ground, found: Sequence[Found], baseline: Nominal) -> Parameters:
    """Fit everything together on all cycles."""
    found, profiled = _with_profiles(ground, settled(ground, found, baseline), baseline)
    steps, at = steps_of(ground, found, baseline), ground.base.shape[1]
    linear = _over_kept_shapes(ground, found, baseline, steps)
    declared = dict(zip(ground.declared.names, linear[:at], strict=True))
    effects = []
    for f, free, numbers in zip(found, steps.shapes, profiled, strict=True):
        width = f.columns.shape[1]
        named = zip(_factor_names(f), linear[at : at + width], np.any(f.columns != 0.0, axis=0), strict=True)
        values = {name: coefficient for name, coefficient, there in named if there}
        values |= {name: around(value, free[name]) for name, value in f.shape.items()}
        reached = _through_noise(_reaching_both(values), f, found, ground, baseline) | numbers
        effects.append(_loosened(reached, f.candidate.factor_ranges(f.shape)))
        at += width
    return Parameters(declared=declared, effects=tuple(effects))


def _over_kept_shapes(
    ground: Ground, found: Sequence[Found], baseline: Nominal, steps: Steps
) -> tuple[Coefficient, ...]:
    """All factors, with intervals over all shapes that the log does not rule out where it does not tell a shape."""
    linear = steps.linear
    for k, (f, bent) in enumerate(zip(found, steps.bent, strict=True)):
        if bent and not f.candidate.multimodal and not f.candidate.moment:
            linear = over_kept_shapes(ground, found, k, baseline, linear)
    return linear


def _with_profiles(
    ground: Ground, found: Sequence[Found], baseline: Nominal
) -> tuple[list[Found], list[dict[str, Coefficient]]]:
    """The effects with the best shapes on all cycles where those are rugged; intervals of those numbers and moments."""
    told = list(found)
    profiled: list[dict[str, Coefficient]] = []
    for k, f in enumerate(told):
        name = f.candidate.multimodal
        others = np.hstack([ground.base, *(g.columns for g in told if g is not f)])
        if f.candidate.moment:
            interval = moment_interval(f.candidate, f.shape, ground, baseline, others)
            profiled.append({f.candidate.moment: interval})
            continue
        if f.candidate.time_constant:
            profiled.append({f.candidate.time_constant: time_interval(f, ground, baseline, others)})
            continue
        if not name:
            profiled.append({})
            continue
        best = profile_number(f.candidate, f.shape, ground, baseline, others)
        columns = ground.rows.of(f.candidate.regressor(ground.data, baseline, best.shape))
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
    values: dict[str, Coefficient], found: Found, every: Sequence[Found], ground: Ground, baseline: Nominal
) -> dict[str, Coefficient]:
    """The numbers of an effect, those that noise of the motion moves with intervals that reach as far."""
    name = next(iter(found.candidate.noise_biased), "")
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


def _loosened(values: dict[str, Coefficient], loose: Mapping[str, tuple[float, float]]) -> dict[str, Coefficient]:
    """The numbers, those above zero that a shape tells too large or too small with intervals that reach as far."""
    wider = {
        name: replace(values[name], low=values[name].low * least, high=values[name].high * most)
        for name, (least, most) in loose.items()
        if values[name].low > 0.0
    }
    return values | wider


def _factor_names(found: Found) -> list[str]:
    return [parameter.name for parameter in found.candidate.coefficients[: found.columns.shape[1]]]
