"""The unit of the torque on the axes of a figure: ampere where a log holds motor currents."""

from typing import TYPE_CHECKING

from friction_audit.reporting.words import NEWTON_METRES, in_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def label_in_unit(figure: "Figure", unit: str) -> "Figure":
    """Write the unit of the torque on the axes of a figure."""
    from matplotlib.text import Text

    if unit != NEWTON_METRES:
        for text in figure.findobj(Text):
            text.set_text(in_unit(text.get_text(), unit))
    return figure
