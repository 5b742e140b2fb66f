"""Samples in which the direction of motion is certain, through reversals too, unless the joint rests in them.

A joint that its motor turns around rests until the motor has turned its torque by twice the friction: some milliseconds
in which friction is whatever holds the joint, not Coulomb friction of either sign. A velocity behind a low-pass shows
no such rest. Straight lines through the velocity before and after it do: they reach zero at different times.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

TURN_S = 0.01
"""A reversal that is over after this time may leave no doubt about the direction on either side of it."""
DWELL_S = 1e-3
"""Unless joints rest in it for longer, as a motor's do until it has turned the torque; so much is a log's median."""
ODD_DWELL_S = 3e-3
"""And so much a single one, which noise makes uncertain by a millisecond."""
NEAR_S, FAR_S = 0.008, 0.03
"""Straight lines are laid through the velocity between these times from a reversal: out of the low-pass's reach."""


def certain_direction(dq: Float, dead_speed: float, step_s: float) -> NDArray[np.bool_]:
    """Tell the samples whose direction is certain, those of a quick reversal without a rest among them.

    Args:
        dq: Velocity on an even grid, shape (n,). [rad/s]
        dead_speed: Below it the sign is the noise's. [rad/s]
        step_s: Spacing of the grid. [s]
    """
    sure = np.abs(dq) > dead_speed
    at = np.flatnonzero(sure)
    turns = np.flatnonzero(dq[at[1:]] * dq[at[:-1]] < 0)
    last, first = at[turns], at[turns + 1]
    quick = (first - last - 1) * step_s <= TURN_S
    dwell = _dwell(dq, last[quick], first[quick], step_s)
    rests = bool(len(dwell)) and float(np.median(dwell)) > DWELL_S
    for begin, end, rest in zip(last[quick], first[quick], dwell, strict=True):
        sure[begin : end + 1] = not rests and rest <= ODD_DWELL_S
    return np.asarray(sure, bool)


def _dwell(dq: Float, last: NDArray[np.int64], first: NDArray[np.int64], step_s: float) -> Float:
    """Time between the zeros of straight lines through the velocity before and after reversals, shape (r,). [s]

    Acceleration that changes steadily through a reversal moves both zeros alike. Infinite where the joint turns again.
    """
    near = round(NEAR_S / step_s)
    away = np.arange(near, max(round(FAR_S / step_s), near + 2) + 1)
    before, after = last[:, None] - away, first[:, None] + away
    whole = (before[:, -1] >= 0) & (after[:, -1] < len(dq))
    v_before, v_after = dq[np.maximum(before, 0)], dq[np.minimum(after, len(dq) - 1)]
    whole &= np.all(v_before * dq[last][:, None] > 0, axis=1) & np.all(v_after * dq[first][:, None] > 0, axis=1)
    into, out = _time_to_zero(v_before, away), _time_to_zero(v_after, away)
    whole &= np.isfinite(into) & np.isfinite(out)
    return np.where(whole, (first - last - into - out) * step_s, np.inf)


def _time_to_zero(velocity: Float, away: NDArray[np.int64]) -> Float:
    """Distance, in samples from 0, at which a straight line through velocities (r, k) reaches zero, shape (r,)."""
    centre = away - away.mean()
    slope = velocity @ centre / (centre @ centre)
    level = velocity.mean(axis=1)
    distance = np.full(len(slope), np.inf)
    np.divide(level, slope, out=distance, where=slope * level > 0)
    return distance - float(away.mean())
