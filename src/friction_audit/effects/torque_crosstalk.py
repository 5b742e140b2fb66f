"""Crosstalk: a torque sensor also feels what the sensors before and after it feel."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.excitation import neighbours_loaded
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

BOTH = 0


class TorqueCrosstalk(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the readings of the joints before and after as columns, 0 where there is none or it is not meant."""
        side = round(values[0])
        columns = np.zeros((len(motion.t), 2))
        if motion.others is None:
            return columns
        joint, sensed = motion.others.joint, motion.others.sensed
        if side <= BOTH and joint > 0:
            columns[:, 0] = sensed[:, joint - 1]
        if side >= BOTH and joint + 1 < sensed.shape[1]:
            columns[:, 1] = sensed[:, joint + 1]
        return columns

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """The neighbours that there are."""
        before, after = data.own_column > 0, data.own_column + 1 < data.others_torque.shape[1]
        sides = ((-1.0, before), (1.0, after), (0.0, before and after))
        return tuple({"crosstalk_side": side} for side, there in sides if there)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return neighbours_loaded(data, nominal)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """A sensor feels its own load best."""
        return bool(np.all(np.abs(coefficients) < 1))


EFFECT = TorqueCrosstalk(
    name="torque_crosstalk",
    label="torque of a neighbour leaks in",
    family="sensors",
    axis="neighbour",
    coefficients=(
        Parameter("crosstalk_before", "1", "share of the previous joint's torque"),
        Parameter("crosstalk_after", "1", "share of the next joint's torque"),
    ),
    nonlinear=(
        Parameter("crosstalk_side", "1", "-1 previous joint, 1 next joint, 0 both", lower=-1, upper=1, whole=True),
    ),
    record="push against a neighbour while the arm rests",
    separate={"inertial_coupling": "move one joint at a time, then push against a neighbour at rest"},
)
