"""LogReport -> what its file holds, in each format."""

from collections.abc import Callable, Mapping

from friction_audit.reporting.html.log_page import log_page, write_log_page
from friction_audit.reporting.json.document import write_document
from friction_audit.reporting.json.report import log_document
from friction_audit.reporting.log_report import LogReport
from friction_audit.reporting.markdown import write_markdown


def _pdf(report: LogReport) -> bytes:
    from friction_audit.reporting.pdf.sheet import draw_sheet
    from friction_audit.reporting.pdf.write_pdf import write_pdf

    return write_pdf(log_page(report, draw_sheet))


REPORT_FORMATS: Mapping[str, tuple[str, Callable[[LogReport], bytes]]] = {
    "html": (".html", lambda report: write_log_page(report).encode()),
    "pdf": (".pdf", _pdf),
    "markdown": (".md", lambda report: write_markdown(log_page(report, None)).encode()),
    "json": (".json", lambda report: write_document(log_document(report)).encode()),
}
"""Formats: the ending of a file, and what is in it."""
