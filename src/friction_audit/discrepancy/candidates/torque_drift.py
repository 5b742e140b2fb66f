"""Drift: the zero of the torque sensor moves, whatever the motion."""

from friction_audit.discrepancy.candidate import Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.joint_log import Float
from friction_audit.model.terms.torque_drift import TERM


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either way."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=({},),
    columns=columns_of(TERM),
    column_units=("nm",) * len(TERM.linear),
    untestable=both_directions,
    admissible=admissible,
    axis="time",
    term=TERM,
)
