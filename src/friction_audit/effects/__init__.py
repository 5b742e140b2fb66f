"""Models of joints: inertia and named terms; their torque, their forward simulation, their file."""

from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance, simple_model
from friction_audit.effects.model_file import load_model, save_model
from friction_audit.effects.term import Forward, Motion, Parameter, Term
from friction_audit.effects.terms import TERMS, term_of

__all__ = [
    "TERMS",
    "ArmModel",
    "FittedTerm",
    "Forward",
    "JointModel",
    "Motion",
    "Parameter",
    "Provenance",
    "Term",
    "load_model",
    "save_model",
    "simple_model",
    "term_of",
]
