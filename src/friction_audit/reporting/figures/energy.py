"""Net energy over time: rises by what friction takes, cycle by cycle."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    DISSIPATED,
    FILTERED,
    SHEET_IN,
    ZOOMED,
    JointSeries,
    add_legend,
    all_series,
    cycle_handles,
    figure_style,
    is_crowded,
    joint_series,
    label_panel,
    new_figure,
    say_in_panel,
    shade_cycles,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2
CYCLES_ZOOMED = 40
"""Cycles of a long log that are drawn apart, shaded: the shortest are then still a millimetre wide."""
SMALLEST_ENERGY_J = 0.01
"""Half height of the panel of a joint that stands still. [J]"""


def draw_energy(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet; of a long log its first cycles apart."""
    with figure_style():
        joints = all_series(estimate) if joint is None else (joint_series(estimate, joint),)
        if any(map(is_crowded, joints)):
            return _draw_long(joints)
        columns = min(len(joints), COLUMNS)
        rows = -(-len(joints) // columns)
        width, height = (COLUMN_IN, 2.4) if columns == 1 else (SHEET_IN, 0.6 + 1.4 * rows)
        figure = new_figure(width, height)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        found = [_draw_panel(axes, series) for axes, series in zip(panels, joints, strict=False)]
        for axes in panels[len(joints) :]:
            axes.remove()
        _finish(figure, max(found, key=len) + cycle_handles(joints))
        return figure


def _draw_long(joints: tuple[JointSeries, ...]) -> "Figure":
    """Draw the whole log and its first cycles: side by side on a sheet, below each other for one joint."""
    from matplotlib.patches import Patch

    alone = len(joints) == 1
    figure = new_figure(*((COLUMN_IN, 3.6) if alone else (SHEET_IN, 0.6 + 1.15 * len(joints))))
    pairs = figure.subplots(2, 1, squeeze=False).T if alone else figure.subplots(len(joints), 2, squeeze=False)
    parts = tuple(series.first_cycles(CYCLES_ZOOMED) for series in joints)
    found = [_draw_pair(pair, *both) for pair, *both in zip(pairs, joints, parts, strict=True)]
    where = Patch(facecolor=ZOOMED, label=f"part drawn {'below' if alone else 'on the right'}")
    _finish(figure, [*max(found, key=len), where, *cycle_handles(parts)])
    return figure


def _draw_pair(pair: "tuple[Axes, Axes]", series: JointSeries, part: JointSeries) -> "list[Artist]":
    """Draw a joint's whole log and its first cycles, if it has any; return the legend's entries."""
    whole, zoomed = pair
    handles = _draw_energy(whole, series)
    label_panel(whole, series.title)
    say_in_panel(whole, series.not_determined, characters=44)
    if not len(part.cycles.joint):
        zoomed.remove()
        return handles
    whole.axvspan(part.t[0], part.t[-1], facecolor=ZOOMED, linewidth=0, zorder=0)
    handles = _draw_cycles(zoomed, part)
    label_panel(zoomed, f"cycles 1 to {len(part.cycles.joint)} of {len(series.cycles.joint)}")
    return handles


def _finish(figure: "Figure", handles: "list[Artist]") -> None:
    add_legend(figure, handles)
    figure.supxlabel("Time [s]", fontsize=7.5)
    figure.supylabel("Net energy [J]", fontsize=7.5)


def net_energy(series: JointSeries) -> Float:
    """Return the integral of F_m dq dt, zero at the first cycle's start (at t = 0 without one), shape (n,). [J]"""
    power = series.torque * series.dq
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(series.t))])
    first = int(series.cycles.start[0]) if len(series.cycles.start) else 0
    return np.asarray(energy - energy[first], dtype=np.float64)


def dissipated_stairs(series: JointSeries) -> tuple[Float, Float]:
    """Return the borders of the cycles and what friction took up to each of them. [s], [J]"""
    cycles = series.cycles
    edges = np.concatenate([cycles.start_s[:1], cycles.stop_s])
    return edges, np.concatenate([np.zeros(min(len(edges), 1)), np.cumsum(cycles.dissipated_j)])


def _draw_panel(axes: "Axes", series: JointSeries) -> "list[Artist]":
    """Draw one joint with its cycles; return the legend's entries."""
    handles = _draw_cycles(axes, series)
    label_panel(axes, series.title)
    say_in_panel(axes, series.not_determined, characters=44)
    return handles


def _draw_cycles(axes: "Axes", series: JointSeries) -> "list[Artist]":
    """Draw the net energy, shade the cycles and mark their borders; return the legend's entries."""
    shade_cycles(axes, series)
    handles = _draw_energy(axes, series)
    edges, stairs = dissipated_stairs(series)
    if len(edges):
        # The last step holds until the log ends.
        held = np.append(edges, max(series.t[-1], edges[-1])), np.append(stairs, stairs[-1])
        handles.extend(axes.step(*held, where="post", color=DISSIPATED, lw=0.9, label="dissipated, per cycle"))
        borders = np.concatenate([series.cycles.start[:1], series.cycles.stop])
        energy = net_energy(series)[borders]
        dots = axes.plot(series.t[borders], energy, "o", color=BORDER, ms=2.0, mew=0, zorder=5, label="zero velocity")
        handles.extend(dots)
    return handles


def _draw_energy(axes: "Axes", series: JointSeries) -> "list[Artist]":
    """Draw the net energy alone; return the legend's entry."""
    energy = net_energy(series)
    axes.set_xlim(series.t[0], series.t[-1])
    if np.ptp(energy) < SMALLEST_ENERGY_J:
        axes.set_ylim(-SMALLEST_ENERGY_J, SMALLEST_ENERGY_J)
    return list(axes.plot(*thin_extremes(series.t, energy), color=FILTERED, lw=0.9, label="net energy"))
