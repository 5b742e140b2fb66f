"""Cable: a spring that pulls back from a place or from the edges of a free stretch."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import JointData, Nominal, reach
from friction_audit.effects.terms.cable_spring import TERM
from friction_audit.joint_log import Float

PARTS = 12
"""Of the range, between which it may begin to pull; the first and the last for a side on which it does not."""
STEP = 2
"""Free stretches are so many parts long: their middles lie closer to each other than their lengths. From no free
stretch there is no way downhill to a short one, which therefore has to be on the grid."""
NONE = 1e-4
"""Half of a free stretch that is none to speak of, as a share of the range."""
BENT = columns_of(TERM)
STRAIGHT: Shape = {}
"""A spring without a free stretch that does not harden: nothing but stiffness and preload, wherever its centre is."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """No free stretch, then all between edges but the one that leaves nothing, and the straight spring."""
    low, high = reach(data)
    # Whole numbers, for neighbours on a grid must not differ by rounding only.
    pairs = [(a, b) for a in range(PARTS) for b in range(a + STEP, PARTS + 1, STEP) if b - a < PARTS]
    places = [(PARTS, NONE), *((a + b, 0.5 * (b - a) / PARTS) for a, b in pairs)]
    bent = (
        {"cable_centre_rad": low + 0.5 * twice / PARTS * (high - low), "cable_free_rad": free * (high - low)}
        for twice, free in places
    )
    return (*bent, STRAIGHT)


def columns(data: JointData, baseline: Nominal, shape: Shape) -> Float:
    """Those of the term; of the straight spring position and preload only."""
    if shape:
        return BENT(data, baseline, shape)
    return np.column_stack([data.q, np.zeros(len(data.q)), np.ones(len(data.q))])


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.8)


def admissible(factors: Float, _shape: Shape) -> bool:
    """It pulls back from the beginning, and still when it is stretched by a radian."""
    return bool(factors[0] > 0 and factors[0] + factors[1] > 0)


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns,
    column_units=("nm_per_rad", "nm_per_rad3", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    same_as=("joint_limit_stop",),
    term=TERM,
)
