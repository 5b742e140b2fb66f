"""Inertia error: the inertia behind the sensor is not the one that was stated."""

from collections.abc import Sequence

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.excitation import moves
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

NOT_DECLARED = (
    "the inertia was fitted to this log, so it cannot be wrong: state it (--joint-model with inertia_kg_m2), and move "
    "at two or more frequencies"
)


class InertiaError(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return ddq as a column."""
        return motion.ddq[:, None]

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        """The number or the motion that is lacking.

        At one frequency the acceleration runs as the position does: then gravity is its alternative, and it gravity's.
        """
        return moves(data, nominal) if "inertia_kg_m2" in nominal.declared else NOT_DECLARED


EFFECT = InertiaError(
    name="inertia_error",
    label="the stated inertia is wrong",
    family="structure",
    axis="acceleration",
    coefficients=(Parameter("extra_inertia_kg_m2", "kg m^2", "true minus stated inertia"),),
    record="repeat the motions at two or more clearly different speeds",
    separate={"inertial_coupling": "move one joint at a time"},
)
