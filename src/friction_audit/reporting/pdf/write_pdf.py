"""Page -> PDF: the words and tables of the page, its figures as matplotlib draws them."""

import io
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from pypdf import PdfReader, PdfWriter, Transformation
from reportlab.lib.pagesizes import A4
from reportlab.platypus import CondPageBreak, KeepTogether, SimpleDocTemplate

from friction_audit import __version__
from friction_audit.errors import printable
from friction_audit.reporting.html.page import Command, Figure, Page, Part, Section, Table, Terms, Text, Verdicts
from friction_audit.reporting.pdf.paper import Mark, NumberedCanvas
from friction_audit.reporting.pdf.sheet import Placed, SheetPicture, SheetPlace
from friction_audit.reporting.pdf.tables import paragraph, table_on_paper, terms_on_paper, verdicts_on_paper
from friction_audit.reporting.pdf.type import FOOT, MARGIN, register_letters

HEAD_ROOM = 90.0
"""A heading with less room below it goes to the next page. [pt]"""
CAPTION_ROOM = 80.0
"""Left on a page for the title and the caption of a figure that fills it. [pt]"""


def write_pdf(page: Page) -> bytes:
    """Return a page as PDF, A4; its figures are drawn by ``draw_sheet``. The same page gives the same bytes."""
    register_letters()
    width, height = A4
    stream, placed = io.BytesIO(), list[Placed]()
    document: Any = SimpleDocTemplate(
        stream,
        pagesize=A4,
        leftMargin=MARGIN,
        rightMargin=MARGIN,
        topMargin=MARGIN,
        bottomMargin=FOOT,
        title=printable(page.title),
        author="",
        subject="",
        creator=f"friction-audit {__version__}",
        invariant=1,
    )
    # The frame of a page pads its text by 6 pt on every side.
    story = _Story(width - 2.0 * MARGIN - 12.0, height - MARGIN - FOOT - 12.0 - CAPTION_ROOM, placed)
    document.build(list(story.of(page)), canvasmaker=partial(NumberedCanvas, printable(page.title)))
    return _with_sheets(stream.getvalue(), placed)


class _Story:
    """What is on the paper, one thing after another.

    Args:
        width: Of the column of text. [pt]
        highest: Height of a figure. [pt]
        placed: Where each figure came to lie; filled while the pages are made.
    """

    def __init__(self, width: float, highest: float, placed: list[Placed]) -> None:
        self._width, self._highest, self._placed = width, highest, placed
        self._folded: list[Table] = []

    def of(self, page: Page) -> Iterator[Any]:
        yield paragraph(page.title, "title")
        yield paragraph(page.lead, "lead")
        yield terms_on_paper(Terms(pairs=page.facts), self._width)
        for section in page.sections:
            yield from self._section(section, 0)
        yield from self._section(Section(anchor="details", title="Details"), 0) if self._folded else ()
        for table in self._folded:
            yield from self._table(table)

    def _section(self, section: Section, level: int) -> Iterator[Any]:
        yield CondPageBreak(HEAD_ROOM)
        yield Mark(section.anchor, printable(section.title), level)
        yield paragraph(section.title, "inner" if level else "section")
        for part in section.parts:
            yield from self._part(part)
        for inner in section.sections:
            yield from self._section(inner, level + 1)

    def _part(self, part: Part) -> Iterator[Any]:
        match part:
            case Table(folded=True):
                self._folded.append(part)
                yield paragraph(f"{part.caption}: under Details, at the end.", "note")
            case Table():
                yield from self._table(part)
            case Figure():
                yield self._figure(part)
            case Verdicts():
                yield verdicts_on_paper(part, self._width)
            case Text():
                yield from (paragraph(f"\N{BULLET} {one}" if part.listed else one, "body") for one in part.lines)
            case Command():
                yield paragraph(part.line, "command", spaceAfter=6)
            case Terms():
                yield terms_on_paper(part, self._width)

    def _table(self, table: Table) -> Iterator[Any]:
        """Yield a table and its caption; it may break, so that nothing but its head must stay with the caption."""
        yield CondPageBreak(HEAD_ROOM)
        yield paragraph(table.caption, "caption")
        yield from (table_on_paper(table, self._width) for _ in table.rows[:1])

    def _figure(self, part: Figure) -> Any:  # noqa: ANN401 - reportlab is untyped
        assert isinstance(part.picture, SheetPicture)
        return KeepTogether(
            [
                paragraph(part.title, "caption"),
                SheetPlace(part.picture, self._highest, self._placed),
                paragraph(part.caption, "note"),
            ]
        )


def _with_sheets(document: bytes, placed: Sequence[Placed]) -> bytes:
    """Return the document with its figures in their places."""
    writer = PdfWriter(clone_from=PdfReader(io.BytesIO(document)))
    for one in placed:
        sheet = PdfReader(io.BytesIO(one.picture.pdf)).pages[0]
        place = Transformation().scale(one.scale).translate(one.x, one.y)
        writer.pages[one.page - 1].merge_transformed_page(sheet, place)
    writer.compress_identical_objects()
    stream = io.BytesIO()
    writer.write(stream)
    return stream.getvalue()
