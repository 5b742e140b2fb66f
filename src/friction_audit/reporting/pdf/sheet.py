"""Figure -> a page of PDF by matplotlib, its lines as lines; and the place on paper where it is put."""

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reportlab.platypus import Flowable

from friction_audit.errors import printable
from friction_audit.reporting.figures.style import figure_style
from friction_audit.reporting.html.svg import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLOUDS_DPI = 200
"""Dots to the inch of clouds of dots, which are images."""
POINTS_PER_INCH = 72.0


@dataclass(frozen=True, kw_only=True, slots=True)
class SheetPicture(Picture):
    """A drawing to be put on paper.

    Attributes:
        pdf: It, on a page of its own.
        height: Of that page. [pt]
    """

    pdf: bytes
    height: float

    @property
    def size(self) -> int:
        """Room that it takes. [bytes]"""
        return len(self.pdf)


def draw_sheet(figure: "Figure", *, prefix: str, description: str) -> SheetPicture:  # noqa: ARG001 - as draw_inline
    """Return a figure as a page of PDF.

    Args:
        figure: The figure.
        prefix: Of no use on paper.
        description: What it shows.
    """
    stream = io.BytesIO()
    with figure_style():
        figure.savefig(stream, format="pdf", dpi=CLOUDS_DPI, metadata={"CreationDate": None})
    width, height = (POINTS_PER_INCH * float(inches) for inches in figure.get_size_inches())
    return SheetPicture(pdf=stream.getvalue(), width=width, height=height, description=printable(description))


@dataclass(frozen=True, kw_only=True, slots=True)
class Placed:
    """A drawing and where it goes.

    Attributes:
        picture: The drawing.
        page: Page of the document, from 1.
        x: Of its left edge, from the left of the page. [pt]
        y: Of its lower edge, from the bottom of the page. [pt]
        scale: Factor on its size.
    """

    picture: SheetPicture
    page: int
    x: float
    y: float
    scale: float


class SheetPlace(Flowable):  # type: ignore[misc] # reportlab is untyped
    """Room for a drawing; where it came to lie is noted in a list.

    Args:
        picture: The drawing.
        highest: Height that it may have. [pt]
        placed: The list.
    """

    def __init__(self, picture: SheetPicture, highest: float, placed: list[Placed]) -> None:
        super().__init__()
        self.picture, self.highest, self.placed, self.scale = picture, highest, placed, 1.0

    def wrap(self, width: float, height: float) -> tuple[float, float]:  # noqa: ARG002 - what is left does not shrink it
        """Return the room that it takes in a column of this width. [pt]"""
        self.scale = min(1.0, width / self.picture.width, self.highest / self.picture.height)
        return self.scale * self.picture.width, self.scale * self.picture.height

    def draw(self) -> None:
        """Note where it lies."""
        canvas: Any = self.canv
        x, y = canvas.absolutePosition(0.0, 0.0)
        number = canvas.getPageNumber()
        self.placed.append(Placed(picture=self.picture, page=number, x=x, y=y, scale=self.scale))
