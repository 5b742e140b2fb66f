"""Effects whose torque is a coefficient times one quantity of the motion; the nominal terms of a joint model are four.

Friction that differs between the directions acts, by half of its difference, the same way in both: in motion Coulomb
friction that differs is a constant torque, which a sensor without a zero reads at rest too.
"""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, SpeedFriction
from friction_audit.effects.joint_data import JointData, Nominal, both_directions
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution


class OneColumn(Effect):
    """An effect that is a coefficient times ``of`` the motion, shape (n,)."""

    of: "ClassVar[staticmethod[[Motion], Float]]"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        return self.of(motion)[:, None]


class Inertia(OneColumn):
    label = "inertia"
    axis = "acceleration"
    coefficients = (Parameter("inertia_kg_m2", "kg m^2", "reflected inertia", lower=0.0),)
    of = staticmethod(lambda motion: motion.ddq)


class Coulomb(SpeedFriction, OneColumn):
    label = "Coulomb friction"
    coefficients = (Parameter("coulomb_nm", "N m", "friction at any speed", lower=0.0),)
    of = staticmethod(lambda motion: motion.direction)  # 0 at rest, where friction is what holds the joint
    cpp = "{0!r} * direction"


class Viscous(SpeedFriction, OneColumn):
    label = "viscous friction"
    coefficients = (Parameter("viscous_nms_per_rad", "N m s/rad", "friction per velocity", lower=0.0),)
    of = staticmethod(lambda motion: motion.dq)
    cpp = "{0!r} * dq"


class Offset(OneColumn):
    label = "constant torque"
    axis = "time"
    coefficients = (Parameter("offset_nm", "N m", "torque offset"),)
    of = staticmethod(lambda motion: np.ones(len(motion.t)))


NOMINAL = (Inertia(), Coulomb(), Viscous(), Offset())


class AsymmetricCoulomb(OneColumn):
    label = "friction differs by direction"
    axis = "speed"
    coefficients = (Parameter("coulomb_half_difference_nm", "N m", "half of the difference, forward minus backward"),)
    requires = staticmethod(both_directions)
    record = "pass the same places in both directions, with rests"
    separate = {
        "torque_bias": "let the joint rest unloaded for 2 s: a bias is read at rest too, friction is not",
        "gravity_error": "move through at least 1.5 rad both ways, with rests at several places",
        "asymmetric_viscous": "pass the same places slowly and fast in both directions",
        "torque_drift": "let the joint rest unloaded for 2 s early and late: a drift is read at rest too, "
        "friction is not",
    }
    misses = "nothing"
    like_gravity = True
    of = staticmethod(lambda motion: np.abs(np.sign(motion.dq)))


class AsymmetricViscous(OneColumn):
    label = "viscous friction differs by direction"
    axis = "speed"
    coefficients = (
        Parameter("viscous_half_difference_nms_per_rad", "N m s/rad", "half of the difference, forward minus backward"),
    )
    requires = staticmethod(both_directions)
    record = "pass the same places slowly and fast in both directions"
    separate = {
        "torque_bias": "pass the same places slowly and fast in both directions",
        "gravity_error": "pass every place slowly and fast in both directions",
    }
    of = staticmethod(lambda motion: np.abs(motion.dq))


class TorqueBias(OneColumn):
    label = "offset of the torque sensor"
    axis = "time"
    coefficients = (Parameter("torque_bias_nm", "N m", "interaction torque as read without a load"),)
    requires = staticmethod(both_directions)
    record = "let the joint rest unloaded for 2 s"
    separate = {
        "torque_drift": "zero the sensor and let the joint rest unloaded for 2 s early and late: a drift comes back"
    }
    misses = "nothing"
    like_gravity = True
    of = staticmethod(lambda motion: np.ones(len(motion.t)))  # at rest too


class InertiaError(Inertia):
    label = "the stated inertia is wrong"
    coefficients = (Parameter("extra_inertia_kg_m2", "kg m^2", "true minus stated inertia"),)
    record = "repeat the motions at two or more clearly different speeds"
    separate = {"inertial_coupling": "move one joint at a time"}

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        """Return the number or the motion that is lacking; at one frequency gravity is its alternative."""
        return None if "inertia_kg_m2" in nominal.declared else Caution("fitted_inertia")
