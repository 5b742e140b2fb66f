"""Hidden effects of a synthetic log, by families, and their registry: ``Hidden`` holds the parameters of each."""

from dataclasses import dataclass, fields, replace
from typing import Any, Self, get_type_hints

from friction_audit.errors import UsageError
from friction_audit.simulation.effects import load_and_place, sensors, slow_and_events, structure, velocity
from friction_audit.simulation.effects.effect import HiddenEffect


@dataclass(frozen=True, kw_only=True, slots=True)
class Hidden:
    """Parameters of every effect, by its name."""

    stribeck: velocity.Stribeck = velocity.Stribeck()
    stiction: velocity.Stiction = velocity.Stiction()
    nonlinear_viscous: velocity.NonlinearViscous = velocity.NonlinearViscous()
    asymmetric_coulomb: velocity.AsymmetricCoulomb = velocity.AsymmetricCoulomb()
    asymmetric_viscous: velocity.AsymmetricViscous = velocity.AsymmetricViscous()
    presliding: velocity.Presliding = velocity.Presliding()
    frictional_lag: velocity.FrictionalLag = velocity.FrictionalLag()
    load_dependent_friction: load_and_place.LoadDependentFriction = load_and_place.LoadDependentFriction()
    position_dependent_friction: load_and_place.PositionDependentFriction = load_and_place.PositionDependentFriction()
    torque_ripple: load_and_place.TorqueRipple = load_and_place.TorqueRipple()
    gravity_error: load_and_place.GravityError = load_and_place.GravityError()
    cable_spring: load_and_place.CableSpring = load_and_place.CableSpring()
    joint_limit_stop: load_and_place.JointLimitStop = load_and_place.JointLimitStop()
    torque_bias: sensors.TorqueBias = sensors.TorqueBias()
    torque_drift: sensors.TorqueDrift = sensors.TorqueDrift()
    time_delay: sensors.TimeDelay = sensors.TimeDelay()
    torque_crosstalk: sensors.TorqueCrosstalk = sensors.TorqueCrosstalk()
    joint_elasticity: structure.JointElasticity = structure.JointElasticity()
    backlash: structure.Backlash = structure.Backlash()
    inertia_error: structure.InertiaError = structure.InertiaError()
    inertial_coupling: structure.InertialCoupling = structure.InertialCoupling()
    warm_up: slow_and_events.WarmUp = slow_and_events.WarmUp()
    friction_step: slow_and_events.FrictionStep = slow_and_events.FrictionStep()
    contact_event: slow_and_events.ContactEvent = slow_and_events.ContactEvent()
    unlogged_compensation: slow_and_events.UnloggedCompensation = slow_and_events.UnloggedCompensation()

    def __post_init__(self) -> None:
        """Refuse stiction with presliding: on bristles a joint never sticks as a whole."""
        if self.presliding.displacement_rad != 0.0 and self.stiction.excess_nm != 0.0:
            raise UsageError(
                "--effect presliding with --effect stiction in one joint: bristles have a break-away of their own and "
                "stiction would do nothing; expected one of them, or stribeck for more friction at rest"
            )

    def present(self) -> tuple[HiddenEffect, ...]:
        """Return the groups of the effects that do anything, in the order of the documentation."""
        every: tuple[HiddenEffect, ...] = tuple(getattr(self, item.name) for item in fields(self))
        return tuple(group for group in every if getattr(group, group.strength_name) != 0.0)

    def holding(self, *groups: HiddenEffect) -> Self:
        """Return the same with these groups in the places of their effects."""
        by_name: dict[str, Any] = {group.name: group for group in groups}
        return replace(self, **by_name)


# In the order of the documentation.
EFFECTS: tuple[type[HiddenEffect], ...] = tuple(get_type_hints(Hidden)[item.name] for item in fields(Hidden))
