"""Fig. 12: signals, energies and coefficients of all joints of an arm."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.smoothing import smooth
from friction_audit.report.figures.style import BORDER, DISSIPATED, FILTERED, FITTED, MUTED, RAW, SHEET_IN, figure_style
from friction_audit.report.figures.thinning import thin_extremes
from friction_audit.report.paper_figures.course import Course
from friction_audit.report.paper_figures.panels import shade

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
