"""What a figure is: one record per kind."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from friction_audit.pipeline import Estimate


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureKind:
    """A kind of figure.

    Attributes:
        name: Unique name, also the start of the file's name.
        draw: Draws one joint, given by its number for people, or with None all joints on one sheet.
        summary: One line for help and documentation.
    """

    name: str
    draw: "Callable[[Estimate, int | None], Figure]"
    summary: str
