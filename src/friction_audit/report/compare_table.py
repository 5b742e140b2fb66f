"""Comparison of methods -> the table that people read."""

from collections.abc import Iterable, Mapping
from math import inf, isnan
from typing import TYPE_CHECKING, Any

from friction_audit.report.plain_table import plain_lines

if TYPE_CHECKING:
    from rich.console import RenderableType

Row = Mapping[str, Any]

ROLES = {"paper": "*", "best": "+", "other": " "}

LEGEND = (
    "* the paper's kind of tuning; + the best stable one of the sweeps, chosen for other persons",
    "intervals are 95 %; margin: factor by which the gain may grow before the loop is lost",
)

ENDLESS = ">32"
"""Margin beyond what is searched."""


def compare_table(rows: Iterable[Row], seeds: int) -> "list[RenderableType]":
    """Return a row per method and tuning, and the losses of those that did not hold.

    Args:
        rows: Entries of ``methods`` in the document.
        seeds: How many persons.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    told = list(rows)
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("method and tuning", no_wrap=True)
    for title in ("slope [mW]", "peak [N m]", "rms [N m]", "stable", "margin"):
        table.add_column(Text(title), no_wrap=True, justify="right")
    for before, row in zip((None, *told), told, strict=False):
        if before is None or before["method"] != row["method"]:
            table.add_row(Text(row["label"]))
        table.add_row(*(Text(text) for text in _cells(row)))
    losses = [_loss(row, seeds) for row in told if row["lost_s"]]
    return [Text(line) for line in (*plain_lines(table), *LEGEND, *losses)]


def _cells(row: Row) -> tuple[str, ...]:
    return (
        f"{ROLES[row['role']]} {row['tuning']}",
        _with_interval(row["energy_slope_w"], 1000.0, 1),
        _with_interval(row["peak_torque_nm"], 1.0, 2),
        _with_interval(row["rms_torque_nm"], 1.0, 3),
        f"{row['stable_share']:.0%}",
        ENDLESS if row["stability_margin"] == inf else f"{row['stability_margin']:.1f}",
    )


def _with_interval(told: Mapping[str, Any], factor: float, digits: int) -> str:
    value, low = told["value"], told["ci95"][0]
    if isnan(value):
        return "-"
    half = "" if isnan(low) else f" ± {factor * (value - low):.{digits}f}"
    return f"{factor * value:.{digits}f}{half}"


def _loss(row: Row, seeds: int) -> str:
    lost = row["lost_s"]
    return (
        f"{row['label']}, {row['tuning']}: the loop was lost in {len(lost)} of {seeds} seeds, first after "
        f"{min(lost):.1f} s; figures end there"
    )
