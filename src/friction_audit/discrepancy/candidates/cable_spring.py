"""Cable: a spring that pulls back from a place or from the edges of a free stretch."""

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.candidates.extent import reach
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.cable_spring import TERM

EDGES = (0.0, 1 / 3, 1 / 2, 2 / 3, 1.0)
"""Where it may begin to pull, as shares of the range; 0 and 1 for a side on which it does not."""
MIDDLE = (0.4999, 0.5001)
"""No free stretch to speak of."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """No free stretch, then all between edges but the one that leaves nothing."""
    low, high = reach(data)
    pairs = [MIDDLE, *((a, b) for a in EDGES for b in EDGES if a < b and b - a < 1.0)]
    return tuple(
        {
            "cable_centre_rad": low + 0.5 * (a + b) * (high - low),
            "cable_free_rad": 0.5 * (b - a) * (high - low),
        }
        for a, b in pairs
    )


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.8)


def admissible(factors: Float, _shape: Shape) -> bool:
    """It pulls back from the beginning, and still when it is stretched by a radian."""
    return bool(factors[0] > 0 and factors[0] + factors[1] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm_per_rad", "nm_per_rad3", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    same_as=("joint_limit_stop",),
    term=TERM,
)
