"""Asymmetric viscous friction: half the difference of the two slopes."""

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.terms.asymmetric_viscous import TERM
from friction_audit.joint_log import Float


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="viscous friction differs by direction",
    shapes=({},),
    columns=columns_of(TERM),
    column_units=("nms_per_rad",),
    untestable=both_directions,
    admissible=admissible,
    axis="speed",
    term=TERM,
)
