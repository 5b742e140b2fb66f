"""Gravity error: the gravity torque that is subtracted is not the one that the motor holds."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class GravityError:
    """A wrong mass, a wrong centre of mass, an unknown payload or a tilted base.

    All of them are the same for one joint: an amplitude and a phase.

    Attributes:
        torque_nm: Amplitude. [N m]
        phase_rad: Phase at q = 0; a quarter turn is a centre of mass sideways, or a tilted base. [rad]
    """

    torque_nm: float = 0.0
    phase_rad: float = 0.0


def reading_nm(group: GravityError, q: Float) -> Float:
    """Return by how much the gravity torque that is subtracted is too large, shape (n,). [N m]

    The interaction torque comes out too large by it where a hand moves the joint, too small where the robot does.

    Args:
        group: The error.
        q: Joint position, shape (n,). [rad]
    """
    return np.asarray(group.torque_nm * np.sin(q + group.phase_rad))


EFFECT = Effect(
    name="gravity_error",
    family="load and place",
    summary="the gravity torque that is subtracted is wrong",
    group=GravityError,
    strength="torque_nm",
    parameters=(
        Parameter(name="torque_nm", usual=0.3, meaning="amplitude [N m]", low=-math.inf),
        Parameter(name="phase_rad", usual=0.0, meaning="phase at q = 0 [rad]", low=-math.inf),
    ),
)
