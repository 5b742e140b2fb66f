"""Claims of the paper -> the table that people read."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import RenderableType

TITLES = ("fig", "claim", "paper", "ours", "holds")


def claim_table(claims: Iterable[Mapping[str, Any]]) -> "list[RenderableType]":
    """Return a row per claim, each with ``figure``, ``claim``, ``paper``, ``ours`` and ``holds``, and the count."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    rows = list(claims)
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, show_lines=False)
    for title in TITLES:
        table.add_column(title, no_wrap=title in ("fig", "holds"), ratio={"claim": 3, "paper": 2, "ours": 4}.get(title))
    for row in rows:
        texts = (row["figure"], row["claim"], row["paper"], row["ours"], "yes" if row["holds"] else "NO")
        table.add_row(*(Text(str(text)) for text in texts))
    parts: list[RenderableType] = [table]
    parts += [Text(f"{row['figure']}: {row['note']}") for row in rows if not row["holds"] and row["note"]]
    parts.append(Text(f"{sum(bool(row['holds']) for row in rows)} of {len(rows)} claims hold"))
    return parts
