"""The coordinates of joints with two sides, and the arrays that the loops work on.

Every joint has an inner side, behind the torque sensor, where friction acts, and an outer side beyond it: of a joint
moved by hand the motor and the link, of a robot that moves by itself the link and the motor. A rigid joint turns both
sides by the same angle; an elastic one, or one with backlash, has a coordinate for each.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

MOST = 14
"""So many coordinates there can be: two for each of seven joints."""

FREE = 2.0
"""Mode of a coordinate that nothing holds; the others are -1, 0 and 1: sliding, stuck, sliding."""


BODY = np.dtype(
    [
        ("joints", "i8"),  # n
        ("count", "i8"),  # c, coordinates
        ("inner", "i8", (MOST,)),  # coordinate of each joint's inner side, (n,)
        ("joint", "i8", (MOST,)),  # joint whose inner side a coordinate is, or -1, (c,)
        ("y", "f8", (MOST,)),  # positions, (c,) [rad]
        ("v", "f8", (MOST,)),  # velocities, (c,) [rad/s]
        ("a", "f8", (MOST,)),  # accelerations of the latest step, (c,) [rad/s^2]
        ("mode", "f8", (MOST,)),  # sliding direction, 0: stuck, or FREE, (c,)
        (
            "level",
            "f8",
            (MOST,),
        ),  # friction against sliding, less its viscous part; if FREE the signed torque, (c,) [N m]
        ("hold", "f8", (MOST, 2)),  # friction that a stuck coordinate can bear, downwards and upwards, (c, 2) [N m]
        ("slip", "f8", (MOST, 2)),  # its friction just after it broke away, (c, 2) [N m]
        ("reaction", "f8", (MOST,)),  # what holds a stuck coordinate at present, (c,) [N m]
        ("force", "f8", (MOST,)),  # all other torques, at the middle of the step, (c,) [N m]
        ("mass", "f8", (MOST, MOST)),  # mass matrix, (c, c) [kg m^2]
        ("damping", "f8", (MOST, MOST)),  # damping matrix of the step, (c, c) [N m s/rad]
        ("inner_mass", "f8", (MOST, MOST)),  # mass matrix behind the sensors, (n, n) [kg m^2]
        ("stiffness", "f8", (MOST, MOST)),  # of what drives the outer sides, (n, n) [N m/rad]
        ("drive_damping", "f8", (MOST, MOST)),  # of what drives the outer sides, (n, n) [N m s/rad]
        ("push", "f8", (MOST,)),  # torque of the drive with all coordinates at zero, (n,) [N m]
        ("push_rate", "f8", (MOST,)),  # its rate of change, (n,) [N m/s]
        ("push_bend", "f8", (MOST,)),  # the rate of change of that, (n,) [N m/s^2]
        ("support", "f8", (MOST,)),  # on the inner sides, held from tick to tick, as gravity compensation, (n,) [N m]
        ("behind", "f8", (MOST,)),  # all torques behind the sensors but friction and inertia, (n,) [N m]
        ("viscous", "f8", (MOST,)),  # viscous coefficients of the step, (n,) [N m s/rad]
        ("port", "f8", (MOST,)),  # torque through the sensor, from the outer side to the inner one, (n,) [N m]
        ("friction", "f8", (MOST,)),  # friction torque, (n,) [N m]
        ("system", "f8", (MOST, MOST)),  # scratch: matrix of the linear equations, (c, c)
        ("right", "f8", (MOST,)),  # scratch: their right-hand side, (c,)
        ("active", "i8", (MOST,)),  # scratch: the coordinates that are not stuck, (c,)
    ],
    align=True,
)
"""State and matrices of c coordinates of n joints, in the first places of arrays that have room for MOST.

Coordinates 0 to n - 1 are the outer sides; the inner side of joint j is coordinate ``inner[j]``. A record rather than a
tuple of arrays: compiled functions pass it on as one pointer.
"""

Body: TypeAlias = Any
"""A record of type BODY."""


def make_body(two_sided: NDArray[np.bool_], free: NDArray[np.bool_], position: Float) -> Body:
    """Return a body at rest.

    Args:
        two_sided: Joints whose sides turn separately, shape (n,).
        free: Joints whose friction never holds rigidly (bristles), shape (n,).
        position: Where the joints are, shape (n,). [rad]
    """
    n, extra = len(two_sided), np.flatnonzero(two_sided)
    c = n + len(extra)
    body = np.zeros(1, BODY).view(np.recarray)[0]
    body.joints, body.count = n, c
    body.inner[:n] = np.arange(n)
    body.inner[extra] = n + np.arange(len(extra))
    body.joint[:] = -1
    body.joint[body.inner[:n]] = np.arange(n)
    body.mode[:] = FREE
    body.mode[body.inner[:n][~free]] = 0.0
    body.y[:c] = np.concatenate([position, position[extra]])
    return body
