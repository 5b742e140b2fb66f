"""Claims of the paper -> the table that people read."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from friction_audit.report.plain_table import plain_lines

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

Row = Mapping[str, Any]

SHARES = {"fig": None, "claim": 3, "paper": 2, "ours": 4, "holds": None}
"""Columns, and how they share the width; None for as wide as they need."""


def claim_table(claims: Iterable[Row]) -> "list[RenderableType]":
    """Return a row per claim, why those do not hold that do not, and how many hold.

    Args:
        claims: Each with ``figure``, ``claim``, ``paper``, ``ours``, ``holds`` and ``note``.
    """
    from rich.text import Text

    rows = list(claims)
    reasons = [f"{row['figure']}: {row['note']}" for row in rows if not row["holds"] and row["note"]]
    count = f"{sum(bool(row['holds']) for row in rows)} of {len(rows)} claims hold"
    return [Text(line) for line in (*plain_lines(_table(rows)), *reasons, count)]


def _table(rows: list[Row]) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for title, share in SHARES.items():
        table.add_column(title, no_wrap=share is None, ratio=share)
    for row in rows:
        texts = (row["figure"], row["claim"], row["paper"], row["ours"], "yes" if row["holds"] else "NO")
        table.add_row(*(Text(str(text)) for text in texts))
    return table
