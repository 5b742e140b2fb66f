"""Crosstalk: the readings of the neighbours' torque sensors, of one of them or of both."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import neighbours_loaded
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.torque_crosstalk import TERM
from friction_audit.joint_log import Float


def shapes(data: JointData) -> tuple[Shape, ...]:
    """The neighbours that there are."""
    before, after = data.own_column > 0, data.own_column + 1 < data.others_torque.shape[1]
    sides = ((-1.0, before), (1.0, after), (0.0, before and after))
    return tuple({"crosstalk_side": side} for side, there in sides if there)


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return neighbours_loaded(data, baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """A sensor feels its own load best."""
    return bool(np.all(np.abs(factors) < 1))


CANDIDATE = Candidate(
    name=TERM.name,
    label="torque of a neighbour leaks in",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("1", "1"),
    untestable=untestable,
    admissible=admissible,
    axis="neighbour",
    term=TERM,
)
