"""Stops: springs near one end of the range or both, where and how steep unknown.

A soft stop is to the joint what a slack cable is.
"""

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.joint_limit_stop import TERM
from friction_audit.joint_log import Float

DEPTHS = (0.0, 0.02, 0.05, 0.08, 0.12, 0.2)
"""How deep the joint goes into a stop, as shares of the range; 0 where it does not reach it."""
EXPONENTS = (1.0, 2.0)


def shapes(data: JointData) -> tuple[Shape, ...]:
    """One stop, or two equally deep, with the exponents."""
    low, high = float(data.q.min()), float(data.q.max())
    length = high - low
    alone = [(depth, 0.0) for depth in DEPTHS[1:]] + [(0.0, depth) for depth in DEPTHS[1:]]
    both = [(depth, depth) for depth in DEPTHS[1:]]
    return tuple(
        {"stop_upper_rad": high - up * length, "stop_lower_rad": low + down * length, "stop_exponent": exponent}
        for up, down in (*alone, *both)
        for exponent in EXPONENTS
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.5)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Stops push back."""
    return bool(factors[0] >= 0 and factors[1] >= 0 and factors[0] + factors[1] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm", "nm", "nms_per_rad", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    same_as=("cable_spring",),
    term=TERM,
)
