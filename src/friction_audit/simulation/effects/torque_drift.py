"""Torque drift: the zero of the torque sensor moves during the recording."""

import math
from dataclasses import dataclass
from math import inf

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import HiddenEffect, number, strength

RAMP, RANDOM_WALK, THERMAL = range(3)


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueDrift(HiddenEffect):
    """A slowly growing error of the torque sensor, zero at the start."""

    summary = "the zero of the torque sensor moves during the recording"
    felt_at_rest = True
    forms = ("ramp", "random_walk", "thermal")

    torque_nm: float = strength(0.3, "error at the end of the recording", "N m", lower=-inf)
    settling_s: float = number(20.0, "time constant of the thermal form", "s", lower=0.001)
    form: int = RAMP


def reading_nm(group: TorqueDrift, t: Float, rng: np.random.Generator) -> Float:
    """Return what is added to the interaction torque as read, shape (n,). [N m]

    Only a random walk of some strength draws random numbers.
    """
    if group.torque_nm == 0.0:
        return np.zeros_like(t)
    elapsed = t - t[0]
    if group.form == RANDOM_WALK:
        steps = rng.normal(0.0, 1.0, len(t) - 1) * np.sqrt(np.diff(t) / elapsed[-1])
        return group.torque_nm * np.concatenate(([0.0], np.cumsum(steps)))
    if group.form == THERMAL:
        return np.asarray(group.torque_nm * np.expm1(-elapsed / group.settling_s) / _settled(group, elapsed[-1]))
    return np.asarray(group.torque_nm * (elapsed / elapsed[-1]))


def _settled(group: TorqueDrift, duration: float) -> float:
    return math.expm1(-duration / group.settling_s)
