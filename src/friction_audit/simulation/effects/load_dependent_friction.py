"""Load-dependent friction: the gear rubs harder the more torque it transmits."""

from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

LINEAR, QUADRATIC, BACKDRIVE = range(3)

REFERENCE_NM = 10.0
"""Load at which the quadratic form equals the linear one. [N m]"""

BACKDRIVE_EXCESS = 0.5
"""Share by which the loss exceeds its mean when the link drives the motor, and falls short of it otherwise."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LoadDependentFriction:
    """Friction that grows with the transmitted torque.

    Attributes:
        share: Of the transmitted torque that is lost.
        form: Index into the forms of the effect.
    """

    share: float = 0.0
    form: int = LINEAR


@compiled()
def extra_nm(group: Any, load_nm: float, power_w: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the friction that the load adds to the Coulomb level (not negative, so passive). [N m]

    Linear after Bittencourt and Gunnarsson, Static friction in a robot joint (2012); quadratic after Duclusaud et al.,
    Extended friction models for the physics simulation of servo actuators (2025); backdrive after Wang and Kim,
    Directional efficiency in geared transmissions (2015): the teeth lose more where the link drives the motor.

    Args:
        group: A ``LoadDependentFriction``.
        load_nm: Torque transmitted, signed.
        power_w: Power through the sensor into the motor's side, above 0 where the link drives the motor.
    """
    load = abs(load_nm)
    if group.form == QUADRATIC:
        return float(group.share * load * load / REFERENCE_NM)
    if group.form == BACKDRIVE and power_w > 0.0:
        return float(group.share * load * (1.0 + BACKDRIVE_EXCESS))
    if group.form == BACKDRIVE and power_w < 0.0:
        return float(group.share * load * (1.0 - BACKDRIVE_EXCESS))
    return float(group.share * load)


EFFECT = Effect(
    name="load_dependent_friction",
    family="load and place",
    summary="friction grows with the torque that the gear transmits",
    group=LoadDependentFriction,
    strength="share",
    parameters=(Parameter(name="share", usual=0.06, meaning="share of the transmitted torque that is lost", high=1.0),),
    forms=("linear", "quadratic", "backdrive"),
)
