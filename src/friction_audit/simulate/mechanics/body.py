"""The coordinates of joints with two sides, and the arrays that the loops work on.

Every joint has an inner side, behind the torque sensor, where friction acts, and an outer side beyond it: of a joint
moved by hand the motor and the link, of a robot that moves by itself the link and the motor. A rigid joint turns both
sides by the same angle; an elastic one, or one with backlash, has a coordinate for each.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

FREE = 2.0
"""Mode of a coordinate that nothing holds; the others are -1, 0 and 1: sliding, stuck, sliding."""


class Body(NamedTuple):
    """State and matrices of c coordinates (of n joints), all changed in place.

    Coordinates 0 to n - 1 are the outer sides; the inner side of joint j is coordinate ``inner[j]``.
    """

    inner: NDArray[np.int64]
    """Coordinate of each joint's inner side, shape (n,)."""
    joint: NDArray[np.int64]
    """Joint whose inner side a coordinate is, or -1, shape (c,)."""
    y: Float
    """Positions. [rad]"""
    v: Float
    """Velocities. [rad/s]"""
    a: Float
    """Accelerations of the latest step. [rad/s^2]"""
    mode: Float
    """Sliding direction, 0: stuck, or FREE."""
    level: Float
    """Friction that opposes sliding, its viscous part aside; of a free coordinate the signed torque. [N m]"""
    hold: Float
    """Friction that a stuck coordinate can bear, downwards and upwards, shape (c, 2). [N m]"""
    slip: Float
    """Friction of a stuck coordinate just after it broke away, downwards and upwards, shape (c, 2). [N m]"""
    reaction: Float
    """What holds a stuck coordinate at present. [N m]"""
    force: Float
    """All other torques, at the middle of the step. [N m]"""
    mass: Float
    """Mass matrix, shape (c, c). [kg m^2]"""
    damping: Float
    """Damping matrix of the step, shape (c, c). [N m s/rad]"""
    inner_mass: Float
    """Mass matrix behind the sensors, shape (n, n). [kg m^2]"""
    stiffness: Float
    """Of what drives the outer sides, shape (n, n). [N m/rad]"""
    drive_damping: Float
    """Of what drives the outer sides, shape (n, n). [N m s/rad]"""
    push: Float
    """Torque of the drive on the outer sides with all coordinates at zero, shape (n,). [N m]"""
    push_rate: Float
    """Its rate of change, shape (n,). [N m/s]"""
    support: Float
    """Torque on the inner sides that is held from tick to tick, such as gravity compensation, shape (n,). [N m]"""
    behind: Float
    """All torques behind the sensors except friction and inertia, shape (n,). [N m]"""
    viscous: Float
    """Viscous coefficients of the step, shape (n,). [N m s/rad]"""
    port: Float
    """Torque that the outer side exerts on the inner side, through the sensor, shape (n,). [N m]"""
    friction: Float
    """Friction torque of each joint, shape (n,). [N m]"""
    system: Float
    """Scratch: matrix of the linear equations, shape (c, c)."""
    right: Float
    """Scratch: their right-hand side, shape (c,)."""
    active: NDArray[np.int64]
    """Scratch: the coordinates that are not stuck, shape (c,)."""


def make_body(two_sided: NDArray[np.bool_], free: NDArray[np.bool_], position: Float) -> Body:
    """Return a body at rest.

    Args:
        two_sided: Joints whose sides turn separately, shape (n,).
        free: Joints whose friction never holds rigidly (bristles), shape (n,).
        position: Where the joints are, shape (n,). [rad]
    """
    n, extra = len(two_sided), np.flatnonzero(two_sided)
    c = n + len(extra)
    inner = np.arange(n)
    inner[extra] = n + np.arange(len(extra))
    joint = np.full(c, -1)
    joint[inner] = np.arange(n)
    mode = np.full(c, FREE)
    mode[inner[~free]] = 0.0
    y = np.concatenate([position, position[extra]])
    vectors = {name: np.zeros(c) for name in ("v", "a", "level", "reaction", "force", "right")}
    matrices = {name: np.zeros((c, c)) for name in ("mass", "damping", "system")}
    drive = {name: np.zeros((n, n)) for name in ("inner_mass", "stiffness", "drive_damping")}
    torques = {name: np.zeros(n) for name in ("push", "push_rate", "support", "behind", "viscous", "port", "friction")}
    levels = {name: np.zeros((c, 2)) for name in ("hold", "slip")}
    return Body(
        inner=inner,
        joint=joint,
        y=y,
        mode=mode,
        active=np.zeros(c, np.int64),
        **levels,
        **vectors,
        **matrices,
        **drive,
        **torques,
    )
