"""Energy cycles that the hand of an arm ends for all joints at once (paper, section V.B)."""

import math

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

FILTERED_M_S, UNDER_WAY = range(2)  # state of the hand: its filtered speed, and whether a cycle is under way
CYCLE_STATE = 2
INITIATION_M_S, TERMINATION_M_S = 0.1, 0.025  # hand speeds at which a cycle begins and ends
CORNER_RAD_S = 2.0 * math.pi * 20.0  # of the low-pass on the hand's speed


@compiled()
def hand_rests(cycle: Float, speed: float, dt: float, initiation: float, termination: float) -> bool:
    """Return True if the hand has moved and come to rest again; the caller then resets ``cycle[UNDER_WAY]``.

    The state ``cycle`` of the hand changes by its measured speed [m/s] over a time [s]; a cycle begins above a filtered
    speed and ends at another.
    """
    cycle[FILTERED_M_S] += (1.0 - math.exp(-CORNER_RAD_S * dt)) * (speed - cycle[FILTERED_M_S])
    if cycle[FILTERED_M_S] > initiation:
        cycle[UNDER_WAY] = 1.0
    return bool(cycle[UNDER_WAY] == 1.0 and cycle[FILTERED_M_S] <= termination)


@compiled()
def hand_cuts(
    t: Float, speed: Float, dq: Float, thresholds: tuple[float, float], rest_rad_s: float, minimum_path_rad: float
) -> NDArray[np.int64]:
    """Find where a controller would have ended the cycles of all joints: 1 where a cycle ends, else 0, shape (n,).

    Speed of the end effector, shape (n,) [m/s], velocity of every joint, shape (n, j) [rad/s]; the thresholds are the
    hand speeds at which a cycle begins and ends [m/s]. It goes on until every joint has moved the least path, in which
    motion up to the speed of rest does not count.
    """
    cuts = np.zeros(len(t), np.int64)
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
            cycle[UNDER_WAY] = 0.0
            cuts[i] = 1
            path[:] = 0.0
            added[:] = 0.0
    return cuts
