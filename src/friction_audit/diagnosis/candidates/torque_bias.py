"""Torque bias: a constant; in motion the same as Coulomb friction that differs by direction."""

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.terms.torque_bias import TERM
from friction_audit.joint_log import Float


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="offset of the torque sensor",
    shapes=({},),
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=both_directions,
    admissible=admissible,
    axis="time",
    same_as=("asymmetric_coulomb",),
    part_of=("torque_drift",),
    term=TERM,
    exact=True,
)
