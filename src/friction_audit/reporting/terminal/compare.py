"""Claims of the paper -> the table that people read."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, isnan
from typing import TYPE_CHECKING, Any

from friction_audit.reporting.terminal.plain import plain_lines

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


ROLES = {"paper": "*", "best": "+", "other": " "}

LEGEND = (
    "* the paper's kind of tuning; + the best stable one of the sweeps, chosen for other persons",
    "slope, peak and rms: means over the persons with whom the loop held, with 95 % intervals",
)

MARGIN = "margin: factor by which the gain may grow before the loop is lost, 0 if it is lost as it is;"

ENDLESS = ">32"
"""Margin beyond what is searched."""


def compare_table(rows: Iterable[Row], seeds: int, tuning_seeds: int) -> "list[RenderableType]":
    """Return a row per method and tuning, and the losses of those that did not hold.

    Args:
        rows: Entries of ``methods`` in the document.
        seeds: How many persons.
        tuning_seeds: How many persons the settings were chosen for.
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
    # A tuning that is both the paper's kind and the best one lost the same loops.
    notes = dict.fromkeys(note for row in told for note in _notes(row, seeds, tuning_seeds))
    return [Text(line) for line in (*plain_lines(table), *LEGEND, *_margins(told), *notes)]


def _cells(row: Row) -> tuple[str, ...]:
    return (
        f"{ROLES[row['role']]} {row['tuning']}",
        _with_interval(row["energy_slope_w"], 1000.0, 1),
        _with_interval(row["peak_torque_nm"], 1.0, 2),
        _with_interval(row["rms_torque_nm"], 1.0, 3),
        f"{row['stable_share']:.0%}",
        _margin(row["stability_margin"]),
    )


def _margin(told: Mapping[str, Any]) -> str:
    """Return the bounds of a median, which need not lie evenly about it, or the median where it has none."""
    bounds = [told["value"]] if isnan(told["ci95"][0]) else told["ci95"]
    return "..".join(dict.fromkeys(map(_factor, bounds)))


def _factor(value: float) -> str:
    if isnan(value):
        return "-"
    return ENDLESS if value == inf else f"{value:.2g}"


def _margins(rows: Sequence[Row]) -> tuple[str, ...]:
    """Return how the margins are to be read, if they were looked for."""
    persons = max((len(row["stability_margins"]) for row in rows), default=0)
    if not persons:
        return ()
    known = any(not isnan(row["stability_margin"]["ci95"][0]) for row in rows)
    those = f"the median of {persons} persons" if persons > 1 else "one person"
    return (MARGIN, f"{'95 % interval of ' if known else 'of '}{those}")


def _with_interval(told: Mapping[str, Any], factor: float, digits: int) -> str:
    value, low = told["value"], told["ci95"][0]
    if isnan(value):
        return "-"
    half = "" if isnan(low) else f" ± {factor * (value - low):.{digits}f}"
    return f"{factor * value:.{digits}f}{half}"


def _notes(row: Row, seeds: int, tuning_seeds: int) -> Iterator[str]:
    """Yield what to know about a tuning whose loop was lost."""
    name, lost, in_tuning = f"{row['label']}, {row['tuning']}", row["lost_s"], row["tuning_losses"]
    if lost:
        yield (
            f"{name}: the loop was lost in {len(lost)} of {seeds} seeds, first after {min(lost):.1f} s; "
            "figures end there"
        )
    if in_tuning:
        yield f"{name}: no setting tried is stable; here the loop was lost with {in_tuning} of {tuning_seeds} persons"
