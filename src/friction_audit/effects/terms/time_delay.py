"""Time delay: the torque reaches the log later than the motion, or earlier if the delay is below zero.

The regressor is the torque of inertia and friction, read earlier by a step, less what it is now, per step: jumps at
reversals stay jumps. It is exact where the delay is the step. Where a late sensor bears a load too, what was taken away
for the load was taken too early.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import simple_torque
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return (rest(t - s) - rest(t)) / s as a column, the first and the last value held; with the load or without."""
    step, with_load = shape
    rest = simple_torque(motion)
    if round(with_load) and motion.load is not None:
        rest = rest + motion.load
    return np.asarray((np.interp(motion.t - step, motion.t, rest) - rest) / step)[:, None]


TERM = Term(
    name="time_delay",
    label="torque and motion are not simultaneous",
    coefficients=(
        Parameter(name="delay_s", unit="s", meaning="by how much the torque is late", lower=-1.0, upper=1.0),
    ),
    nonlinear=(
        Parameter(name="delay_step_s", unit="s", meaning="delay for which jumps are right", lower=-1.0, upper=1.0),
        Parameter(name="delayed_load", unit="1", meaning="1 if the load is late too", lower=0.0, upper=1.0, whole=True),
    ),
    basis=basis,
    forward="delay",
)
