"""LogReport -> its file in each format: HTML, PDF, Markdown, JSON."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from friction_audit import __version__
from friction_audit.errors import UsageError, printable
from friction_audit.reporting.documents import write_document
from friction_audit.reporting.html.log_page import log_page
from friction_audit.reporting.html.page import Command, Figure, Page, Part, Section, Terms, Text, render_page
from friction_audit.reporting.report import LogReport, report_document
from friction_audit.reporting.table import Table

# Characters that Markdown, its tables, its formulas or the HTML in it may take for something: an underscore, a hash or
# a plus only where no letter is before it.
SPECIAL = re.compile(r"([\\`*{}\[\]<>|~&$]|(?<!\w)[_#+]|_(?!\w))")
FENCE = "```"


def write_pdf(page: Page) -> bytes:
    """Return a page as PDF: the page, printed.

    Raises:
        UsageError: If what prints it is not installed.
    """
    try:
        from weasyprint import HTML
    except (ImportError, OSError) as error:  # OSError: without the library pango
        raise UsageError(
            f"--format pdf: WeasyPrint cannot be loaded ({error}); install it with: pip install 'friction-audit[pdf]' "
            "(on Debian and Ubuntu also: apt install libpango-1.0-0 libpangoft2-1.0-0); or print the HTML page"
        ) from error
    found: bytes = HTML(string=render_page(page, paper=True)).write_pdf(pdf_identifier=b"friction-audit")
    return found


def write_markdown(page: Page) -> str:
    """Return a page as Markdown, the same words and tables without drawings; names from the log stay text."""
    lines = [f"# {_text(page.title)}", "", _text(page.lead), ""]
    lines += [f"- {_text(name)}: {_text(value)}" for name, value in page.facts] + [""]
    for section in page.sections:
        lines += _section(section, 2)
    lines.append(f"Made by friction-audit {__version__}.")
    return printable("\n".join(lines) + "\n")


def _section(section: Section, level: int) -> Iterator[str]:
    yield from (f"{'#' * level} {_text(section.title)}", "")
    for part in section.parts:
        yield from _part(part)
        yield ""
    for inner in section.sections:
        yield from _section(inner, level + 1)


def _part(part: Part) -> Iterator[str]:
    match part:
        case Table():
            yield from (f"{_text(part.caption)}:", "")
            yield _row(_text(column.head(part.unit)) for column in part.columns)
            yield _row("---:" if column.number else "---" for column in part.columns)
            yield from (_row(_text(part.text(column, row)) for column in part.columns) for row in part.rows)
        case Figure():
            yield f"Figure: {_text(part.description)}"
        case Text(listed=True):
            yield from (f"- {_text(line)}" for line in part.lines)
        case Text():
            yield "\n\n".join(map(_text, part.lines))
        case Command():
            # The fence is longer than any run of backticks in the command.
            fence = "`" * max(len(FENCE), *(len(run) + 1 for run in re.findall("`+", part.line)), 0)
            yield from (f"{fence}sh", part.line, fence)
        case Terms():
            yield from (f"- **{_text(name)}**: {_text(meaning)}" for name, meaning in part.pairs)


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _text(text: str) -> str:
    """Return text in one line that Markdown takes for nothing else."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))


REPORT_FORMATS: Mapping[str, tuple[str, Callable[[LogReport], bytes]]] = {
    "html": (".html", lambda report: render_page(log_page(report)).encode()),
    "pdf": (".pdf", lambda report: write_pdf(log_page(report))),
    "markdown": (".md", lambda report: write_markdown(log_page(report, figures=False)).encode()),
    "json": (".json", lambda report: write_document(report_document(report)).encode()),
}
"""Formats: the ending of a file, and what is in it."""
