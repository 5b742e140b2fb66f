"""What the rigid-body model of an arm says about one joint: torques per unit of what may be wrong with the model."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float

INERTIAL_PARAMETERS = 10
"""Of a link: mass, first moments x, y, z, and the moments of inertia xx, xy, yy, xz, yz, zz about its joint's frame."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class RigidBody:
    """Torques of one joint on a clock of m times, coarse enough to be stored, fine enough to be interpolated.

    Attributes:
        t: Times, shape (m,). [s]
        links: Numbers (1..j) of the links whose weight is told.
        weight: Torque per unit of first moment x, y, z [kg m] and mass [kg] of those links, by gravity, and by the
            links' inertia where it is in the balance; columns whose weight is no news after those before them zero,
            shape (m, len(links), 4).
        tilt: Gravity torque per unit of gravity along two directions across the vertical [m/s^2], shape (m, 2).
        inertial: Torque M ddq + c of the model; None where the link's inertia is not in the balance, shape (m,). [N m]
        tip: The same per unit of each inertial parameter of the last link, no news zero, shape (m, 10), or None.
    """

    t: Float
    links: tuple[int, ...]
    weight: Float
    tilt: Float
    inertial: Float | None
    tip: Float | None

    def at(self, t: Float, torque: Float) -> Float:
        """Interpolate one of the torques at the times of a motion, shape (n, ...)."""
        from scipy.interpolate import CubicSpline

        if len(self.t) == len(t) and np.array_equal(self.t, t):
            return torque
        return np.asarray(CubicSpline(self.t, torque, axis=0)(t), np.float64)
