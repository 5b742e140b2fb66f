"""How methods look, in every figure alike: colours of Okabe and Ito, dashes and markers beside them."""

from typing import NamedTuple

from friction_audit.report.figures.style import BORDER, DISSIPATED, FILTERED, FITTED, MUTED, REJECTED


class Look(NamedTuple):
    """Colour, dashes and marker."""

    colour: str
    dashes: "str | tuple[float, tuple[float, ...]]"
    marker: str


LOOKS = {
    "none": Look(MUTED, (0, (1, 1)), "s"),
    "sigmoid": Look(DISSIPATED, (0, (4, 1.5)), "^"),
    "lugre": Look(REJECTED, (0, (4, 1.2, 1, 1.2)), "v"),
    "disturbance_observer": Look("#56b4e9", (0, (6, 1)), "D"),
    "torque_regulation": Look("#009e73", "-.", "P"),
    "energy": Look(FITTED, "-", "o"),
    "oracle": Look(FILTERED, (0, (1, 0.6)), "X"),
}

LOST = BORDER
"""Colour of the cross where a loop was lost."""
