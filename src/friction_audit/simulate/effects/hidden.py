"""What is hidden in one joint: the group of every effect, each doing nothing unless told."""

from dataclasses import dataclass

from friction_audit.simulate.effects.asymmetric_coulomb import AsymmetricCoulomb
from friction_audit.simulate.effects.asymmetric_viscous import AsymmetricViscous
from friction_audit.simulate.effects.backlash import Backlash
from friction_audit.simulate.effects.cable_spring import CableSpring
from friction_audit.simulate.effects.contact_event import ContactEvent
from friction_audit.simulate.effects.friction_step import FrictionStep
from friction_audit.simulate.effects.frictional_lag import FrictionalLag
from friction_audit.simulate.effects.gravity_error import GravityError
from friction_audit.simulate.effects.inertia_error import InertiaError
from friction_audit.simulate.effects.inertial_coupling import InertialCoupling
from friction_audit.simulate.effects.joint_elasticity import JointElasticity
from friction_audit.simulate.effects.joint_limit_stop import JointLimitStop
from friction_audit.simulate.effects.load_dependent_friction import LoadDependentFriction
from friction_audit.simulate.effects.nonlinear_viscous import NonlinearViscous
from friction_audit.simulate.effects.position_dependent_friction import PositionDependentFriction
from friction_audit.simulate.effects.presliding import Presliding
from friction_audit.simulate.effects.stiction import Stiction
from friction_audit.simulate.effects.stribeck import Stribeck
from friction_audit.simulate.effects.time_delay import TimeDelay
from friction_audit.simulate.effects.torque_bias import TorqueBias
from friction_audit.simulate.effects.torque_crosstalk import TorqueCrosstalk
from friction_audit.simulate.effects.torque_drift import TorqueDrift
from friction_audit.simulate.effects.torque_ripple import TorqueRipple
from friction_audit.simulate.effects.unlogged_compensation import UnloggedCompensation
from friction_audit.simulate.effects.warm_up import WarmUp


@dataclass(frozen=True, kw_only=True, slots=True)
class Hidden:
    """One group per effect, named as the effect."""

    stribeck: Stribeck = Stribeck()  # noqa: RUF009 - frozen
    stiction: Stiction = Stiction()  # noqa: RUF009 - frozen
    nonlinear_viscous: NonlinearViscous = NonlinearViscous()  # noqa: RUF009 - frozen
    asymmetric_coulomb: AsymmetricCoulomb = AsymmetricCoulomb()  # noqa: RUF009 - frozen
    asymmetric_viscous: AsymmetricViscous = AsymmetricViscous()  # noqa: RUF009 - frozen
    presliding: Presliding = Presliding()  # noqa: RUF009 - frozen
    frictional_lag: FrictionalLag = FrictionalLag()  # noqa: RUF009 - frozen
    load_dependent_friction: LoadDependentFriction = LoadDependentFriction()  # noqa: RUF009 - frozen
    position_dependent_friction: PositionDependentFriction = PositionDependentFriction()  # noqa: RUF009 - frozen
    torque_ripple: TorqueRipple = TorqueRipple()  # noqa: RUF009 - frozen
    gravity_error: GravityError = GravityError()  # noqa: RUF009 - frozen
    cable_spring: CableSpring = CableSpring()  # noqa: RUF009 - frozen
    joint_limit_stop: JointLimitStop = JointLimitStop()  # noqa: RUF009 - frozen
    torque_bias: TorqueBias = TorqueBias()  # noqa: RUF009 - frozen
    torque_drift: TorqueDrift = TorqueDrift()  # noqa: RUF009 - frozen
    time_delay: TimeDelay = TimeDelay()  # noqa: RUF009 - frozen
    torque_crosstalk: TorqueCrosstalk = TorqueCrosstalk()  # noqa: RUF009 - frozen
    joint_elasticity: JointElasticity = JointElasticity()  # noqa: RUF009 - frozen
    backlash: Backlash = Backlash()  # noqa: RUF009 - frozen
    inertia_error: InertiaError = InertiaError()  # noqa: RUF009 - frozen
    inertial_coupling: InertialCoupling = InertialCoupling()  # noqa: RUF009 - frozen
    warm_up: WarmUp = WarmUp()  # noqa: RUF009 - frozen
    friction_step: FrictionStep = FrictionStep()  # noqa: RUF009 - frozen
    contact_event: ContactEvent = ContactEvent()  # noqa: RUF009 - frozen
    unlogged_compensation: UnloggedCompensation = UnloggedCompensation()  # noqa: RUF009 - frozen


NOTHING = Hidden()
