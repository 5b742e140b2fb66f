"""Table specification -> lines of a terminal."""

import io
from collections.abc import Collection

from friction_audit.joint_log import JointLog
from friction_audit.reporting.table import Table
from friction_audit.reporting.words import MARK, in_unit

# Characters of a line.
WIDEST = 1000


def table_lines(table: Table, marked: Collection[int] = ()) -> list[str]:
    """Return a table as text, without spaces at the ends of its lines; the first cell of ``marked`` rows gets a mark.

    It is as wide as the terminal, and wider where numbers would be cut: a terminal breaks long lines, and half a number
    is worse. Columns of phrases give way.
    """
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    drawn = RichTable(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
    for column in table.columns:
        title, unit = column.short or column.title or column.name, in_unit(column.unit, table.unit)
        head = Text(f"{title}\n[{unit}]" if unit else title)
        drawn.add_column(head, justify="right" if column.number else "left", no_wrap=not column.words)
    for number, row in enumerate(table.rows):
        first, *others = (column.text(row) for column in table.columns)
        drawn.add_row(*map(Text, (f"{first} {MARK}" if number in marked else first, *others)))
    stream = io.StringIO()
    console = Console(file=stream, highlight=False, markup=False, color_system=None)
    roomy = console.options.update(max_width=WIDEST)
    for part in drawn.columns:
        if part.no_wrap:
            part.min_width = max(console.measure(cell, options=roomy).maximum for cell in (part.header, *part.cells))
    console.width = max(console.width, console.measure(drawn, options=roomy).minimum)
    console.print(drawn)
    return [line.rstrip() for line in stream.getvalue().splitlines()]


def log_line(log: JointLog) -> str:
    """Return which log it is and how much of it there is."""
    samples = f"{log.samples} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    return f"{log.source.path}: {log.source.format}, {samples}"
