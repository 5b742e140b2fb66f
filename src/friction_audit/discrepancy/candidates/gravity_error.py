"""Gravity error: of the joint's own angle, of a link whose mass is wrong, of a tilted base."""

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.gravity_error import OWN_ANGLE, TERM, TILT


def shapes(data: JointData) -> tuple[Shape, ...]:
    """The joint's angle, and what the model of the arm lets pull at it."""
    rigid = data.rigid
    links = () if rigid is None else tuple(k for n, k in enumerate(rigid.links) if rigid.weight[:, n].any())
    tilt = () if rigid is None else (TILT,)
    return tuple({"gravity_error_source": float(source)} for source in (OWN_ANGLE, *links, *tilt))


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.3)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="gravity not fully compensated",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=tuple(p.unit for p in TERM.linear),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    term=TERM,
)
