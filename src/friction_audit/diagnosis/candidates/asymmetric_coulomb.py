"""Asymmetric Coulomb friction: half the difference of the two levels; in motion the same as a bias of the sensor."""

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.terms.asymmetric_coulomb import TERM
from friction_audit.joint_log import Float


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="friction differs by direction",
    shapes=({},),
    columns=columns_of(TERM),
    column_units=("nm",),
    untestable=both_directions,
    admissible=admissible,
    axis="speed",
    same_as=("torque_bias",),
    part_of=("torque_drift",),
    term=TERM,
    exact=True,
)
