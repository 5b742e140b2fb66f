"""Cable: a spring that pulls back from a place or from the edges of a free stretch."""

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import span
from friction_audit.discrepancy.candidates.extent import reach
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.cable_spring import TERM

EDGES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Where it may begin to pull, as shares of the range; 0 and 1 for a side on which it does not."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All free stretches between edges but the one that leaves nothing."""
    low, high = reach(data)
    pairs = [(a, b) for a in EDGES for b in EDGES if a <= b and (a, b) != (EDGES[0], EDGES[-1])]
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
    """It pulls back when it is stretched by a radian."""
    return bool(factors[0] + factors[1] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm_per_rad", "nm_per_rad3"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    term=TERM,
)
