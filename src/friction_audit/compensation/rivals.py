"""Other compensators than the paper's on a log, tuned from that log or as published."""

from dataclasses import dataclass

from friction_audit.compensation.compensators import (
    Coefficients,
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.compensation.compensators.sigmoid import PUBLISHED, fit_sigmoid
from friction_audit.compensation.feed_forward import NO_MODEL, friction_terms, refusal
from friction_audit.compensation.limits import PANDAS
from friction_audit.effects.joint_model import JointModel
from friction_audit.errors import UsageError
from friction_audit.friction.history import JointFriction

FEED_BACK = ("disturbance-observer", "torque-regulation")
"""Rivals that close a loop over the motion itself: without that loop their result means nothing."""

MODEL = "model"
"""The rival that applies the friction of a model file."""

RIVALS = ("fixed", "sigmoid", "lugre", *FEED_BACK, MODEL)
"""Names of the rivals, beside ``energy``."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Rival:
    """Another compensator than the paper's.

    Attributes:
        name: One of RIVALS. ``"fixed"``: the coefficients of the whole log from the start. ``"sigmoid"``: as published
            for a Panda, else nearest to the log's friction. ``"lugre"``: with the log's friction.
            ``"model"``: the friction of a model file, whatever the log says.
        observer_gain_per_s: Of the disturbance observer. [1/s]
        motor_inertia_kg_m2: As the rival assumes it, or None for the inertia fitted to the log. [kg m^2]
        desired_inertia_kg_m2: Of the torque regulation, or None for half the motor's. [kg m^2]

    Raises:
        UsageError: If the name is unknown.
    """

    name: str
    observer_gain_per_s: float = 20.0
    motor_inertia_kg_m2: float | None = None
    desired_inertia_kg_m2: float | None = None

    def __post_init__(self) -> None:
        """Check the name."""
        if self.name not in RIVALS:
            raise UsageError(f"--compensator {self.name}: expected energy or one of {', '.join(RIVALS)}")


def tune(rival: Rival, friction: JointFriction, robot: str, model: JointModel | None) -> Compensator | str:
    """Return a rival for one joint, or why it cannot be tuned.

    Args:
        rival: Which one.
        friction: What the log says about the joint.
        robot: As ``Source.robot`` names it.
        model: Of a model file, if it has one of this joint.
    """
    if rival.name == MODEL:
        return _modelled(model)
    if rival.name == "sigmoid" and robot in PANDAS and 1 <= friction.joint <= len(PUBLISHED):
        return PUBLISHED[friction.joint - 1]
    if rival.name in FEED_BACK:
        return _feed_back(rival, friction)
    coulomb, viscous = friction.coulomb.value, friction.viscous.value
    if friction.reason or not (coulomb >= 0.0 and viscous >= 0.0 and coulomb + viscous > 0.0):
        return friction.reason or "the log's friction is negative, and nothing can be tuned to it"
    return _model_based(rival.name, coulomb, viscous)


def _model_based(name: str, coulomb: float, viscous: float) -> Compensator:
    if name == "sigmoid":
        sigmoid: SigmoidCompensation = fit_sigmoid(coulomb, viscous)
        return sigmoid
    if name == "lugre":
        return LugreCompensation(coulomb_nm=coulomb, breakaway_nm=coulomb, viscous_nms_per_rad=viscous)
    forced = Coefficients(coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    return EnergyCompensator(forced=forced, forced_from_cycle=1, forced_until_acted=False, passivity=False)


def _feed_back(rival: Rival, friction: JointFriction) -> Compensator | str:
    found = friction.regression
    inertia = rival.motor_inertia_kg_m2
    if inertia is None:
        inertia = found.inertia.value if found is not None and found.inertia.low > 0.0 else None
    if inertia is None:
        return friction.reason or "its inertia is not determined by the log; give --motor-inertia"
    if rival.name == "disturbance-observer":
        return DisturbanceObserver(inertia_kg_m2=inertia, observer_gain_per_s=rival.observer_gain_per_s)
    desired = rival.desired_inertia_kg_m2
    return TorqueRegulation(inertia_kg_m2=inertia, desired_inertia_kg_m2=0.5 * inertia if desired is None else desired)


def _modelled(model: JointModel | None) -> Compensator | str:
    if model is None:
        return NO_MODEL
    terms = friction_terms(model)
    if not terms:
        return "its model has no term of friction, and a compensator nothing to apply"
    return refusal(terms) or JointModelCompensation(terms=terms)
