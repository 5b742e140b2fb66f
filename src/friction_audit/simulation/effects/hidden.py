"""The registry of hidden effects, and what is hidden in one joint: a group of each, which does nothing by default."""

from dataclasses import dataclass, fields, replace
from typing import Any, Self, get_type_hints

from friction_audit.errors import UsageError
from friction_audit.simulation.effects.asymmetric_coulomb import AsymmetricCoulomb
from friction_audit.simulation.effects.asymmetric_viscous import AsymmetricViscous
from friction_audit.simulation.effects.backlash import Backlash
from friction_audit.simulation.effects.cable_spring import CableSpring
from friction_audit.simulation.effects.contact_event import ContactEvent
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.friction_step import FrictionStep
from friction_audit.simulation.effects.frictional_lag import FrictionalLag
from friction_audit.simulation.effects.gravity_error import GravityError
from friction_audit.simulation.effects.inertia_error import InertiaError
from friction_audit.simulation.effects.inertial_coupling import InertialCoupling
from friction_audit.simulation.effects.joint_elasticity import JointElasticity
from friction_audit.simulation.effects.joint_limit_stop import JointLimitStop
from friction_audit.simulation.effects.load_dependent_friction import LoadDependentFriction
from friction_audit.simulation.effects.nonlinear_viscous import NonlinearViscous
from friction_audit.simulation.effects.position_dependent_friction import PositionDependentFriction
from friction_audit.simulation.effects.presliding import Presliding
from friction_audit.simulation.effects.stiction import Stiction
from friction_audit.simulation.effects.stribeck import Stribeck
from friction_audit.simulation.effects.time_delay import TimeDelay
from friction_audit.simulation.effects.torque_bias import TorqueBias
from friction_audit.simulation.effects.torque_crosstalk import TorqueCrosstalk
from friction_audit.simulation.effects.torque_drift import TorqueDrift
from friction_audit.simulation.effects.torque_ripple import TorqueRipple
from friction_audit.simulation.effects.unlogged_compensation import UnloggedCompensation
from friction_audit.simulation.effects.warm_up import WarmUp


@dataclass(frozen=True, kw_only=True, slots=True)
class Hidden:
    """One group per effect, named as the effect.

    Raises:
        UsageError: If one effect would keep another from doing anything.
    """

    stribeck: Stribeck = Stribeck()
    stiction: Stiction = Stiction()
    nonlinear_viscous: NonlinearViscous = NonlinearViscous()
    asymmetric_coulomb: AsymmetricCoulomb = AsymmetricCoulomb()
    asymmetric_viscous: AsymmetricViscous = AsymmetricViscous()
    presliding: Presliding = Presliding()
    frictional_lag: FrictionalLag = FrictionalLag()
    load_dependent_friction: LoadDependentFriction = LoadDependentFriction()
    position_dependent_friction: PositionDependentFriction = PositionDependentFriction()
    torque_ripple: TorqueRipple = TorqueRipple()
    gravity_error: GravityError = GravityError()
    cable_spring: CableSpring = CableSpring()
    joint_limit_stop: JointLimitStop = JointLimitStop()
    torque_bias: TorqueBias = TorqueBias()
    torque_drift: TorqueDrift = TorqueDrift()
    time_delay: TimeDelay = TimeDelay()
    torque_crosstalk: TorqueCrosstalk = TorqueCrosstalk()
    joint_elasticity: JointElasticity = JointElasticity()
    backlash: Backlash = Backlash()
    inertia_error: InertiaError = InertiaError()
    inertial_coupling: InertialCoupling = InertialCoupling()
    warm_up: WarmUp = WarmUp()
    friction_step: FrictionStep = FrictionStep()
    contact_event: ContactEvent = ContactEvent()
    unlogged_compensation: UnloggedCompensation = UnloggedCompensation()

    def __post_init__(self) -> None:
        """Refuse stiction where bristles hold the joint: it never rests as a whole."""
        if self.presliding.displacement_rad != 0.0 and self.stiction.excess_nm != 0.0:
            raise UsageError(
                "--effect presliding with --effect stiction in one joint: bristles have a break-away of their own and "
                "stiction would do nothing; expected one of them, or stribeck for more friction at rest"
            )

    def each(self) -> tuple[HiddenEffect, ...]:
        """Return the groups of all effects, in the order of the documentation."""
        return tuple(getattr(self, item.name) for item in fields(self))

    def holding(self, *groups: HiddenEffect) -> Self:
        """Return the same with these groups in the places of their effects."""
        by_name: dict[str, Any] = {group.name: group for group in groups}
        return replace(self, **by_name)


# In the order of the documentation.
EFFECTS: tuple[type[HiddenEffect], ...] = tuple(get_type_hints(Hidden)[item.name] for item in fields(Hidden))
