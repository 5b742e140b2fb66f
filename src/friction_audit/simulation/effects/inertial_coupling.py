"""Inertial coupling: a joint's rotor also turns with the neighbouring joint."""

from dataclasses import dataclass
from math import inf

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import HiddenEffect, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class InertialCoupling(HiddenEffect):
    """Coupling of the rotor to the neighbouring joint nearer to the base."""

    summary = "a joint's rotor also turns with the neighbouring joint nearer to the base"
    needs_neighbours = True
    needs_moving_neighbour = True

    ratio: float = strength(0.2, "turns after the gear per turn of the neighbour", lower=-inf)


def coupled_mass(inertias: Float, ratios: Float) -> Float:
    """Return the mass matrix of the rotors behind the sensors, symmetric and positive semidefinite, shape (n, n).

    The kinetic energy is the sum of B_i / 2 (dq_i + ratio_i dq_{i-1})^2 (De Luca and Book, Robots with flexible
    elements, 2016). Diagonal to the bit where all ratios are 0; the first joint has no neighbour.
    """
    mass = np.diag(np.asarray(inertias, dtype=np.float64))
    for joint in range(1, len(inertias)):
        shared = inertias[joint] * ratios[joint]
        mass[joint - 1, joint - 1] += shared * ratios[joint]
        mass[joint - 1, joint] += shared
        mass[joint, joint - 1] += shared
    return mass
