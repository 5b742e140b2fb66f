"""Coulomb friction that differs between the directions: half the difference acts the same way in both."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float


class AsymmetricCoulomb(Effect):
    indistinguishable = ("torque_bias",)
    part_of = ("torque_drift",)

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return |sgn(dq)| as a column: 1 in motion, 0 at rest."""
        return np.abs(np.sign(motion.dq))[:, None]

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return both_directions(data, nominal)


EFFECT = AsymmetricCoulomb(
    name="asymmetric_coulomb",
    label="friction differs by direction",
    family="velocity",
    axis="speed",
    coefficients=(Parameter("coulomb_half_difference_nm", "N m", "half of the difference, forward minus backward"),),
    traits=Trait.SPEED_ONLY | Trait.EXACT,
    record="pass the same places in both directions, with rests",
    separate={
        "torque_bias": "let the joint rest unloaded for 2 s: a bias is read at rest too, friction is not",
        "gravity_error": "move through at least 1.5 rad both ways, with rests at several places",
        "asymmetric_viscous": "pass the same places slowly and fast in both directions",
        "torque_drift": "let the joint rest unloaded for 2 s early and late: a drift is read at rest too, "
        "friction is not",
    },
)
