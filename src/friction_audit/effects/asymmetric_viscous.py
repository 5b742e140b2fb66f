"""Viscous friction that differs between the directions: half the difference acts the same way in both."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float


class AsymmetricViscous(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return |dq| as a column."""
        return np.abs(motion.dq)[:, None]

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return both_directions(data, nominal)


EFFECT = AsymmetricViscous(
    name="asymmetric_viscous",
    label="viscous friction differs by direction",
    family="velocity",
    axis="speed",
    coefficients=(
        Parameter("viscous_half_difference_nms_per_rad", "N m s/rad", "half of the difference, forward minus backward"),
    ),
    traits=Trait.SPEED_ONLY,
    record="pass the same places slowly and fast in both directions",
    separate={
        "torque_bias": "pass the same places slowly and fast in both directions",
        "gravity_error": "pass every place slowly and fast in both directions",
    },
)
