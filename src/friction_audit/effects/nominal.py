"""The nominal terms of a joint model: inertia, Coulomb and viscous friction, a constant torque."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Trait
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float


class Inertia(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        return motion.ddq[:, None]


class Coulomb(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) as a column, 0 at rest, where friction is what holds the joint."""
        return motion.direction[:, None]

    def in_cpp(self, values: Sequence[float], table: str) -> str:
        return f"{values[0]!r} * way"


class Viscous(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        return motion.dq[:, None]

    def in_cpp(self, values: Sequence[float], table: str) -> str:
        return f"{values[0]!r} * dq"


class Offset(Effect):
    """A sensor's zero, or Coulomb friction that differs between the directions, which in motion is the same."""

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        return np.ones((len(motion.t), 1))


NOMINAL = (
    Inertia(
        name="inertia",
        label="inertia",
        family="nominal",
        axis="acceleration",
        coefficients=(Parameter("inertia_kg_m2", "kg m^2", "reflected inertia", lower=0.0),),
    ),
    Coulomb(
        name="coulomb",
        label="Coulomb friction",
        family="nominal",
        axis="speed",
        coefficients=(Parameter("coulomb_nm", "N m", "friction at any speed", lower=0.0),),
        traits=Trait.FRICTION | Trait.SPEED_ONLY,
    ),
    Viscous(
        name="viscous",
        label="viscous friction",
        family="nominal",
        axis="speed",
        coefficients=(Parameter("viscous_nms_per_rad", "N m s/rad", "friction per velocity", lower=0.0),),
        traits=Trait.FRICTION | Trait.SPEED_ONLY,
    ),
    Offset(
        name="offset",
        label="constant torque",
        family="nominal",
        axis="time",
        coefficients=(Parameter("offset_nm", "N m", "torque offset"),),
        traits=Trait.SPEED_ONLY,
    ),
)
