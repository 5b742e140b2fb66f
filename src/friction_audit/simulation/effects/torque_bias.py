"""Torque bias: the torque sensor does not read zero without a load."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueBias:
    """A constant error of the torque sensor.

    Attributes:
        torque_nm: What it reads without a load. [N m]
    """

    torque_nm: float = 0.0


def reading_nm(group: TorqueBias, t: Float) -> Float:
    """Return what is added to the interaction torque as read, shape (n,). [N m]

    Args:
        group: The bias.
        t: Time, shape (n,). [s]
    """
    return np.full(len(t), group.torque_nm)


EFFECT = Effect(
    name="torque_bias",
    family="sensors",
    summary="the torque sensor does not read zero without a load",
    group=TorqueBias,
    strength="torque_nm",
    parameters=(Parameter(name="torque_nm", usual=0.15, meaning="reading without a load [N m]", low=-math.inf),),
)
