"""A torque sensor that does not read zero without a load."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float


class TorqueBias(Effect):
    indistinguishable = ("asymmetric_coulomb",)
    part_of = ("torque_drift",)

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return a column of ones: at rest too."""
        return np.ones((len(motion.t), 1))

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return both_directions(data, nominal)


EFFECT = TorqueBias(
    name="torque_bias",
    label="offset of the torque sensor",
    family="sensors",
    axis="time",
    coefficients=(Parameter("torque_bias_nm", "N m", "interaction torque as read without a load"),),
    traits=Trait.SPEED_ONLY | Trait.EXACT | Trait.EVEN,
    record="let the joint rest unloaded for 2 s",
    separate={
        "torque_drift": "zero the sensor and let the joint rest unloaded for 2 s early and late: a drift comes back"
    },
)
