"""Friction by position: waves over the whole range, or a patch somewhere in it."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions, span
from friction_audit.effects.joint_data import JointData, Nominal, reach
from friction_audit.effects.terms.position_dependent_friction import TERM
from friction_audit.joint_log import Float

WAVES = 10
PATCHES = (8, 16)
"""Half widths of patches, as how many of them the range takes."""
EVERYWHERE = 100.0
"""Width of a bell that does not matter, over the range."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Waves from half a period over the range on, half a period apart; patches a width and a half apart."""
    low, high = reach(data)
    length = max(high - low, 1e-3)
    middle = 0.5 * (low + high)
    waves = [(np.pi / length * k, middle, EVERYWHERE * length) for k in range(1, WAVES + 1)]
    patches = [
        (parts / length, low + (k + 0.5) * 1.5 * length / parts, length / parts)
        for parts in PATCHES
        for k in range(int(parts / 1.5))
    ]
    return tuple(
        {
            "position_friction_order": float(order),
            "position_friction_centre_rad": float(centre),
            "position_friction_width_rad": float(width),
        }
        for order, centre, width in (*waves, *patches)
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return both_directions(data, baseline) or span(data, baseline, 0.5)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """More or less friction than elsewhere."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    term=TERM,
)
