"""Torque ripple: a torque, or an error of the sensor, that repeats with the turns of motor and wave generator."""

import math
from dataclasses import dataclass
from math import inf

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

COGGING, READING = range(2)


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRipple(HiddenEffect):
    """Ripple locked to the position."""

    summary = "a torque, or an error of the torque sensor, that repeats with the turns of the motor"
    forms = ("cogging", "reading")

    torque_nm: float = strength(0.1, "amplitude of the first harmonic", "N m", lower=-inf)
    cycles_per_rev: float = number(200.0, "its cycles per revolution of the joint", like="ripple_order")
    second_share: float = number(0.3, "second harmonic relative to the first", lower=-inf)
    form: int = COGGING

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine, order = values.values()
        size = math.hypot(cosine, sine)
        if abs(cosine) <= ALIKE * size:
            must(not setting.driven, "a motor that cogs beyond the sensor is not seen by it")
            return {"torque_nm": -sine, "cycles_per_rev": order, "second_share": 0.0, "form": "cogging"}
        must(abs(sine) <= ALIKE * size, "its ripple has the phase of a sine or of a cosine")
        return {"torque_nm": cosine, "cycles_per_rev": order, "second_share": 0.0, "form": "reading"}


@compiled()
def torque_nm(group: Record, q: float) -> float:
    """Return the cogging torque on the motor, behind the sensor; 0 where the sensor ripples instead. [N m]

    Conservative: it gives back over a cycle what it took.
    """
    if group.form != COGGING:
        return 0.0
    angle = group.cycles_per_rev * q
    return float(group.torque_nm * (math.sin(angle) + group.second_share * math.cos(2.0 * angle)))


def reading_nm(group: TorqueRipple, q: Float) -> Float:
    """Return what a flexspline that is not round adds to the torque as read; 0 where the motor cogs instead. [N m]

    Two and four cycles per turn of the wave generator: Taghirad and Belanger, Intelligent built-in torque sensor for
    harmonic drive systems (1999).
    """
    if group.form != READING:
        return np.zeros_like(q)
    angle = group.cycles_per_rev * q
    return np.asarray(group.torque_nm * (np.cos(angle) + group.second_share * np.sin(2.0 * angle)))
