"""Inertial coupling: a joint's rotor also turns with the neighbouring joint."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter


@dataclass(frozen=True, kw_only=True, slots=True)
class InertialCoupling:
    """Coupling of the rotor to the neighbouring joint nearer to the base.

    Attributes:
        ratio: Turns of the rotor, seen behind its gear, per turn of that joint: one over the gear ratio for a rotor
            that rides on the neighbour with its axis parallel, up to 1 in a differential.
    """

    ratio: float = 0.0


def coupled_mass(inertias: Float, ratios: Float) -> Float:
    """Return the mass matrix of the rotors behind the sensors, symmetric and positive semidefinite, shape (n, n).

    The kinetic energy is the sum of B_i / 2 (dq_i + ratio_i dq_{i-1})^2 (De Luca and Book, Robots with flexible
    elements, 2016). Diagonal to the bit where all ratios are 0; the first joint has no neighbour.

    Args:
        inertias: Reflected inertias B, shape (n,). [kg m^2]
        ratios: Coupling ratios, shape (n,); the first is not used.
    """
    mass = np.diag(np.asarray(inertias, dtype=np.float64))
    for joint in range(1, len(inertias)):
        shared = inertias[joint] * ratios[joint]
        mass[joint - 1, joint - 1] += shared * ratios[joint]
        mass[joint - 1, joint] += shared
        mass[joint, joint - 1] += shared
    return mass


EFFECT = Effect(
    name="inertial_coupling",
    family="structure",
    summary="a joint's rotor also turns with the neighbouring joint nearer to the base",
    group=InertialCoupling,
    strength="ratio",
    parameters=(
        Parameter(name="ratio", usual=0.2, meaning="turns after the gear per turn of the neighbour", low=-math.inf),
    ),
    needs_neighbours=True,
)
