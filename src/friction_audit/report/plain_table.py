"""Table -> lines of text."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table


def plain_lines(table: "Table") -> list[str]:
    """Return a table as text as wide as the terminal, without spaces at the ends of its lines."""
    from rich.console import Console

    console = Console(highlight=False, color_system=None)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]
