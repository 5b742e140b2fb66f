"""The numbers of the shapes once more, from all cycles together: Gauss and Newton, step by step.

A name is found on the working cycles, and so is its shape. An interval from all cycles is narrower than such a value
deserves: it is that of the value that all cycles give, which is no nearer to one of a part of them than their scatter.
So the shapes go on to where all cycles are fitted best. A step counts where it leaves less and the effect stays
possible; else half of it is tried. What the log does not tell stays as it was found.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found
from friction_audit.diagnosis.shape_steps import steps_of
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import Nominal

MOST_STEPS = 8
SHARES = (1.0, 0.5, 0.25, 0.125)
"""Of a step, that are tried one after the other."""
SETTLED = 1e-6
"""Change of the misfit, as a share of it, that is not worth another step."""


def settled(ground: Ground, found: Sequence[Found], baseline: Nominal) -> list[Found]:
    """The effects with the shapes that leave least on all cycles, near those that were found.

    Moments, time constants and rugged numbers stay: a descent finds none of them.

    Args:
        ground: The joint.
        found: The effects.
        baseline: What columns may lean on.
    """
    told, beside = list(found), Beside(ground.base, ground.y)
    if not any(map(_free, told)):
        return told
    left = _left(told, beside)
    for _ in range(MOST_STEPS):
        nearer = _nearer(ground, told, baseline, beside, left)
        if nearer is None:
            break
        (told, now), before = nearer, left
        left = now
        if before - now <= SETTLED * before:
            break
    return told


def _nearer(
    ground: Ground, found: list[Found], baseline: Nominal, beside: Beside, left: float
) -> tuple[list[Found], float] | None:
    """The effects a step on and what they leave, where that is less."""
    steps = steps_of(ground, found, baseline).shapes
    ways = [{name: steps[k][name].value for name in _free(f)} for k, f in enumerate(found)]
    for share in SHARES:
        tried = [_moved(f, way, share, ground, baseline) for f, way in zip(found, ways, strict=True)]
        if (now := _left(tried, beside)) < left:
            return tried, now
    return None


def _left(found: Sequence[Found], beside: Beside) -> float:
    """Residual sum of squares; infinite where an effect is not possible."""
    factors, left = beside.fit(np.hstack([np.zeros((len(beside.response), 0)), *(f.columns for f in found)]))
    at = 0
    for f in found:
        own = factors[at : at + f.columns.shape[1]]
        at += len(own)
        if not f.candidate.admissible(own, f.shape):
            return float("inf")
    return left


def _free(found: Found) -> list[str]:
    """Names of the numbers that may move."""
    fixed = {found.candidate.multimodal, found.candidate.moment, found.candidate.time_constant}
    known = {p.name: p for p in found.candidate.nonlinear}
    moves = [name for name in found.shape if not known or (name in known and not known[name].whole)]
    return [name for name in moves if name not in fixed]


def _moved(found: Found, steps: Nonlinear, share: float, ground: Ground, baseline: Nominal) -> Found:
    """The effect a share of a step on, within the bounds of its numbers."""
    away = {name: found.shape[name] + share * step for name, step in steps.items()}
    inside = {name: float(np.clip(value, *found.candidate.bounds(name))) for name, value in away.items()}
    shape = {**found.shape, **inside}
    return replace(found, shape=shape, columns=ground.rows.of(found.candidate.regressor(ground.data, baseline, shape)))
