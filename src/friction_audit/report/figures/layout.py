"""Sheets, panels, legends and the sentences of empty panels."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

from friction_audit.report.figures.joint_series import JointSeries
from friction_audit.report.figures.style import BORDER, COLUMN_IN, MUTED, REJECTED, SHADE, SHEET_IN

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

MOST_SHADED = 80
"""Cycles in one panel above which stripes would only be grey."""
LONGEST_LABEL = 24
"""Characters of a label up to which two stand side by side in a column of a paper."""
TICKS_ON_SHEET = 4
TICKS_IN_COLUMN = 6


def new_figure(width_in: float, height_in: float) -> "Figure":
    """Return an empty figure that no screen and no global state knows of."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


def new_pairs(joints: int, *, sheet: bool) -> "tuple[Figure, NDArray[np.object_]]":
    """Return a figure over time and its two panels per joint: a row of a sheet, or above each other in a column."""
    if sheet:
        figure = new_figure(SHEET_IN, 0.6 + 1.15 * joints)
        return figure, figure.subplots(joints, 2, squeeze=False, sharex=True)
    figure = new_figure(COLUMN_IN, 3.2)
    return figure, figure.subplots(2, 1, squeeze=False, sharex=True).T


def label_panel(axes: "Axes", title: str, *, across: int | None = None) -> None:
    """Write the panel's title above the upper left corner and keep the ticks few, ``across`` along the x axis."""
    from matplotlib.ticker import MaxNLocator

    axes.set_title(title, loc="left")
    ticks = TICKS_IN_COLUMN if is_narrow(axes.get_figure(root=True)) else TICKS_ON_SHEET
    for axis, most in ((axes.xaxis, across or ticks), (axes.yaxis, ticks)):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


def say_in_panel(axes: "Axes", sentence: str, *, characters: int) -> None:
    """Write a sentence into a panel, wrapped, on a ground that keeps it readable."""
    if not sentence:
        return
    axes.text(
        0.5,
        0.5,
        fill(sentence, characters),
        transform=axes.transAxes,
        ha="center",
        va="center",
        fontsize=6.5,
        color=BORDER,
        bbox={"facecolor": "white", "edgecolor": MUTED, "linewidth": 0.4, "pad": 2.5, "alpha": 0.92},
        zorder=10,
    )


def is_crowded(series: JointSeries) -> bool:
    """Return True where a joint has too many cycles to tell them apart in one panel."""
    return len(series.cycles.joint) > MOST_SHADED


def shade_cycles(axes: "Axes", series: JointSeries) -> None:
    """Shade every other cycle of a joint and hatch the ones left out of the estimates."""
    cycles = series.cycles
    if is_crowded(series):
        return
    for row, (start, stop, reason) in enumerate(zip(cycles.start_s, cycles.stop_s, cycles.reason, strict=True)):
        if reason == 0 and row % 2 == 0:
            axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0)
        if reason != 0:
            axes.axvspan(start, stop, facecolor="none", edgecolor=REJECTED, hatch="/////", linewidth=0, zorder=0)


def cycle_handles(all_series: Sequence[JointSeries]) -> "list[Artist]":
    """Return the legend's entries for what shade_cycles drew on the panels of these joints."""
    from matplotlib.patches import Patch

    shown = [series for series in all_series if len(series.cycles.joint) and not is_crowded(series)]
    handles: list[Artist] = [Patch(facecolor=SHADE, label="cycle (every other)")] if shown else []
    if any((series.cycles.reason != 0).any() for series in shown):
        handles.append(Patch(facecolor="none", edgecolor=REJECTED, hatch="/////", linewidth=0, label="cycle left out"))
    if any(map(is_crowded, all_series)):
        handles.append(Patch(facecolor="none", linewidth=0, label=f"more than {MOST_SHADED} cycles are not shaded"))
    return handles


def add_legend(figure: "Figure", handles: "Sequence[Artist]", *, formula: str | None = None) -> None:
    """Write one legend above all panels, as wide as the figure allows; the label that is a formula as one."""
    if not handles:
        return
    longest = max(len(str(handle.get_label())) for handle in handles if handle.get_label() != formula)
    columns = (2 if longest <= LONGEST_LABEL else 1) if is_narrow(figure) else 6
    legend = figure.legend(handles=list(handles), loc="outside upper center", ncols=columns)
    for text in legend.get_texts():
        text.set_parse_math(text.get_text() == formula)


def is_narrow(figure: "Figure | None") -> bool:
    """Return True for a figure of one column of a paper."""
    return figure is not None and figure.get_figwidth() <= COLUMN_IN
