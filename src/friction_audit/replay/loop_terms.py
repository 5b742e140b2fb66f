"""Which terms of a joint's model can run in a compensator's loop, and why the others cannot."""

from collections.abc import Iterable, Mapping

from friction_audit.model.joint_model import FittedTerm, JointModel

PAST = "it follows from the past of the motion, and the loop knows speed, place and moment only"
TWO_SIDES = "the person is on one side of it and the compensator on the other, and the loop has one side only"
ARM = "it follows from the other joints, and a replay moves one joint alone"
UNABLE: Mapping[str, str] = {
    "stiction": PAST,
    "frictional_lag": PAST,
    "load_dependent_friction": "it needs the load on the gear, which a replay does not predict",
    "time_delay": "a joint does not move otherwise because its torque is read late, and the loop reads it on time",
    "joint_elasticity": TWO_SIDES,
    "backlash": TWO_SIDES,
    "torque_crosstalk": ARM,
    "inertial_coupling": ARM,
}
"""Why a term cannot run in the loop, by its name."""

NO_MODEL = "the model file has no model of it; give one, or leave --joint-model away"

OF_FRICTION = (
    "asymmetric_coulomb",
    "asymmetric_viscous",
    "presliding",
    "stiction",
    "frictional_lag",
    "load_dependent_friction",
)
"""Terms that belong to friction though what they take alone may be given back."""


def friction_terms(model: JointModel) -> tuple[FittedTerm, ...]:
    """Return the terms that a compensator of friction has to do with."""
    return tuple(term for term in model.terms if term.term.friction or term.name in OF_FRICTION)


def refusal(terms: Iterable[FittedTerm]) -> str:
    """Say which of the terms cannot run in a compensator's loop, and why; empty if all can."""
    reasons = [(term.name, _why_not(term)) for term in terms]
    told = "; ".join(f"{name}: {reason}" for name, reason in reasons if reason)
    return f"its model cannot run in a compensator's loop: {told}; take it out of the file" if told else ""


def past_refusal(terms: Iterable[FittedTerm]) -> str:
    """Say that the torque of terms is not had from tables; empty without terms."""
    told = "; ".join(f"{term.name}: along this recording, {PAST}" for term in terms)
    return f"its model cannot run in a compensator's loop: {told}; take it out of the file" if told else ""


def _why_not(term: FittedTerm) -> str:
    values = dict(zip((parameter.name for parameter in term.term.parameters), term.values, strict=True))
    if term.name == "gravity_error" and values["gravity_error_source"] != 0.0:
        return "it needs the model of the arm, and a replay moves one joint alone"
    if term.name == "warm_up" and values["warm_up_per_k"] != 0.0:
        return "it needs the temperature, which a replay does not read"
    return UNABLE.get(term.name, "")
