"""The sign of a velocity, a mean over the cell of each sample.

A sharp sign changes at a sample, a reversal anywhere between two. At 400 Hz that is a millisecond of twice the Coulomb
friction, more than the noise of a good sensor; and a column that is sharp beside one that was integrated over cells
would leave the difference for an effect.
"""

import numpy as np

from friction_audit.joint_log import Float


def mean_sign(t: Float, dq: Float, ddq: Float) -> Float:
    """Return the mean sign of a velocity from half a sample before to half a sample after, shape (n,).

    Args:
        t: Evenly spaced times, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        ddq: Its slope there, shape (n,). [rad/s^2]
    """
    if len(t) < 2:  # noqa: PLR2004 - one sample has no cell
        return np.sign(dq)
    change = np.maximum(0.5 * (t[1] - t[0]) * np.abs(ddq), np.abs(dq))
    return np.asarray(np.divide(dq, change, out=np.zeros(len(dq)), where=change > 0.0))
