"""Inertia error: the acceleration, where somebody has stated the inertia."""

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import moves
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.inertia_error import TERM
from friction_audit.joint_log import Float

NOT_DECLARED = (
    "the inertia was fitted to this log, so it cannot be wrong: state it (--model with inertia_kg_m2), and move at two "
    "or more frequencies"
)


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The number or the motion that is lacking.

    At one frequency the acceleration runs as the position does: then gravity is its alternative, and it gravity's.
    """
    return moves(data, baseline) if "inertia_kg_m2" in baseline.declared else NOT_DECLARED


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="the declared inertia is wrong",
    shapes=({},),
    columns=columns_of(TERM),
    column_units=("kg_m2",),
    untestable=untestable,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
)
