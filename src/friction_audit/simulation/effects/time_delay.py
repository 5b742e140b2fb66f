"""Time delay: one signal of the log is older than the other."""

import math
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, strength

TORQUE_LATE, VELOCITY_LATE = range(2)

WHOLE_STEP = 1e-9  # a delay this close to a whole number of steps is meant to be one


@dataclass(frozen=True, kw_only=True, slots=True)
class TimeDelay(HiddenEffect):
    """A delay line in the path of the torque, or of position and velocity."""

    summary = "torque or motion reach the log late"
    forms = ("torque_late", "velocity_late")

    delay_s: float = strength(0.004, "how late", "s", upper=0.1)
    form: int = TORQUE_LATE

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        delay = values["delay_s"]
        return {"delay_s": abs(delay), "form": "torque_late" if delay >= 0.0 else "velocity_late"}


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
