"""Joints, their states and coordinates as structured arrays, which compiled code reads by field name.

Every joint has an inner side, where friction acts, and an outer side beyond the torque sensor: motor and link where a
hand moves the joint, link and motor where the robot does. With elasticity or backlash each side has its coordinate.
"""

from collections.abc import Sequence
from dataclasses import astuple, fields
from functools import cache
from typing import Any, NamedTuple, TypeAlias, get_type_hints

import numpy as np

from friction_audit.joint_log import Bool, Float, Int
from friction_audit.simulation.effects.velocity import BRISTLES, LAG_MEMORY
from friction_audit.simulation.settings import TrueMotion

LOOP_MEMORY = 64  # steps of 0.1 ms; the longest dead time is 5 ms

# State of a joint, apart from position and velocity.
STATE = np.dtype(
    [
        ("driven", "?"),  # the motor is on the outer side of the sensor
        ("start_rad", "f8"),  # where the joint was at the start
        ("duration_s", "f8"),  # length of the recording
        ("rest_s", "f8"),  # time since the joint came to rest
        ("speed_seen", "f8"),  # speed that the velocity-dependent part of friction sees
        ("warmth", "f8"),  # 0 cold, 1 warm
        ("port_nm", "f8"),  # torque through the sensor, lagging by one step
        ("compensation_nm", "f8"),  # torque of compensator and passivity controller, held from tick to tick
        ("passivity_nm", "f8"),  # the passivity controller's part of it
        ("unlogged_nm", "f8"),  # torque of a compensator that no log names, held likewise
        ("dissipated_j", "f8"),  # what friction has taken so far
        ("loop_nm", "f8"),  # what the joint torque control adds to the torque that is asked for
        ("loop_steps", "i8"),  # steps since the start
        ("loop_past", "f8", (LOOP_MEMORY,)),  # what it fed back in the latest steps
        ("bristles", "f8", (BRISTLES,)),
        ("lag", "f8", (LAG_MEMORY,)),
    ],
    align=True,
)

MOST = 14  # coordinates: two for each of seven joints
FREE = 2.0  # mode of a coordinate that nothing holds; the others are -1, 0 and 1: sliding, stuck, sliding

# State and matrices of c coordinates of n joints, in the first places of arrays that have room for MOST. Coordinates 0
# to n - 1 are the outer sides; the inner side of joint j is coordinate ``inner[j]``. A record rather than a tuple of
# arrays: compiled functions pass it on as one pointer.
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
        ("level", "f8", (MOST,)),  # friction against sliding without viscous part; if FREE signed, (c,) [N m]
        ("hold", "f8", (MOST, 2)),  # friction that a stuck coordinate can bear, downwards and upwards, (c, 2) [N m]
        ("slip", "f8", (MOST, 2)),  # its friction just after it broke away, (c, 2) [N m]
        ("reaction", "f8", (MOST,)),  # what holds a stuck coordinate at present, (c,) [N m]
        ("force", "f8", (MOST,)),  # all other torques, at the middle of the step, (c,) [N m]
        ("mass", "f8", (MOST, MOST)),  # mass matrix, (c, c) [kg m^2]
        ("damping", "f8", (MOST, MOST)),  # damping matrix of the step, (c, c) [N m s/rad]
        ("inner_mass", "f8", (MOST, MOST)),  # mass matrix of the inner sides, (n, n) [kg m^2]
        ("stiffness", "f8", (MOST, MOST)),  # of what drives the outer sides, (n, n) [N m/rad]
        ("drive_damping", "f8", (MOST, MOST)),  # of what drives the outer sides, (n, n) [N m s/rad]
        ("push", "f8", (MOST,)),  # torque of the drive with all coordinates at zero, (n,) [N m]
        ("push_rate", "f8", (MOST,)),  # its rate of change, (n,) [N m/s]
        ("push_bend", "f8", (MOST,)),  # the rate of change of that, (n,) [N m/s^2]
        ("support", "f8", (MOST,)),  # on the inner sides, held from tick to tick, as gravity compensation, (n,) [N m]
        ("inner_torque", "f8", (MOST,)),  # all torques on the inner sides but friction and inertia, (n,) [N m]
        ("viscous", "f8", (MOST,)),  # viscous coefficients of the step, (n,) [N m s/rad]
        ("port", "f8", (MOST,)),  # torque through the sensor, from the outer side to the inner one, (n,) [N m]
        ("friction", "f8", (MOST,)),  # friction torque, (n,) [N m]
        ("system", "f8", (MOST, MOST)),  # scratch: matrix of the linear equations, (c, c)
        ("right", "f8", (MOST,)),  # scratch: their right-hand side, (c,)
        ("free", "i8"),  # scratch: number of coordinates that are not stuck
        ("active", "i8", (MOST,)),  # scratch: those coordinates, (c,)
    ],
    align=True,
)
Body: TypeAlias = Any  # a record of type BODY


def make_body(two_sided: Bool, free: Bool, position: Float) -> Body:
    """Return a body at rest."""
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


@cache
def record_type(group: type[Any]) -> np.dtype[Any]:
    """Return the record type of a dataclass of numbers and of such dataclasses."""
    plain: dict[Any, Any] = {float: "f8", int: "i8", bool: "?"}
    hints = get_type_hints(group)
    kinds: list[tuple[str, Any]] = [(item.name, hints[item.name]) for item in fields(group)]
    return np.dtype([(name, plain[kind] if kind in plain else record_type(kind)) for name, kind in kinds], align=True)


def pack(settings: Sequence[Any]) -> np.ndarray[Any, Any]:
    """Return the records of dataclasses of one type, one row each."""
    return np.array([astuple(item) for item in settings], record_type(settings[0].__class__))


KEPT = tuple(item.name for item in fields(TrueMotion))[1:]  # written at every tick by ``control_loop.write_truth``
ROWS = len(KEPT)


class Loop(NamedTuple):
    """The compensators and the errors of the sensors that they read."""

    settings: Any  # records of the compensators, shape (n,)
    memory: Any  # their memory, shape (n,); changed
    memory_fields: Int  # a view of the memory, one column per field, shape (n, fields)
    torque_noise: Float  # error of the torque as read, shape (ticks + 1, n) [N m]
    velocity_noise: Float  # error of the velocity as read, shape (ticks + 1, n) [rad/s]
    position_noise: Float  # error of the position as read, shape (ticks + 1, n); no compensator looks at it [rad]
    torque_step: Float  # resolution of the torque, shape (n,) [N m]
    velocity_step: Float  # resolution of the velocity, shape (n,) [rad/s]


class Mechanism(NamedTuple):
    """State of a simulation and its output, n joints; all but joints, dt and substeps is changed."""

    joints: Any  # records of the joints, shape (n,)
    states: Any  # their states, shape (n,)
    events: Float  # contact events, shape (n, m, 3)
    body: Any  # coordinates and matrices
    loop: Loop  # compensators and errors of their sensors
    dt: float  # time from tick to tick of the controller [s]
    substeps: int  # steps of the integration in half a tick
    out: Float  # truth of every tick, shape (ticks + 1, ROWS, n)
    traced: Int  # TRACE of the compensators, shape (ticks + 1, n, fields); no fields without one
