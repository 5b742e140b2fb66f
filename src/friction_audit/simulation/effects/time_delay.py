"""Time delay: one signal of the log is older than the other."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter

TORQUE_LATE, VELOCITY_LATE = range(2)

WHOLE_STEP = 1e-9
"""A delay this close to a whole number of steps is meant to be one."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TimeDelay:
    """A delay line in the path of the torque, or of position and velocity.

    Attributes:
        delay_s: How much older the late signal is. [s]
        form: Index into the forms of the effect.
    """

    delay_s: float = 0.0
    form: int = TORQUE_LATE


def delayed(signal: Float, delay_s: float, dt: float) -> Float:
    """Return a signal that comes late, the first value held until it arrives; the very same array without a delay.

    Between two samples the line is read linearly: finely sampled, it neither overshoots at a jump nor smooths much.

    Args:
        signal: Finely sampled truth, shape (n,) or (n, j).
        delay_s: Delay, not negative.
        dt: Spacing of the samples.
    """
    if delay_s == 0.0:
        return signal
    steps = delay_s / dt
    whole = math.floor(steps + WHOLE_STEP)
    part = max(0.0, steps - whole)
    newer = np.maximum(np.arange(len(signal)) - whole, 0)
    if part <= WHOLE_STEP:
        return signal[newer]
    return np.asarray((1.0 - part) * signal[newer] + part * signal[np.maximum(newer - 1, 0)])


EFFECT = Effect(
    name="time_delay",
    family="sensors",
    summary="torque or motion reach the log late",
    group=TimeDelay,
    strength="delay_s",
    parameters=(Parameter(name="delay_s", usual=4e-3, meaning="how late [s]", high=0.1),),
    forms=("torque_late", "velocity_late"),
)
