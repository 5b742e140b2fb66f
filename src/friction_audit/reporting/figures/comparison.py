"""Comparison -> net energies and friction curves of the methods (the paper's Figs 13, 14), sweeps and summary."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise, takewhile
from math import isfinite
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from friction_audit.compensation.comparison.methods import BEST, NONE, PAPER
from friction_audit.compensation.comparison.result import Comparison, Curve, Row
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.words import scaled

# Colour and dashes of each method.
LOOKS: dict[str, tuple[str, Any]] = {
    "none": (theme.MUTED, (0, (1, 1))),
    "sigmoid": (theme.DISSIPATED, theme.DASHED),
    "lugre": (theme.REJECTED, (0, (4, 1.2, 1, 1.2))),
    "disturbance_observer": ("#56b4e9", (0, (6, 1))),
    "torque_regulation": (theme.GREEN, "-."),
    "energy": (theme.FITTED, "-"),
    "oracle": (theme.FILTERED, (0, (1, 0.6))),
}
LOST: dict[str, Any] = {"color": theme.BORDER, "marker": "x", "ls": ""}  # where a loop was lost


def _draw_energies(comparison: Comparison) -> Figure:
    """Draw the net energies of all methods over time, in one panel as in the paper."""
    rows = [row for row in comparison.rows if row.role == PAPER]
    figure, (axes,) = parts.grid([2.9], 1, theme.COLUMN_IN, 0.0)
    parts.mark_zero(axes)
    for row in rows:
        (colour, dashes), course = LOOKS[row.method], row.course
        parts.draw_curve(axes, course.t, course.energy_j, 2000, color=colour, ls=dashes, lw=0.9, label=row.label)
        if isfinite(row.outcomes[0].lost_s):
            axes.plot(course.t[-1], course.energy_j[-1], ms=5, mew=1.2, zorder=6, label="loop lost", **LOST)
    axes.axvline(rows[0].course.from_s, color=theme.MUTED, lw=0.6, ls=":", label="end of 2nd cycle")
    axes.margins(x=0.01)
    parts.label_panel(axes, y="Net energy input [J]")
    axes.set_xlabel("Time [s]")
    parts.add_legend(figure)
    return figure


ACROSS = 3
LONGEST_TITLE = 16  # characters above a panel
GROUND = "#c8c8c8"  # colour of the curve without compensation, which all others are compared with


def _draw_loops(comparison: Comparison) -> Figure:
    """Draw torque over velocity after the second cycle, a panel for every method over the curve without any."""
    rows = [row for row in comparison.rows if row.role == PAPER]
    # The joint that takes most torque to move without compensation.
    joint = int(np.argmax((rows[0].course.interaction_nm ** 2).mean(axis=0)))
    figure, panels = parts.grid([1.3] * len(rows), ACROSS, theme.COLUMN_IN, 0.3, sharex=True, sharey=True)
    for axes, row in zip(panels, rows, strict=True):
        parts.mark_zero(axes, x=True, lw=0.3, zorder=0)
        if row is not rows[0]:
            axes.plot(*_loop(rows[0], joint), color=GROUND, lw=0.5, zorder=1)
        axes.plot(*_loop(row, joint), color=LOOKS[row.method][0], lw=0.6, zorder=2)
        parts.label_panel(axes, fill(row.label, LONGEST_TITLE), across=3)
        if isfinite(row.outcomes[0].lost_s):
            axes.text(0.04, 0.96, "loop lost", transform=axes.transAxes, va="top", fontsize=6.5, color=theme.BORDER)
    figure.supxlabel(f"Velocity of joint {joint + 1} [rad/s]")
    figure.supylabel("Interaction torque [N m]")
    return figure


def _loop(row: Row, joint: int) -> tuple[Float, Float]:
    """Return velocity and torque of a joint after the second cycle, filtered as in the paper."""
    part = row.course.t >= row.course.from_s
    t, thin = row.course.t[part], parts.every_nth(int(part.sum()), 3000)
    dq, torque = (parts.smooth(t, one[part, joint])[thin] for one in (row.course.dq, row.course.interaction_nm))
    return dq, torque


WIDE = 8.0  # largest over smallest value from which the axis is logarithmic
MARKERS, SHADES = ("o", "s", "^", "v", "D"), (1.0, 0.75, 0.75, 0.45, 0.45)
MILLI = 1000.0


def _draw_all_sweeps(comparison: Comparison) -> Figure:
    """Draw the energy slope over the setting, a panel for every setting, and shade where a loop was lost."""
    none = comparison.row(NONE, PAPER)
    settings = list(dict.fromkeys((curve.method, curve.axis) for curve in comparison.curves))
    figure, panels = parts.grid([1.5] * len(settings), 2, theme.COLUMN_IN, 0.2, sharey=True)
    for axes, setting in zip(panels, settings, strict=True):
        sweeps = [curve for curve in comparison.curves if (curve.method, curve.axis) == setting]
        parts.mark_zero(axes)
        if none is not None:
            slope = MILLI * none.interval("energy_slope_w").value
            axes.axhline(slope, color=theme.MUTED, lw=0.6, ls=(0, (1, 1)), zorder=1)
            place = axes.get_yaxis_transform()
            axes.text(0.98, slope, none.label, transform=place, ha="right", va="top", fontsize=6, color=theme.MUTED)
        parts.label_panel(axes, sweeps[0].label)  # before the scale, whose ticks are its own
        _draw_sweeps(axes, sweeps)
        axes.set_xlabel(sweeps[0].axis)
    figure.supylabel("Slope of the net energy [mW]")
    return figure


def _draw_sweeps(axes: Axes, sweeps: Sequence[Curve]) -> None:
    """Draw the stable points of each sweep, and a cross where the loop was lost first on either side of them."""
    values = [point.value for sweep in sweeps for point in sweep.points]
    logarithmic = max(values) > WIDE * min(values)
    if logarithmic:
        axes.set_xscale("log")
    for number, sweep in enumerate(sweeps):
        held = [point for point in sweep.points if not point.lost_s]
        look: theme.Look = {"marker": MARKERS[number], "alpha": SHADES[number], "color": LOOKS[sweep.method][0]}
        slopes = [MILLI * point.interval("energy_slope_w").value for point in held]
        axes.plot([one.value for one in held], slopes, ms=2.6, mew=0, lw=0.8, zorder=3, label=sweep.name, **look)
        for neighbour, lost in (*pairwise(sweep.points), *pairwise(reversed(sweep.points))):
            if lost.lost_s and not neighbour.lost_s:
                slope = MILLI * neighbour.interval("energy_slope_w").value
                axes.plot(lost.value, slope, ms=3.5, mew=0.8, zorder=4, **LOST)
    if all(sweep.points[-1].lost_s for sweep in sweeps):
        # From the first value on from which every loop is always lost.
        ends = [list(takewhile(lambda point: point.lost_s, reversed(sweep.points))) for sweep in sweeps]
        start = max(lost[-1].value for lost in ends)
        axes.axvspan(start, max(values), facecolor=theme.SHADE, edgecolor="none", zorder=0)
        middle = (start * max(values)) ** 0.5 if logarithmic else 0.5 * (start + max(values))
        axes.text(
            middle, 0.5, "loop lost", transform=axes.get_xaxis_transform(), ha="center", va="center", rotation=90,
            fontsize=6, color=theme.MUTED,
        )  # fmt: skip
    if len(sweeps) > 1:
        axes.legend(
            loc="upper center", bbox_to_anchor=(0.45, 0.93), ncols=2, fontsize=5.5, handlelength=1.2,
            columnspacing=0.8, borderaxespad=0.1, labelspacing=0.2,
        )  # fmt: skip


SHIFTS = {PAPER: -0.14, BEST: 0.14}  # where a role's marker stands, in rows
SHAPES = {PAPER: ("o", "full", "the setting of the paper's order"), BEST: ("D", "none", "best stable tuning")}


def _draw_summary(comparison: Comparison) -> Figure:
    """Draw the setting of the paper's order and the best one of every method, with 95 % intervals."""
    rows = [row for row in comparison.rows if row.role in SHIFTS]
    labels = list(dict.fromkeys(row.label for row in rows))
    figure, (left, right) = parts.grid([0.27 * len(labels)] * 2, 2, theme.COLUMN_IN, 0.9, sharey=True)
    for row in rows:
        alone = sum(other.label == row.label for other in rows) == 1
        place = labels.index(row.label) + (0.0 if alone else SHIFTS[row.role])
        _draw_interval(left, row, place, scaled(row.interval("energy_slope_w"), MILLI))
        _draw_interval(right, row, place, row.interval("rms_torque_nm"))
    for axes, title in ((left, "(a) slope [mW]"), (right, "(b) rms torque [N m]")):
        parts.mark_zero(axes, x=True, y=False)
        parts.label_panel(axes, title, across=4)
        axes.set_ylim(len(labels) - 0.5, -0.5)
        axes.set_yticks(range(len(labels)), labels)
        axes.tick_params(axis="y", length=0)
    for shape, filling, label in SHAPES.values():
        left.plot([], [], shape, color=theme.MUTED, fillstyle=filling, ms=3.5, mew=0.8, label=label)
    parts.add_legend(figure)
    return figure


def _draw_interval(axes: Axes, row: Row, place: float, shown: Coefficient) -> None:
    """Draw a mean with its interval, and at the right how many loops were lost: those are not in the means."""
    shape, filling, _ = SHAPES[row.role]
    axes.errorbar(
        shown.value, place, xerr=[[shown.value - shown.low], [shown.high - shown.value]], fmt=shape,
        fillstyle=filling, color=LOOKS[row.method][0], ms=3.5, mew=0.8, elinewidth=0.8, capsize=1.5, zorder=3,
    )  # fmt: skip
    if row.lost_s:
        axes.text(
            0.97, place, f"{1 - row.stable_share:.0%} lost", transform=axes.get_yaxis_transform(), ha="right",
            va="center", fontsize=5.5, color=theme.BORDER,
        )  # fmt: skip


FIGURES: Mapping[str, Callable[[Comparison], Figure]] = {
    "energy": _draw_energies,
    "velocity-torque": _draw_loops,
    "sweep": _draw_all_sweeps,
    "summary": _draw_summary,
}


@theme.figure_style(mathematics=True)
def draw_comparison(comparison: Comparison, names: Iterable[str] = FIGURES) -> dict[str, Figure]:
    """Return figures by name; a comparison without sweeps has no figure of them."""
    return {name: FIGURES[name](comparison) for name in names if name != "sweep" or comparison.curves}
