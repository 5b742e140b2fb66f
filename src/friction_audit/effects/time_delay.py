"""Time delay: the torque reaches the log later than the motion, or earlier if the delay is below zero.

The regressor is the torque of inertia and friction, read earlier by a step, less what it is now, per step: jumps at
reversals stay jumps. It is exact where the delay is the step. It is read between samples by a cubic spline: a straight
line damps the more the farther from a sample, so that delays of half a step would fit smoothed reversals
(effects_time_delay_40001). Where a late sensor bears a load too, what was taken away for the load was taken too early.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import simple_torque
from friction_audit.effects.effect import BatchedEffect, Nonlinear, Trait
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import EvenSpline

STEPS_S = np.geomspace(1e-3, 0.1, 13)
# Delay found over the delay for which jumps are right; a shorter delay than the shortest looks just like it.
LEAST_SHARE, LARGEST_SHARE = 0.5, 1.6


class TimeDelay(BatchedEffect):
    follows = True

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield (rest(t - s) - rest(t)) / s, first and last value held, of the torque with the load or without."""
        for loaded in {bool(round(with_load)) for _, with_load in many}:
            rest = simple_torque(motion)
            if loaded and motion.load is not None:
                rest = rest + motion.load
            spline, spacing = EvenSpline(rest, held=True), float(motion.t[-1] - motion.t[0]) / (len(motion.t) - 1)
            for place, (step, with_load) in enumerate(many):
                if bool(round(with_load)) is loaded:
                    yield place, (spline.ahead(-step / spacing) - rest)[:, None] / step

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """All delays, of friction and inertia alone and, where there is a load, of all that the sensor bears."""
        loads = (0.0,) if data.load is None else (0.0, 1.0)
        return tuple(
            {"delay_step_s": float(sign * step), "delayed_load": load}
            for load in loads
            for sign in (1.0, -1.0)
            for step in STEPS_S
        )

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        """The motion that is lacking: jumps of friction show it, at equally fast motions too."""
        return reversals(data, nominal)

    def coefficient_of(self, at: Nonlinear) -> float:
        return at["delay_step_s"]

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        share = coefficients[0] / at["delay_step_s"]
        least = 0.0 if abs(at["delay_step_s"]) <= STEPS_S[0] else LEAST_SHARE
        return bool(least < share <= LARGEST_SHARE)


EFFECT = TimeDelay(
    name="time_delay",
    label="torque and velocity are not simultaneous",
    family="sensors",
    axis="acceleration",
    coefficients=(Parameter("delay_s", "s", "delay of the torque", lower=-1.0, upper=1.0),),
    nonlinear=(
        Parameter("delay_step_s", "s", "delay for which jumps are right", lower=-1.0, upper=1.0),
        Parameter("delayed_load", "1", "1 if the load is late too", lower=0.0, upper=1.0, whole=True),
    ),
    traits=Trait.NEEDS_NOMINAL,
    forward="delay",
    record="reverse sharply at two or more clearly different speeds",
    separate={"joint_elasticity": "reverse sharply, slowly and fast: a spring rings, a delay shifts"},
)
