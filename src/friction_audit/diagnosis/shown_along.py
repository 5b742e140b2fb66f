"""Whether the torque of an effect is a curve over one quantity, so that a place on that axis says where it is."""

import numpy as np

from friction_audit.joint_log import Float

STRETCHES = 24
"""Of the axis, with equally many rows each."""
MOST_HIDDEN = 0.5
"""Share of the torque's mean square that may lie beside the curve."""


def shows_along(torque: Float, along: Float, dq: Float) -> bool:
    """Return whether most of a torque is a curve over a quantity, one for each direction of motion.

    A torque that rings, comes late or follows other joints has both signs at each place of any axis of this joint's
    motion: its mean there is next to nothing, and where that mean is largest is chance.

    Args:
        torque: Of an effect at the rows, free of noise, shape (m,). [N m]
        along: The quantity, shape (m,).
        dq: Velocity, shape (m,). [rad/s]
    """
    beside = sum(_beside(torque[which], along[which]) for which in (dq > 0, dq <= 0))
    return beside <= MOST_HIDDEN * float(torque @ torque)


def _beside(torque: Float, along: Float) -> float:
    """Return the sum of squares beside the means of the stretches. [N^2 m^2]"""
    parts = np.array_split(torque[np.argsort(along, kind="stable")], STRETCHES)
    return float(sum(len(part) * part.var() for part in parts if len(part)))
