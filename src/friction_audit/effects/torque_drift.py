"""Drift of the torque sensor's zero during a recording, nothing at its start.

The waves are the principal components of a random walk (K. Karhunen, 1947; M. Loeve, Probability Theory, 1955): no
others catch more of one with as many numbers, and a ramp or a settling needs only the first of them.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

WAVES = 4
SHORTEST_S = 30.0  # sensors drift with their temperature, within minutes: what changes within seconds is the motion's
# A wave is slow that lasts longer than strokes do: else any misfit of the motion's own slow part passes for drift.
CYCLES_PER_HALF_TURN = 2


class TorqueDrift(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sin((i - 1/2) pi x) for i = 1..4 as columns, x the share of the recording that is over.

        Those of waves that are faster than the slowest few, which the values counts, are zero.
        """
        length = motion.t[-1] - motion.t[0]
        share = (motion.t - motion.t[0]) / (length if length > 0.0 else 1.0)
        waves = np.zeros((WAVES, len(share)))
        for k in range(round(values[0]) or WAVES):
            waves[k] = np.sin(np.pi * share * (k + 0.5))
        return waves.T

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        length, found = duration(data), len(np.unique(data.cycle[data.used]))
        needed = CYCLES_PER_HALF_TURN * WAVES
        if length < SHORTEST_S or found < needed:
            return (
                f"{found} cycles in {length:.0f} s: a drift is separated from slow motion over at least {needed} "
                f"cycles and {SHORTEST_S:g} s"
            )
        return both_directions(data, nominal)

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        return tuple({"drift_waves": float(waves)} for waves in range(1, WAVES + 1))


EFFECT = TorqueDrift(
    name="torque_drift",
    label="the torque drifts slowly",
    family="sensors",
    axis="time",
    coefficients=tuple(
        Parameter(f"drift_{i}_nm", "N m", f"wave of {i - 0.5:g} half turns over the recording")
        for i in range(1, WAVES + 1)
    ),
    nonlinear=(
        # Files of earlier versions have all waves and do not say so.
        Parameter(
            "drift_waves",
            "1",
            "0 all waves, 1 the slowest wave alone, else number of the slowest waves",
            lower=0.0,
            upper=WAVES,
            whole=True,
            optional=True,
        ),
    ),
    traits=Trait.EVEN,
    record="let the joint rest unloaded for 2 s early and late",
    separate={
        "warm_up": "pass the same places in both directions early and late, with rests",
        "friction_step": "pass the same places in both directions before and after the change, with rests",
    },
)
