"""Page -> Markdown: the same words and tables, without drawings."""

import re
from collections.abc import Iterator, Sequence

from friction_audit import __version__
from friction_audit.errors import printable
from friction_audit.reporting.html.page import Cell, Command, Figure, Page, Part, Section, Table, Terms, Text, Verdicts

SPECIAL = re.compile(r"([\\`*_{}\[\]<>()#+!|~&$])")
"""Characters that Markdown, its tables, its formulas or the HTML in it may take for something."""
FENCE = "```"


def write_markdown(page: Page) -> str:
    """Return a page as Markdown; names from the log stay text."""
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
            yield from _table(part)
        case Figure():
            yield f"Figure: {_text(part.picture.description)}"
        case Verdicts():
            yield from (f"- **{_text(one.word)}** {_text(one.name)}: {_text(one.sentence)}" for one in part.verdicts)
        case Text(listed=True):
            yield from (f"- {_text(line)}" for line in part.lines)
        case Text():
            yield "\n\n".join(map(_text, part.lines))
        case Command():
            yield from _fenced(part.line)
        case Terms():
            yield from (f"- **{_text(name)}**: {_text(meaning)}" for name, meaning in part.pairs)


def _fenced(line: str) -> tuple[str, str, str]:
    """Return a command between fences longer than any run of backticks in it."""
    longest = max((len(run) for run in re.findall("`+", line)), default=0)
    fence = "`" * max(len(FENCE), longest + 1)
    return f"{fence}sh", line, fence


def _table(table: Table) -> Iterator[str]:
    yield from (f"{_text(table.caption)}:", "")
    yield _row(map(_text, table.titles))
    yield _row("---:" if k in table.numbers else "---" for k in range(len(table.titles)))
    yield from (_row(_cells(row)) for row in table.rows)


def _row(cells: Iterator[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(row: Sequence[Cell]) -> Iterator[str]:
    return (_text(cell.text) for cell in row)


def _text(text: str) -> str:
    """Return text in one line that Markdown takes for nothing else."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))
