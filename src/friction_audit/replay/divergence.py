"""A loop that has run away: caught, silenced and said so, never a silent NaN."""

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

SPEED_BOUND_RAD_S = 100.0
"""No arm with torque sensors turns nearly as fast. [rad/s]"""

TORQUE_BOUND_NM = 1e4
"""Nor can its joints bear nearly as much. [N m]"""

REVERSALS = 50
"""So many ticks in a row a torque at its limit has turned back: the limits hold a loop that would grow without them.

Noise does that for three or four ticks, a hand for one.
"""


@compiled()
def beyond(value: float, bound: float) -> bool:
    """Return True if a value is not finite or larger than its bound."""
    return not abs(value) <= bound


def diverged(
    dq: Float,
    torque_nm: Float,
    *,
    speed_bound_rad_s: float = SPEED_BOUND_RAD_S,
    torque_bound_nm: float = TORQUE_BOUND_NM,
) -> int | None:
    """Return the first sample at which a closed loop has diverged, None if it never does.

    Args:
        dq: Velocity, shape (n,). [rad/s]
        torque_nm: Torque of the compensator, or at the sensor, shape (n,). [N m]
        speed_bound_rad_s: A speed beyond it, or one that is not finite, is no motion of an arm. [rad/s]
        torque_bound_nm: Likewise of the torque. [N m]
    """
    bounded = (np.abs(dq) <= speed_bound_rad_s) & (np.abs(torque_nm) <= torque_bound_nm)
    return None if bounded.all() else int(np.argmin(bounded))
