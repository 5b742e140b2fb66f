"""Figs 8, 10 and 11: one joint moved by a person."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from friction_audit.reporting.figures.paper import (
    Course,
    draw_energy,
    draw_loop,
    draw_raw_and_filtered,
    draw_steps,
    shade,
)
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    DISSIPATED,
    FILTERED,
    FITTED,
    MUTED,
    RAW,
    SHEET_IN,
    add_legend,
    figure_style,
    label_panel,
    new_figure,
    smooth,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_uncompensated(course: Course) -> "Figure":
    """Draw velocity and torque, the net energy, and the torque over the velocity."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 5.6)
        panels = figure.subplots(4, 1, height_ratios=(1, 1, 1.2, 2))
        handles = _draw_signals(panels[0], panels[1], course) + draw_energy(panels[2], course, "(b)")
        draw_loop(panels[3], course, "(c)")
        _share_time(panels[:3])
        add_legend(figure, handles)
        figure.align_ylabels()
        return figure


def draw_compensated(course: Course) -> "Figure":
    """Draw velocity and torque, the net energy, and both coefficients."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 5.2)
        panels = figure.subplots(5, 1)
        handles = _draw_signals(panels[0], panels[1], course) + draw_energy(panels[2], course, "(b)")
        second = float(course.ends_j[1])
        handles.append(panels[2].axhline(second, color=FITTED, lw=0.7, ls=(0, (4, 1.5)), label="$E^2_{cyclic}$"))
        draw_steps(panels[3], course, ("viscous_nms_per_rad", "Viscous\n[N m s/rad]", FILTERED), "(c)")
        draw_steps(panels[4], course, ("coulomb_nm", "Coulomb\n[N m]", DISSIPATED), "")
        _share_time(panels)
        add_legend(figure, handles)
        figure.align_ylabels()
        return figure


def draw_compensated_loop(course: Course, without: Course) -> "Figure":
    """Draw the torque over the velocity, on the axes of the joint that without compensation."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.5)
        axes = figure.subplots()
        handles = draw_loop(axes, course, "")
        reach = 1.05 * float(abs(without.interaction_nm).max())
        axes.set_ylim(-reach, reach)
        add_legend(figure, handles)
        return figure


def _draw_signals(above: "Axes", below: "Axes", course: Course) -> "list[Artist]":
    """Draw velocity above interaction torque; return the legend's entries."""
    for axes, name, label in ((above, "dq", "Velocity\n[rad/s]"), (below, "interaction_nm", "Torque\n[N m]")):
        shade(axes, course)
        handles = draw_raw_and_filtered(axes, course, name)
        label_panel(axes, "(a)" if axes is above else "")
        axes.set_ylabel(label)
    return handles


def _share_time(panels: "list[Axes]") -> None:
    """Write the time below the last panel only."""
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    panels[-1].set_xlabel("Time [s]")


DRAWN = 1500
ROW_IN = 0.92


def draw_whole_arm(courses: Sequence[Course]) -> "Figure":
    """Draw a row for every joint: velocity and torque, net energy, both coefficients."""
    with figure_style(mathematics=True):
        figure = new_figure(SHEET_IN, 0.9 + ROW_IN * len(courses))
        panels = figure.subplots(len(courses), 3, squeeze=False, sharex=True)
        for number, (row, course) in enumerate(zip(panels, courses, strict=True), start=1):
            handles = _draw_row(row, course)
            row[0].set_ylabel(f"joint {number}")
        titles = ("(a) velocity [rad/s], torque [N m]", "(b) net energy [J]", "(c) coefficients [N m], [N m s/rad]")
        for axes, title in zip(panels[0], titles, strict=True):
            axes.set_title(title, loc="left")
        figure.supxlabel("Time [s]", fontsize=7.5)
        add_legend(figure, handles)
        figure.align_ylabels()
        return figure


def _draw_row(row: "Sequence[Axes]", course: Course) -> "list[Artist]":
    """Draw one joint; return the legend's entries."""
    for axes in row:
        shade(axes, course)
        axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
        label_panel(axes, "", across=6)
    left, middle, right = row
    t, torque = course.t, course.interaction_nm
    handles: list[Artist] = []
    handles += left.plot(*thin_extremes(t, torque, DRAWN), color=RAW, lw=0.4, label="torque", rasterized=True)
    handles += left.plot(*thin_extremes(t, smooth(t, torque), DRAWN), color=FILTERED, lw=0.6, label="filtered (10 Hz)")
    handles += left.plot(*thin_extremes(t, course.dq, DRAWN), color=FITTED, lw=0.7, label="velocity")
    middle.plot(*thin_extremes(t, course.energy_j, DRAWN), color=FILTERED)
    handles += middle.plot(
        course.ends_s, course.ends_j, "o", color=BORDER, ms=2.0, mew=0, zorder=5, label="end of a cycle"
    )
    handles += right.plot(*thin_extremes(t, course.coulomb_nm, DRAWN), color=DISSIPATED, label="Coulomb")
    handles += right.plot(
        *thin_extremes(t, course.viscous_nms_per_rad, DRAWN), color=FILTERED, ls=(0, (4, 1.5)), label="viscous"
    )
    return handles
