"""Table -> lines of text."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

WIDEST = 1000
"""Characters of a line."""


def plain_lines(table: "Table") -> list[str]:
    """Return a table as text, without spaces at the ends of its lines.

    It is as wide as the terminal, and wider where a column that keeps its lines would be cut: a terminal breaks long
    lines, and half a number is worse.
    """
    from rich.console import Console

    console = Console(highlight=False, markup=False, color_system=None)
    roomy = console.options.update(max_width=WIDEST)
    for column in table.columns:
        if column.no_wrap:
            cells = (column.header, *column.cells)
            own = column.min_width or 0
            column.min_width = max(own, *(console.measure(cell, options=roomy).maximum for cell in cells))
    console.width = max(console.width, console.measure(table, options=roomy).minimum)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]
