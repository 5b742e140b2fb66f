"""Frictional lag: friction answers to a change of speed late."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import HiddenEffect, strength

RELAXING, DELAYED = range(2)

LONGEST_LAG_S = 0.05
SAMPLE_S = 0.0005
SLOTS = 104  # of the longest lag, and room to interpolate
AGE, NEWEST, PREVIOUS, RING = range(4)
LAG_MEMORY = RING + SLOTS


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionalLag(HiddenEffect):
    """Time by which friction lags behind the speed."""

    summary = "friction answers late to a change of speed"
    forms = ("relaxing", "delayed")

    lag_s: float = strength(0.03, "time by which friction lags the speed", "s", upper=LONGEST_LAG_S)
    form: int = RELAXING


@compiled()
def speed(group: Record, memory: Float, speed: float, h: float) -> float:
    """Move on by h to the present speed and return the speed that friction sees, in between those that were. [rad/s]

    Relaxing is the first-order state of rate and state friction (Ruina 1983), delayed the pure time lag of Hess and
    Soom (1990). Passive: the direction is that of the present motion.
    The memory, shape (LAG_MEMORY,), is zero at rest and changed in place.
    """
    if group.lag_s == 0.0:
        return speed
    if group.form == DELAYED:
        remember(memory, speed, h)
        return float(recall(memory, group.lag_s))
    memory[PREVIOUS] -= (speed - memory[PREVIOUS]) * math.expm1(-h / group.lag_s)
    return float(memory[PREVIOUS])


@compiled()
def remember(memory: Float, speed: float, h: float) -> None:
    """Keep a sample of the speed every 0.5 ms, whatever the steps; between two calls the speed is linear in time."""
    memory[AGE] += h
    while memory[AGE] >= SAMPLE_S:
        memory[AGE] -= SAMPLE_S
        newest = (int(memory[NEWEST]) + 1) % SLOTS
        memory[NEWEST] = newest
        memory[RING + newest] = speed - (speed - memory[PREVIOUS]) * memory[AGE] / h
    memory[PREVIOUS] = speed


@compiled()
def recall(memory: Float, lag_s: float) -> float:
    """Return the speed of a time ago, linear between the samples. [rad/s]"""
    newest = int(memory[NEWEST])
    if lag_s <= memory[AGE]:
        return float(memory[PREVIOUS] + (memory[RING + newest] - memory[PREVIOUS]) * lag_s / memory[AGE])
    back = (lag_s - memory[AGE]) / SAMPLE_S
    slot = int(back)
    later = memory[RING + (newest - slot) % SLOTS]
    earlier = memory[RING + (newest - slot - 1) % SLOTS]
    return float(later + (earlier - later) * (back - slot))
