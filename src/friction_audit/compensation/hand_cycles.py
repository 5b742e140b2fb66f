"""A loop that has run away: caught, silenced and said so, never a silent NaN."""

import math

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float, read_only

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


FILTERED_M_S, UNDER_WAY = range(2)
CYCLE_STATE = 2
"""What is remembered of the hand: its filtered speed, and whether a cycle is under way."""

INITIATION_M_S, TERMINATION_M_S = 0.1, 0.025
"""Hand speeds at which a cycle begins and ends. [m/s]"""

CORNER_RAD_S = 2.0 * math.pi * 20.0
"""Corner of the low-pass on the hand's speed. [rad/s]"""


@compiled()
def hand_rests(cycle: Float, speed: float, dt: float, initiation: float, termination: float) -> bool:
    """Return True if the hand has moved and come to rest again; the caller ends the cycle with ``end_cycle``.

    Args:
        cycle: What is remembered of the hand, shape (CYCLE_STATE,); changed.
        speed: Speed of the end effector as measured. [m/s]
        dt: Time since the previous call. [s]
        initiation: Filtered speed above which a cycle begins. [m/s]
        termination: Filtered speed at which it ends. [m/s]
    """
    cycle[FILTERED_M_S] += (1.0 - math.exp(-CORNER_RAD_S * dt)) * (speed - cycle[FILTERED_M_S])
    if cycle[FILTERED_M_S] > initiation:
        cycle[UNDER_WAY] = 1.0
    return bool(cycle[UNDER_WAY] == 1.0 and cycle[FILTERED_M_S] <= termination)


@compiled()
def end_cycle(cycle: Float) -> None:
    """Wait for the hand to move again."""
    cycle[UNDER_WAY] = 0.0


@compiled()
def _find_cuts(
    t: Float,
    speed: Float,
    dq: Float,
    thresholds: tuple[float, float],
    rest_rad_s: float,
    minimum_path_rad: float,
    cuts: NDArray[np.int64],
) -> None:
    cycle = np.zeros(CYCLE_STATE)
    joints = dq.shape[1]
    path, added = np.zeros(joints), np.zeros(joints)
    for i in range(1, len(t)):
        dt = t[i] - t[i - 1]
        rests = hand_rests(cycle, speed[i], dt, thresholds[0], thresholds[1])
        for j in range(joints):
            path[j] += added[j]
            a, b = abs(dq[i - 1, j]), abs(dq[i, j])
            added[j] = 0.5 * ((a if a > rest_rad_s else 0.0) + (b if b > rest_rad_s else 0.0)) * dt
        if rests and path.min() >= minimum_path_rad:
            end_cycle(cycle)
            cuts[i] = 1
            path[:] = 0.0
            added[:] = 0.0


def hand_cuts(
    t: Float,
    hand_speed: Float,
    dq: Float,
    *,
    thresholds: tuple[float, float],
    rest_rad_s: float,
    minimum_path_rad: float,
) -> NDArray[np.int64]:
    """Find where a controller would have ended the cycles of all joints.

    Args:
        t: Time, shape (n,). [s]
        hand_speed: Speed of the end effector, shape (n,). [m/s]
        dq: Velocity of every joint, shape (n, j). [rad/s]
        thresholds: Hand speeds at which a cycle begins and ends. [m/s]
        rest_rad_s: Speed up to which a joint counts as at rest. [rad/s]
        minimum_path_rad: A cycle goes on until every joint has moved this far. [rad]

    Returns:
        1 where a cycle ends, else 0, shape (n,).
    """
    cuts = np.zeros(len(t), np.int64)
    _find_cuts(read_only(t), read_only(hand_speed), read_only(dq), thresholds, rest_rad_s, minimum_path_rad, cuts)
    return cuts
