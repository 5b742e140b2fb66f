"""Inertial coupling: accelerations of other joints, or the inertial torque that the arm's model tells."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.dynamics.motion import INERTIAL_PARAMETERS
from friction_audit.effects.excitation import neighbours_move
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.terms.inertial_coupling import AFTER, ALL, BEFORE, BOTH, MODEL, TERM, TIP
from friction_audit.joint_log import Float

NAMES = tuple(parameter.name for parameter in TERM.coefficients)
LARGEST_SHARE = 2.0
"""Of the model's inertial torque: 1 where nobody took it away, -1 where somebody took it twice."""
LARGEST_MASS_KG = 10.0
"""What columns that nearly cancel may make of the last link is no body."""


CYCLES_PER_COLUMN = 2
"""A dozen factors from as many cycles fit whatever there is, with masses that no arm carries."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """The neighbours that there are, and what the model knows; with many factors where there are many cycles."""
    joints, joint = data.others_dq.shape[1], data.own_column
    model = data.rigid is not None and data.rigid.inertial is not None
    columns = len(np.unique(data.cycle[data.used])) // CYCLES_PER_COLUMN
    sources = (
        (BEFORE, joint > 0),
        (AFTER, joint + 1 < joints),
        (BOTH, 0 < joint < joints - 1),
        (ALL, joints > 1 and 2 * (joints - 1) <= columns),
        (MODEL, model),
        (TIP, model and columns >= 1 + INERTIAL_PARAMETERS),
    )
    return tuple({"coupling_source": float(source)} for source, there in sources if there)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Either sign is possible, for a rotor may turn against its neighbour; not that of what no arm carries."""
    value = dict(zip(NAMES, factors.tolist(), strict=True))
    possible = abs(value["inertial_torque_share"]) <= LARGEST_SHARE and abs(value["tip_mass_kg"]) <= LARGEST_MASS_KG
    return bool(possible)


CANDIDATE = Candidate(
    name=TERM.name,
    label="other joints shake this one",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=tuple(p.unit for p in TERM.coefficients),
    untestable=neighbours_move,
    admissible=admissible,
    axis="neighbour",
    term=TERM,
)
