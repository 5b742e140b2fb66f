"""Figs 8, 10 and 11: one joint moved by a person."""

from typing import TYPE_CHECKING

from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.style import COLUMN_IN, DISSIPATED, FILTERED, FITTED, figure_style
from friction_audit.report.paper_figures.course import Course
from friction_audit.report.paper_figures.panels import (
    draw_energy,
    draw_loop,
    draw_raw_and_filtered,
    draw_steps,
    shade,
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
    """Draw the torque over the velocity, on the axes of the joint that nobody compensates."""
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
