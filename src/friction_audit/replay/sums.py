"""Work, mean square and peak of a torque along a motion, in one pass and without working memory; compiled."""

import math

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float


@compiled()
def sum_up(t: Float, dq: Float, torque: Float) -> tuple[float, float, float]:
    """Return work [J], root mean square over the time [N m] and largest magnitude [N m] of a torque.

    Args:
        t: Time, shape (n,), n at least 2. [s]
        dq: Velocity, shape (n,). [rad/s]
        torque: Shape (n,). [N m]
    """
    work = square = 0.0
    peak = abs(torque[0])
    for i in range(1, len(t)):
        dt = t[i] - t[i - 1]
        work += 0.25 * (torque[i - 1] + torque[i]) * (dq[i - 1] + dq[i]) * dt
        square += 0.5 * (torque[i - 1] * torque[i - 1] + torque[i] * torque[i]) * dt
        peak = max(peak, abs(torque[i]))
    return work, math.sqrt(square / (t[-1] - t[0])), peak


@compiled()
def largest_sum(first: Float, second: Float) -> float:
    """Return the largest magnitude of the sum of two signals, shape (n,)."""
    peak = 0.0
    for i in range(len(first)):
        peak = max(peak, abs(first[i] + second[i]))
    return peak
