"""Torque ripple: a torque, or an error of the sensor, that repeats with the turns of motor and wave generator."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter

COGGING, READING = range(2)


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueRipple:
    """Ripple locked to the position.

    Attributes:
        torque_nm: Amplitude of the first harmonic. [N m]
        cycles_per_rev: Its cycles per revolution of the joint; 200 is twice per turn of the motor at a ratio of 100.
        second_share: Amplitude of the second harmonic relative to the first.
        form: Index into the forms of the effect.
    """

    torque_nm: float = 0.0
    cycles_per_rev: float = 200.0
    second_share: float = 0.3
    form: int = COGGING


@compiled()
def torque_nm(group: Any, q: float) -> float:  # noqa: ANN401 - a record of numbers
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

    Args:
        group: The ripple.
        q: Joint position, shape (n,). [rad]
    """
    if group.form != READING:
        return np.zeros_like(q)
    angle = group.cycles_per_rev * q
    return np.asarray(group.torque_nm * (np.cos(angle) + group.second_share * np.sin(2.0 * angle)))


EFFECT = Effect(
    name="torque_ripple",
    family="load and place",
    summary="a torque, or an error of the torque sensor, that repeats with the turns of the motor",
    group=TorqueRipple,
    strength="torque_nm",
    parameters=(
        Parameter(name="torque_nm", usual=0.1, meaning="amplitude of the first harmonic [N m]", low=-math.inf),
        Parameter(name="cycles_per_rev", usual=200.0, meaning="its cycles per revolution of the joint"),
        Parameter(name="second_share", usual=0.3, meaning="second harmonic relative to the first", low=-math.inf),
    ),
    forms=("cogging", "reading"),
)
