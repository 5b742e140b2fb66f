"""Tables on paper: columns as wide as their words need, heads repeated on every page."""

from typing import Any
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.pdfbase.pdfmetrics import stringWidth
from reportlab.platypus import LongTable, Paragraph, TableStyle

from friction_audit.errors import printable
from friction_audit.reporting.html.page import Cell, Table, Terms, Verdicts
from friction_audit.reporting.pdf.type import HEAD, LINE, TONES, style

PAD = 3.0
"""Room beside the words of a cell. [pt]"""
LONGEST = 6000
"""Letters of a cell that are shown: more would be a page of their own."""
WIDEST_WORD, MOST_LETTERS = 90.0, 160
"""Of a column's claim on the width: what one word may claim [pt], and how many letters count."""
NAME_SHARE, WORD_SHARE = 0.22, 0.16


def paragraph(text: str, kind: str, **changed: object) -> Any:  # noqa: ANN401 - reportlab is untyped
    """Return text as a paragraph; whatever is in it is text."""
    return Paragraph(escaped(text), style(kind, **changed))


def escaped(text: str) -> str:
    """Return text in which nothing is markup, cut where it is far too long."""
    cut = text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."
    return escape(printable(cut)).replace("\n", "<br/>")


def table_on_paper(table: Table, width: float) -> Any:  # noqa: ANN401 - as above
    """Return a table as wide as the column of text."""
    head = [paragraph(title, "head", alignment=2 * (k in table.numbers)) for k, title in enumerate(table.titles)]
    rows = [[_cell(cell, number=k in table.numbers) for k, cell in enumerate(row)] for row in table.rows]
    return _ruled([head, *rows], column_widths(table, width), heads=1)


def verdicts_on_paper(part: Verdicts, width: float) -> Any:  # noqa: ANN401 - as above
    """Return verdicts, each in words and a colour."""
    rows = [
        [
            paragraph(one.name, "cell"),
            paragraph(one.word, "head", textColor=TONES[one.tone], fontSize=7.5, leading=9.5),
            paragraph(one.sentence, "cell"),
        ]
        for one in part.verdicts
    ]
    return _ruled(rows, [NAME_SHARE * width, WORD_SHARE * width, (1.0 - NAME_SHARE - WORD_SHARE) * width], heads=0)


def terms_on_paper(part: Terms, width: float) -> Any:  # noqa: ANN401 - as above
    """Return words and what they mean."""
    rows = [[paragraph(name, "head"), paragraph(meaning, "cell")] for name, meaning in part.pairs]
    return _ruled(rows, [NAME_SHARE * width, (1.0 - NAME_SHARE) * width], heads=0)


def _cell(cell: Cell, *, number: bool) -> Any:  # noqa: ANN401 - as above
    kind = "code" if cell.code else "number" if number else "cell"
    return paragraph(cell.text, kind, textColor=TONES[cell.tone])


def column_widths(table: Table, width: float) -> list[float]:
    """Return widths that add up to the width: every column its longest word, the rest to those that say most."""
    least = [_longest_word(table, k) + 2.0 * PAD for k in range(len(table.titles))]
    if sum(least) >= width:
        return [width * one / sum(least) for one in least]
    claims = [max(min(len(row[k].text), MOST_LETTERS) for row in table.rows) + 1 for k in range(len(least))]
    spare = width - sum(least)
    return [one + spare * claim / sum(claims) for one, claim in zip(least, claims, strict=True)]


def _longest_word(table: Table, column: int) -> float:
    """Return the width of the longest word of a column, as far as it may claim; a number is one word. [pt]"""
    shown = style("head")
    words = set(table.titles[column].split())
    for row in table.rows:
        text = row[column].text[:LONGEST]
        words |= {text} if column in table.numbers else set(text.split())
    widest = max((float(stringWidth(word, shown.fontName, shown.fontSize)) for word in words), default=0.0)
    return min(widest + 1.0, WIDEST_WORD)


def _ruled(rows: list[list[Any]], widths: list[float], *, heads: int) -> Any:  # noqa: ANN401 - as above
    rules: list[tuple[Any, ...]] = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LINEBELOW", (0, 0), (-1, -1), 0.4, HexColor(LINE)),
        ("LEFTPADDING", (0, 0), (-1, -1), PAD),
        ("RIGHTPADDING", (0, 0), (-1, -1), PAD),
        ("TOPPADDING", (0, 0), (-1, -1), 2.0),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2.5),
    ]
    rules += [("BACKGROUND", (0, 0), (-1, heads - 1), HexColor(HEAD))] if heads else []
    return LongTable(
        rows, colWidths=widths, repeatRows=heads, style=TableStyle(rules), splitInRow=1, spaceAfter=8.0, hAlign="LEFT"
    )
