"""Other compensators than the paper's on a log, tuned from that log or as published."""

from friction_audit.compensation.compensators import (
    Coefficients,
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    JointModelCompensation,
    LugreCompensation,
    TorqueRegulation,
)
from friction_audit.compensation.compensators.sigmoid import PUBLISHED, fit_sigmoid
from friction_audit.compensation.feed_forward import NO_MODEL, friction_terms, refusal
from friction_audit.compensation.settings import FEED_BACK, MODEL, PANDAS, Competitor
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import JointFriction


def tune(  # noqa: PLR0911 - one per compensator
    competitor: Competitor, friction: JointFriction, robot: str, model: JointModel | None
) -> Compensator | str:
    """Return a compensator for one joint, or why it cannot be tuned.

    Args:
        competitor: Which one.
        friction: What the log says about the joint.
        robot: As ``Source.robot`` names it.
        model: Of a model file, if it has one of this joint.
    """
    if competitor.name == MODEL:
        return _modelled(model)
    if competitor.name == "sigmoid" and robot in PANDAS and 1 <= friction.joint <= len(PUBLISHED):
        return PUBLISHED[friction.joint - 1]
    if competitor.name in FEED_BACK:
        return _feed_back(competitor, friction)
    coulomb, viscous = friction.coulomb.value, friction.viscous.value
    if friction.reason or not (coulomb >= 0.0 and viscous >= 0.0 and coulomb + viscous > 0.0):
        return friction.reason or "the log's friction is negative, and nothing can be tuned to it"
    if competitor.name == "sigmoid":
        return fit_sigmoid(coulomb, viscous)
    if competitor.name == "lugre":
        return LugreCompensation(coulomb_nm=coulomb, breakaway_nm=coulomb, viscous_nms_per_rad=viscous)
    forced = Coefficients(coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    return EnergyCompensator(forced=forced, forced_from_cycle=1, forced_until_acted=False, passivity=False)


def _modelled(model: JointModel | None) -> Compensator | str:
    if model is None:
        return NO_MODEL
    terms = friction_terms(model)
    if not terms:
        return "its model has no term of friction, and a compensator nothing to apply"
    return refusal(terms) or JointModelCompensation(terms=terms)


def _feed_back(competitor: Competitor, friction: JointFriction) -> Compensator | str:
    found, inertia = friction.regression, competitor.motor_inertia_kg_m2
    if inertia is None and found is not None and found.inertia.low > 0.0:
        inertia = found.inertia.value
    if inertia is None:
        return friction.reason or "its inertia is not determined by the log; give --motor-inertia"
    if competitor.name == "disturbance_observer":
        return DisturbanceObserver(inertia_kg_m2=inertia, observer_gain_per_s=competitor.observer_gain_per_s)
    desired = competitor.desired_inertia_kg_m2
    return TorqueRegulation(inertia_kg_m2=inertia, desired_inertia_kg_m2=0.5 * inertia if desired is None else desired)
