"""Fig. 7: energies of an over-compensated joint, and the damping that keeps it passive."""

from typing import TYPE_CHECKING

from friction_audit.report.figures.layout import add_legend, new_figure
from friction_audit.report.figures.style import COLUMN_IN, FITTED, figure_style
from friction_audit.report.paper_figures.course import Course
from friction_audit.report.paper_figures.panels import draw_energy, draw_steps

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_overcompensation(bare: Course, guarded: Course) -> "Figure":
    """Draw the net energy without and with the passivity controller, and its damping."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 3.9)
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        handles = draw_energy(top, bare, "(a) without passivity controller")
        draw_energy(middle, guarded, "(b) with it")
        damping = ("damping_nms_per_rad", "Damping\n[N m s/rad]", FITTED)
        draw_steps(bottom, guarded, damping, "(c) adaptive damping")
        bottom.set_xlabel("Time [s]")
        add_legend(figure, handles)
        figure.align_ylabels()
        return figure
