"""The joint that moves otherwise than recorded: fitted to the log, or of a model file."""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.errors import AnalysisError
from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.model.body import make_body
from friction_audit.model.joint_model import FittedTerm, JointModel
from friction_audit.model.move import steps_per_sample
from friction_audit.model.tables import Tables, tabulate
from friction_audit.model.term import Motion
from friction_audit.replay.fitted_joint import LEAST_INERTIA_KG_M2, FittedJoint, fit_joint
from friction_audit.replay.loop_terms import NO_MODEL, past_refusal, refusal
from friction_audit.replay.operator_fit import FittedOperator
from friction_audit.replay.records import Record
from friction_audit.replay.straight_tables import straighten
from friction_audit.replay.tabled_loop import TabledJoint

CONSTANT = ("offset", "torque_bias")
"""Terms of a constant torque."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class MovedJoint:
    """A joint that can be simulated in a compensator's loop.

    Attributes:
        model: Its model.
        fitted: The fit to the log that the model is; None where it is of a file.
        tables: What its terms take along the recording; None where they follow from the velocity alone.
    """

    model: JointModel
    fitted: FittedJoint | None = None
    tables: Tables | None = None


def fitted_joint(friction: JointFriction) -> MovedJoint | str:
    """Return the joint that the log shows, or why it cannot be simulated."""
    fitted = fit_joint(friction)
    return fitted if isinstance(fitted, str) else MovedJoint(model=fitted.model, fitted=fitted)


def modelled_joint(model: JointModel | None, motion: Motion) -> MovedJoint | str:
    """Return the joint of a model file, or why it cannot be simulated.

    Args:
        model: Its model, if the file has one.
        motion: The recording.
    """
    if model is None:
        return NO_MODEL
    unable = refusal(model.terms)
    if unable:
        return unable
    if all(term.term.speed_only for term in model.terms):
        return _of_speed(model)
    tables, past = tabulate(model.inertia_kg_m2, model.terms, motion)
    if past:
        return past_refusal(past)
    reason = _too_light(tables.inertia_kg_m2)
    return reason or MovedJoint(model=model, tables=tables)


def _of_speed(model: JointModel) -> MovedJoint | str:
    reason = _too_light(model.inertia_kg_m2)
    try:
        make_body(_with_offset(model))
    except AnalysisError as error:
        reason = reason or str(error)
    return reason or MovedJoint(model=model)


def _too_light(inertia_kg_m2: float) -> str:
    if inertia_kg_m2 > LEAST_INERTIA_KG_M2:
        return ""
    return (
        f"its model has an inertia of {inertia_kg_m2:.3g} kg m^2, of a torque from which the inertia was taken out; "
        "without it nobody knows how it would have moved; put that of the joint into the file, or use "
        "--assume same-motion"
    )


def body_of(joint: MovedJoint, operator: FittedOperator | None) -> Record:
    """Return a joint whose friction follows from the velocity, and the person who holds it."""
    mass, damping, stiffness = impedance(operator)
    model = _with_offset(joint.model)
    return make_body(model, mass_kg_m2=mass, damping_nms_per_rad=damping, stiffness_nm_per_rad=stiffness)


def _with_offset(model: JointModel) -> JointModel:
    """Return a model whose constant torque is an offset, which is not taken for friction."""
    constant = sum(term.values[0] for term in model.terms if term.name in CONSTANT)
    others = tuple(term for term in model.terms if term.name not in CONSTANT)
    return replace(model, terms=(*others, FittedTerm("offset", (constant,))))


def tabled_of(
    tables: Tables, operator: FittedOperator | None, motion: Motion, starts: Float, step_s: float
) -> TabledJoint:
    """Return a joint whose torque is tabulated, and the person who holds it.

    Args:
        tables: What the joint takes along the recording.
        operator: The person, or None.
        motion: The recording.
        starts: Samples at which the joint starts from the recording, the first one among them, shape (r,).
        step_s: Spacing of the samples. [s]
    """
    mass, damping, stiffness = impedance(operator)
    held = straighten(tables._replace(inertia_kg_m2=tables.inertia_kg_m2 + mass), damping_nms_per_rad=damping)
    return TabledJoint(
        tables=held,
        inertia_kg_m2=mass,
        damping_nms_per_rad=damping,
        stiffness_nm_per_rad=stiffness,
        longest_s=step_s / steps_per_sample(step_s, held),
        bent=np.ascontiguousarray(tables.bristles.states_along(motion.q)[starts]),
    )


def impedance(operator: FittedOperator | None) -> tuple[float, float, float]:
    """Return inertia, damping and stiffness of the person; of nobody, zeros."""
    if operator is None:
        return 0.0, 0.0, 0.0
    return operator.inertia.value, operator.damping.value, operator.stiffness.value
