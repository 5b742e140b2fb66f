"""How methods look, in every figure alike: colours of Okabe and Ito, dashes and markers beside them."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, takewhile
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    DISSIPATED,
    FILTERED,
    FITTED,
    MUTED,
    REJECTED,
    SHADE,
    figure_style,
    label_panel,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Look(NamedTuple):
    """Colour, dashes and marker."""

    colour: str
    dashes: "str | tuple[float, tuple[float, ...]]"
    marker: str


LOOKS = {
    "none": Look(MUTED, (0, (1, 1)), "s"),
    "sigmoid": Look(DISSIPATED, (0, (4, 1.5)), "^"),
    "lugre": Look(REJECTED, (0, (4, 1.2, 1, 1.2)), "v"),
    "disturbance_observer": Look("#56b4e9", (0, (6, 1)), "D"),
    "torque_regulation": Look("#009e73", "-.", "P"),
    "energy": Look(FITTED, "-", "o"),
    "oracle": Look(FILTERED, (0, (1, 0.6)), "X"),
}

LOST = BORDER
"""Colour of the cross where a loop was lost."""


Sweep = Mapping[str, Any]

ACROSS = 2
WIDE = 8.0
"""Largest over smallest value from which the axis is logarithmic."""
MARKERS = ("o", "s", "^", "v", "D")
SHADES = (1.0, 0.75, 0.75, 0.45, 0.45)
MILLI = 1000.0


def draw_sweeps(sweeps: Iterable[Sweep], none_w: float) -> "Figure":
    """Draw the energy slope over the setting, a panel for every method, and shade where a loop was lost.

    Args:
        sweeps: Entries of ``sweeps`` in the document.
        none_w: Energy slope without compensation. [W]
    """
    told = list(sweeps)
    methods = list(dict.fromkeys(sweep["method"] for sweep in told))
    across = min(ACROSS, len(methods))
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 0.2 + 1.5 * ceil(len(methods) / across))
        panels = figure.subplots(ceil(len(methods) / across), across, squeeze=False, sharey=True)
        for axes, method in zip(panels.flat, methods, strict=False):
            _draw_method(axes, [sweep for sweep in told if sweep["method"] == method], none_w)
        for axes in panels.flat[len(methods) :]:
            axes.set_visible(False)
        figure.supylabel("Slope of the net energy [mW]", fontsize=7.5)
        return figure


def _draw_method(axes: "Axes", sweeps: Sequence[Sweep], none_w: float) -> None:
    label_panel(axes, sweeps[0]["label"])
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    axes.axhline(MILLI * none_w, color=MUTED, lw=0.6, ls=(0, (1, 1)), zorder=1)
    values = [point["value"] for sweep in sweeps for point in sweep["points"]]
    if max(values) > WIDE * min(values):
        axes.set_xscale("log")
    for number, sweep in enumerate(sweeps):
        _draw_sweep(axes, sweep, number, alone=len(sweeps) == 1)
    _shade_limit(axes, sweeps, max(values))
    axes.set_xlabel(sweeps[0]["axis"])
    if len(sweeps) > 1:
        axes.legend(
            loc="upper center",
            bbox_to_anchor=(0.45, 0.93),
            ncols=2,
            fontsize=5.5,
            handlelength=1.2,
            columnspacing=0.8,
            borderaxespad=0.1,
            labelspacing=0.2,
        )


def _draw_sweep(axes: "Axes", sweep: Sweep, number: int, *, alone: bool) -> None:
    """Draw the stable points, and a cross where the loop was lost first on either side of them."""
    held = [point for point in sweep["points"] if point["stable"]]
    slopes = [MILLI * point["energy_slope_w"]["value"] for point in held]
    axes.plot(
        [point["value"] for point in held],
        slopes,
        color=LOOKS[sweep["method"]].colour,
        alpha=SHADES[number % len(SHADES)],
        marker=MARKERS[0 if alone else number % len(MARKERS)],
        ms=2.6,
        mew=0,
        lw=0.8,
        label=sweep["sweep"],
        zorder=3,
    )
    for point, beside in _lost_beside(sweep["points"]):
        height = MILLI * beside["energy_slope_w"]["value"]
        axes.plot(point["value"], height, "x", color=LOST, ms=3.5, mew=0.8, zorder=4)


def _lost_for_good(points: Sequence[Mapping[str, Any]]) -> float:
    """Return the first value from which on the loop is always lost."""
    lost = list(takewhile(lambda point: not point["stable"], reversed(points)))
    return float(lost[-1]["value"])


def _lost_beside(points: Sequence[Mapping[str, Any]]) -> list[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """Return the points at which the loop was lost that are next to one at which it held, each with that one."""
    pairs = [*pairwise(points), *pairwise(reversed(points))]
    return [(lost, held) for held, lost in pairs if held["stable"] and not lost["stable"]]


def _shade_limit(axes: "Axes", sweeps: Sequence[Sweep], last: float) -> None:
    """Shade the values beyond which every sweep of a method has lost its loop for good."""
    if any(sweep["points"][-1]["stable"] for sweep in sweeps):
        return
    start = max(_lost_for_good(sweep["points"]) for sweep in sweeps)
    axes.axvspan(start, last, facecolor=SHADE, edgecolor="none", zorder=0)
    axes.text(
        (start * last) ** 0.5,
        0.5,
        "loop lost",
        transform=axes.get_xaxis_transform(),
        ha="center",
        va="center",
        rotation=90,
        fontsize=6,
        color=MUTED,
    )
