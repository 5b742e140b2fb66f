"""Effects of the torque sensor and of the path of its signal to the log."""

import math
from collections.abc import Sequence
from math import inf

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, alike, must, number, strength
from friction_audit.simulation.settings import CONTROL_RATE_HZ


class TorqueBias(HiddenEffect):
    summary = "the torque sensor does not read zero without a load"
    felt_at_rest = True
    same_law = ""
    stands_for = ("offset",)

    torque_nm: float = strength(0.15, "reading without a load", like="torque_bias_nm")


RAMP, RANDOM_WALK, THERMAL = range(3)


class TorqueDrift(HiddenEffect):
    summary = "the zero of the torque sensor moves during the recording"
    felt_at_rest = True
    forms = ("ramp", "random_walk", "thermal")

    torque_nm: float = strength(0.3, "error at the end of the recording", "N m", lower=-inf)
    settling_s: float = number(20.0, "time constant of the thermal form", "s", lower=0.001)


def torque_drift_nm(group: TorqueDrift, t: Float, rng: np.random.Generator) -> Float:
    """Return the drift of the measured interaction torque, shape (n,); only a random walk draws numbers. [N m]"""
    elapsed = t - t[0]
    if group.form == RANDOM_WALK:
        steps = rng.normal(0.0, 1.0, len(t) - 1) * np.sqrt(np.diff(t) / elapsed[-1])
        return group.torque_nm * np.concatenate(([0.0], np.cumsum(steps)))
    if group.form == THERMAL:
        return np.asarray(
            group.torque_nm * np.expm1(-elapsed / group.settling_s) / math.expm1(-elapsed[-1] / group.settling_s)
        )
    return np.asarray(group.torque_nm * (elapsed / elapsed[-1]))


TORQUE_LATE, VELOCITY_LATE = range(2)


class TimeDelay(HiddenEffect):
    summary = "torque or motion reach the log late"
    forms = ("torque_late", "velocity_late")

    delay_s: float = strength(0.004, "how late", "s", upper=0.1)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        delay = values["delay_s"]
        return {"delay_s": abs(delay), "form": "torque_late" if delay >= 0.0 else "velocity_late"}


def delayed(delay_s: float, signal: Float, dt: float = 1.0 / CONTROL_RATE_HZ) -> Float:
    """Return a delayed signal, linear between two samples; its first value is held until it arrives."""
    ticks = np.arange(len(signal), dtype=np.float64)
    return np.interp(ticks - delay_s / dt, ticks, signal)


NEXT, PREVIOUS, BOTH = range(3)
# Which neighbours a sensor feels; the next joint is nearer to the hand.
NEIGHBOURS = {NEXT: (1,), PREVIOUS: (-1,), BOTH: (-1, 1)}


class TorqueCrosstalk(HiddenEffect):
    summary = "a torque sensor also feels the load of the neighbouring joint"
    felt_at_rest = True
    forms = ("next", "previous", "both")
    needs_neighbours = True

    share: float = strength(0.08, "share of the neighbour's torque that is read", lower=-1.0, upper=1.0)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        before, after, side = values.values()
        before, after = before * (side <= 0), after * (side >= 0)
        if before == 0.0 or after == 0.0:
            return {"share": before + after, "form": "next" if before == 0.0 else "previous"}
        must(alike(before, after), "its sensors feel both neighbours alike")
        return {"share": 0.5 * (before + after), "form": "both"}


def crosstalk_mixed(groups: Sequence[TorqueCrosstalk], torque: Float) -> Float:
    """Return the torques measured with crosstalk, without it unchanged to the bit, shape (n, j). [N m]"""
    read = torque.copy()
    joints = range(torque.shape[1])
    for joint, group in enumerate(groups):
        for neighbour in (joint + offset for offset in NEIGHBOURS[group.form]):
            if group.share != 0.0 and neighbour in joints:
                read[:, joint] += group.share * torque[:, neighbour]
    return read
