"""A joint's model as the record of numbers that the compiled step reads by name."""

from typing import Any, TypeAlias

import numpy as np

from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import FittedTerm, JointModel
from friction_audit.model.term import Motion

Record: TypeAlias = Any
"""One element of an array of BODY."""

EXCESS_POINTS = 4097
EXCESS_TOP_RAD_S = 4.0
"""Speed up to which a law of friction is sampled; beyond, it is continued level."""

PLAIN = ("coulomb", "viscous", "offset")
"""Terms that the step has as numbers; others of the velocity alone are sampled."""

BODY = np.dtype(
    [
        ("mass_kg_m2", "f8"),  # inertia of the joint and of the operator
        ("damping_nms_per_rad", "f8"),  # of the operator
        ("stiffness_nm_per_rad", "f8"),  # of the operator, against position zero
        ("coulomb_nm", "f8"),
        ("viscous_nms_per_rad", "f8"),
        ("offset_nm", "f8"),
        ("has_excess", "i8"),
        ("excess_step_rad_s", "f8"),
        ("excess_nm", "f8", (2, EXCESS_POINTS)),  # friction above Coulomb's by speed, forwards and backwards
    ],
    align=True,
)
"""What moves, and what acts on it."""


def make_body(
    model: JointModel, *, mass_kg_m2: float = 0.0, damping_nms_per_rad: float = 0.0, stiffness_nm_per_rad: float = 0.0
) -> Record:
    """Return the body of a joint, held by an operator where an impedance is given.

    Coulomb, viscous and constant torque enter as numbers; all other terms that follow from the velocity alone are
    sampled together, by direction, so that a joint at rest is held by their limit at speed zero.

    Raises:
        AnalysisError: If a term follows from more than the velocity, the inertia is not above zero, or friction would
            push.
    """
    if model.inertia_kg_m2 <= 0.0:
        raise AnalysisError(
            f"inertia_kg_m2 = {model.inertia_kg_m2:g}; expected a number above 0: a joint without inertia has no motion"
            " to simulate; give the reflected inertia, rotor and gear included"
        )
    unable = [term.name for term in model.terms if not term.term.speed_only]
    if unable:
        raise AnalysisError(
            f"the model's {', '.join(unable)} follow from more than the velocity; the forward simulation expects terms"
            " of the velocity alone; take them out, or take their torque from the drive"
        )
    body = np.zeros(1, dtype=BODY)[0]
    body["mass_kg_m2"] = model.inertia_kg_m2 + mass_kg_m2
    body["damping_nms_per_rad"], body["stiffness_nm_per_rad"] = damping_nms_per_rad, stiffness_nm_per_rad
    for term in model.terms:
        if term.name in PLAIN:
            body[term.term.linear[0].name] = term.values[0]
    sampled = [term for term in model.terms if term.name not in PLAIN]
    if sampled:
        body["has_excess"], body["excess_step_rad_s"] = 1, EXCESS_TOP_RAD_S / (EXCESS_POINTS - 1)
        body["excess_nm"] = np.array([_sample(sampled, 1.0), _sample(sampled, -1.0)])
        if np.min(body["coulomb_nm"] + body["excess_nm"]) < 0.0:
            names = ", ".join(term.name for term in sampled)
            raise AnalysisError(f"the model's friction pushes at some speed: {names} outweigh Coulomb friction")
    return body


def _sample(terms: list[FittedTerm], sign: float) -> Float:
    """Return the terms' torque against the motion, by speed in one direction, the limit at zero included."""
    speed = np.linspace(0.0, EXCESS_TOP_RAD_S, EXCESS_POINTS)
    speed[0] = 1e-12
    still = np.zeros(EXCESS_POINTS)
    motion = Motion(t=still, q=still, dq=sign * speed, ddq=still)
    return np.asarray(sign * np.sum([term.torque(motion) for term in terms], axis=0))
