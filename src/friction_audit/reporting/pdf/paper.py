"""What is on every page of paper: a foot with its number; and the entries of the contents."""

from typing import Any

from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import Flowable

from friction_audit import __version__
from friction_audit.reporting.pdf.type import FOOT, MARGIN, MUTED, SANS

FOOT_SIZE = 7.0
LONGEST_TITLE = 70
"""Letters of a title at the foot of a page."""


class Mark(Flowable):  # type: ignore[misc] # reportlab is untyped
    """An entry of the document's contents, which leads to where it stands.

    Args:
        anchor: Unique name.
        title: What it is called.
        level: 0 for a section, 1 for one in it.
    """

    def __init__(self, anchor: str, title: str, level: int) -> None:
        super().__init__()
        self.anchor, self.title, self.level = anchor, title, level

    def wrap(self, *_: float) -> tuple[float, float]:
        """Return that it takes no room."""
        return 0.0, 0.0

    def draw(self) -> None:
        """Enter it."""
        canvas: Any = self.canv
        canvas.bookmarkPage(self.anchor, fit="XYZ", top=canvas.absolutePosition(0.0, 0.0)[1])
        canvas.addOutlineEntry(self.title, self.anchor, self.level, closed=self.level > 0)


class NumberedCanvas(Canvas):  # type: ignore[misc] # reportlab is untyped
    """A canvas that tells at the foot of each page what the document is and how many pages it has.

    Args:
        title: Of the document.
        given: What any canvas is given.
        named: Likewise.
    """

    def __init__(self, title: str, *given: Any, **named: Any) -> None:  # noqa: ANN401
        super().__init__(*given, **named)
        self.title = title if len(title) <= LONGEST_TITLE else f"{title[:LONGEST_TITLE]} ..."
        self.done: list[dict[str, Any]] = []

    def showPage(self) -> None:
        """Keep a page until it is known how many there are."""
        self.done.append(dict(self.__dict__))
        self._startPage()

    def save(self) -> None:
        """Finish all pages, then the document."""
        for state in self.done:
            self.__dict__.update(state)
            self._foot(len(self.done))
            super().showPage()
        super().save()

    def _foot(self, pages: int) -> None:
        self.setFont(SANS, FOOT_SIZE)
        self.setFillColor(MUTED)
        self.drawString(MARGIN, FOOT / 2.0, f"{self.title} \N{MIDDLE DOT} friction-audit {__version__}")
        self.drawRightString(self._pagesize[0] - MARGIN, FOOT / 2.0, f"page {self._pageNumber} of {pages}")
