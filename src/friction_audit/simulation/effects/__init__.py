"""Effects that a synthetic log can hide, by families, and their registry: ``Hidden`` holds a group of each."""

from dataclasses import dataclass, fields, replace
from typing import Any, Self, get_type_hints

from friction_audit.errors import UsageError
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.load_and_place import (
    CableSpring,
    GravityError,
    JointLimitStop,
    LoadDependentFriction,
    PositionDependentFriction,
    TorqueRipple,
)
from friction_audit.simulation.effects.sensors import TimeDelay, TorqueBias, TorqueCrosstalk, TorqueDrift
from friction_audit.simulation.effects.slow_and_events import ContactEvent, FrictionStep, UnloggedCompensation, WarmUp
from friction_audit.simulation.effects.structure import Backlash, InertiaError, InertialCoupling, JointElasticity
from friction_audit.simulation.effects.velocity import (
    AsymmetricCoulomb,
    AsymmetricViscous,
    FrictionalLag,
    NonlinearViscous,
    Presliding,
    Stiction,
    Stribeck,
)

__all__ = ["EFFECTS", "Hidden", "HiddenEffect"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Hidden:
    """One group per effect, named as the effect."""

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
