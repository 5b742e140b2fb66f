"""Inertial coupling: accelerations of other joints, or the inertial torque that the arm's model tells."""

from friction_audit.discrepancy.candidate import Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import neighbours_move
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.inertial_coupling import AFTER, ALL, BEFORE, BOTH, MODEL, TERM, TIP


def shapes(data: JointData) -> tuple[Shape, ...]:
    """The neighbours that there are, all joints, and what the model knows."""
    joints, joint = data.others_dq.shape[1], data.own_column
    model = data.rigid is not None and data.rigid.inertial is not None
    sources = (
        (BEFORE, joint > 0),
        (AFTER, joint + 1 < joints),
        (BOTH, 0 < joint < joints - 1),
        (ALL, joints > 1),
        (MODEL, model),
        (TIP, model),
    )
    return tuple({"coupling_source": float(source)} for source, there in sources if there)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Either sign is possible: a rotor may turn against its neighbour."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label="other joints shake this one",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=tuple(p.unit for p in TERM.linear),
    untestable=neighbours_move,
    admissible=admissible,
    axis="neighbour",
    term=TERM,
)
