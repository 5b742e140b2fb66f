"""Fig. 13: net energy between person and robot, method by method."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from friction_audit.report.compare_figures.look import LOOKS, LOST
from friction_audit.report.compare_figures.trial import TrialCourse
from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.style import COLUMN_IN, MUTED, figure_style
from friction_audit.report.figures.thinning import thin_extremes

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

DRAWN = 2000


def draw_energies(courses: Sequence[TrialCourse]) -> "Figure":
    """Draw the net energies of all methods over time, in one panel as in the paper."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.9)
        axes = figure.subplots()
        axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
        handles: list[Artist] = []
        for course in courses:
            look, (t, energy) = LOOKS[course.method], thin_extremes(course.t, course.energy_j, DRAWN)
            handles += axes.plot(t, energy, color=look.colour, ls=look.dashes, lw=0.9, label=course.label)
            if course.lost:
                axes.plot(t[-1], energy[-1], "x", color=LOST, ms=5, mew=1.2, zorder=6)
        if any(course.lost for course in courses):
            handles += axes.plot([], [], "x", color=LOST, ms=5, mew=1.2, label="loop lost")
        handles.append(axes.axvline(courses[0].from_s, color=MUTED, lw=0.6, ls=":", label="end of 2nd cycle"))
        axes.margins(x=0.01)
        label_panel(axes, "")
        axes.set_xlabel("Time [s]")
        axes.set_ylabel("Net energy input [J]")
        add_legend(figure, handles)
        return figure
