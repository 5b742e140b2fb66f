"""Velocity and acceleration from the position, as instruments for those from the measured velocity.

The noise of the measured velocity is in its derivative too, and least squares takes a noisy column for less than it
is: it finds too little inertia. The position has a noise of its own, so what its differences share with the velocity
and the acceleration is the motion alone.

References:
    T. Soderstrom, P. Stoica, Instrumental variable methods for system identification, Springer 1983.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

BLOCK_S = 0.02
"""The position is averaged over so long: the finer part of its noise and resolution goes. [s]"""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Instruments:
    """Motion by the position at m rows.

    Attributes:
        velocity: Shape (m,). [rad/s]
        acceleration: Shape (m,). [rad/s^2]
    """

    velocity: Float
    acceleration: Float


def block_length(step_s: float) -> int:
    """Return how many samples are averaged, an odd number so that the average has a middle."""
    return 2 * int(0.5 * BLOCK_S / step_s) + 1


def reach(block: int) -> int:
    """Return how many samples before and after a row its instruments need."""
    return block + block // 2


def instruments_at(t: Float, q: Float, index: NDArray[np.int64], block: int) -> Instruments:
    """Difference the averages of three neighbouring blocks of the position.

    Args:
        t: Time, shape (n,). [s]
        q: Position, shape (n,). [rad]
        index: Samples at the rows, ``reach(block)`` from both ends at least, shape (m,).
        block: Samples per block.
    """
    around = index[:, None] + np.arange(-reach(block), reach(block) + 1)
    before, here, after = q[around].reshape(len(index), 3, block).mean(axis=2).T
    first, middle, last = t[around].reshape(len(index), 3, block).mean(axis=2).T
    left, right = (here - before) / (middle - first), (after - here) / (last - middle)
    return Instruments(velocity=(after - before) / (last - first), acceleration=2.0 * (right - left) / (last - first))
