"""Cable spring: a cable or hose along the arm pulls the joint back."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

LINEAR, HARDENING, SLACK, TETHER = range(4)

HARDENING_RAD = 1.0
"""Distance from the centre at which the hardening form is twice as strong as the linear one. [rad]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class CableSpring:
    """A spring from the arm to the joint, behind the sensor.

    Attributes:
        stiffness_nm_per_rad: Where it pulls; of the hardening form at the centre. [N m/rad]
        centre_rad: Where it does not pull. [rad]
        free_rad: Distance from the centre over which a slack cable or a tether hangs loose. [rad]
        form: Index into the forms of the effect.
    """

    stiffness_nm_per_rad: float = 0.0
    centre_rad: float = 0.0
    free_rad: float = 0.3
    form: int = LINEAR


@compiled()
def torque_nm(group: Any, q: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the torque towards the centre, on the motor's side of the sensor. [N m]

    Conservative in every form. A slack cable pulls beyond its free play on both sides, a tether on the upper side only.
    """
    stretch = q - group.centre_rad
    if group.form == HARDENING:
        stretch *= 1.0 + (stretch / HARDENING_RAD) ** 2
    elif group.form == SLACK:
        stretch -= min(max(stretch, -group.free_rad), group.free_rad)
    elif group.form == TETHER:
        stretch = max(0.0, stretch - group.free_rad)
    return float(-group.stiffness_nm_per_rad * stretch)


EFFECT = Effect(
    name="cable_spring",
    family="load and place",
    summary="a cable or hose pulls the joint back",
    group=CableSpring,
    strength="stiffness_nm_per_rad",
    parameters=(
        Parameter(name="stiffness_nm_per_rad", usual=0.4, meaning="stiffness where it pulls [N m/rad]", high=2e3),
        Parameter(name="centre_rad", usual=0.0, meaning="position where it does not pull [rad]", low=-math.inf),
        Parameter(name="free_rad", usual=0.3, meaning="free play of a slack cable or a tether [rad]"),
    ),
    forms=("linear", "hardening", "slack", "tether"),
)
