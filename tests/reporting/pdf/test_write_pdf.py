"""The report on paper: what is on it, that nothing is cut, that hostile names are text."""

import io
import re
from functools import cache

import pytest
from friction_audit.reporting.html.log_part import part_of
from friction_audit.reporting.pdf.sheet import draw_sheet
from friction_audit.reporting.pdf.tables import column_widths
from friction_audit.reporting.pdf.write_pdf import write_pdf
from friction_audit.reporting.report_bytes import REPORT_FORMATS
from pypdf import PdfReader
from reportlab.lib.pagesizes import A4

from friction_audit.cli import choices
from friction_audit.reporting.html import log_figures
from friction_audit.reporting.html.log_figures import LOG_FIGURES
from friction_audit.reporting.html.log_page import log_page
from friction_audit.reporting.html.page import Cell, Page, Section, Table, Text
from tests.reporting import log_report_by_hand as by_hand

LONG = "a" * 300


@cache
def page(case: str) -> Page:
    """Return the page of a report: every figure of one joint that was diagnosed and one that was not, or odd names."""
    if case == "plain":
        return log_page(part_of(by_hand.report(), (1, 3)), draw_sheet)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(log_figures, "LOG_FIGURES", LOG_FIGURES[:2])
        return log_page(by_hand.hostile(), draw_sheet)


@cache
def paper(case: str) -> PdfReader:
    return PdfReader(io.BytesIO(write_pdf(page(case))))


@cache
def texts(case: str) -> list[str]:
    """The text of each page; to take it from a page with figures takes long."""
    return [sheet.extract_text() for sheet in paper(case).pages]


def joined(pages: list[str]) -> str:
    return re.sub(r"\s+", " ", " ".join(pages))


def words(reader: PdfReader) -> str:
    return joined([sheet.extract_text() for sheet in reader.pages])


def test_everything_is_on_it() -> None:
    found = joined(texts("plain"))
    for section in page("plain").sections:
        assert section.title in found
    assert "effect named" in found
    assert by_hand.COMMAND in found
    assert "10.1109/TMECH.2024.3410330" in found
    assert "friction.estimator" in found
    for kind in LOG_FIGURES:
        assert kind.title in found
    assert [str(entry["/Title"]) for entry in paper("plain").outline if isinstance(entry, dict)] == [
        *(section.title for section in page("plain").sections),
        "Details",
    ]


def test_figures_are_lines_and_letters() -> None:
    found = joined(texts("plain"))
    assert "Velocity [rad/s]" in found  # of an axis: text, no picture of text
    streams = [sheet.get_contents() for sheet in paper("plain").pages]
    shapes = sum(stream.get_data().count(b" l\n") for stream in streams if stream is not None)
    assert shapes > 1000


@pytest.mark.parametrize("case", ["plain", "hostile"])
def test_pages_are_a4_and_numbered(case: str) -> None:
    sheets = paper(case).pages
    for number, sheet in enumerate(sheets, start=1):
        assert (sheet.mediabox.width, sheet.mediabox.height) == pytest.approx(A4, abs=0.01)
        assert f"page {number} of {len(sheets)}" in texts(case)[number - 1]


def test_markup_is_text() -> None:
    assert "<script>alert('x')</script>" in joined(texts("hostile"))


def test_figures_write_a_name_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_figures, "LOG_FIGURES", LOG_FIGURES[:3])
    found = words(
        PdfReader(io.BytesIO(write_pdf(log_page(by_hand.called("a$b$ \N{CJK UNIFIED IDEOGRAPH-819D}"), draw_sheet))))
    )
    assert found.count("joint 1 a$b$") >= 3


def test_same_page_same_bytes() -> None:
    assert write_pdf(page("hostile")) == write_pdf(page("hostile"))


def test_what_is_too_long_for_a_page_goes_on_the_next() -> None:
    row = (Cell(text="1"), Cell(text="word " * 3000), Cell(text=LONG, code=True))
    table = Table(caption="Long", titles=("joint", "what", "name"), rows=[row] * 3)
    section = Section(anchor="a", title="\udce9\x00 knee", parts=(table, Text(lines=("line " * 9000,))))
    reader = PdfReader(io.BytesIO(write_pdf(Page(title="t" * 200, lead="", facts=[("a", "b")], sections=[section]))))
    assert len(reader.pages) > 4
    assert "\\udce9" in words(reader)


def test_columns_fill_the_width_and_numbers_are_not_broken() -> None:
    rows = [(Cell(text="1"), Cell(text="0.2650 ± 0.0053"), Cell(text="did not move, " * 20))]
    table = Table(caption="", titles=("joint", "Coulomb [N m]", "remark"), rows=rows, numbers=frozenset({1}))
    widths = column_widths(table, 500.0)
    assert sum(widths) == pytest.approx(500.0)
    assert widths[1] > 55.0
    assert widths[2] > 300.0
    crowded = Table(caption="", titles=(LONG,) * 20, rows=[(Cell(text=LONG),) * 20])
    assert sum(column_widths(crowded, 500.0)) == pytest.approx(500.0)


def test_formats_of_the_options_are_those_of_the_report() -> None:
    assert {name: ending for name, (ending, _) in REPORT_FORMATS.items()} == choices.REPORT_FORMATS
