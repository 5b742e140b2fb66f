"""Fig. 6: net energy above the estimated coefficient."""

from typing import TYPE_CHECKING

from friction_audit.joint_log import Float
from friction_audit.report.figures.layout import add_legend, new_figure
from friction_audit.report.figures.style import COLUMN_IN, FILTERED, FITTED, figure_style
from friction_audit.report.figures.thinning import thin_extremes
from friction_audit.report.paper_figures.course import Course
from friction_audit.report.paper_figures.panels import DRAWN, draw_energy, draw_steps

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_adaptation(course: Course, viscous_nms_per_rad: Float) -> "Figure":
    """Draw the net energy and the coefficient beside the true one, shape (n,). [N m s/rad]"""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 3.0)
        above, below = figure.subplots(2, 1, sharex=True)
        handles = draw_energy(above, course, "(a)")
        label = "Viscous\n[N m s/rad]"
        true = below.plot(
            *thin_extremes(course.t, viscous_nms_per_rad, DRAWN), color=FITTED, ls=(0, (4, 1.5)), label="true friction"
        )
        (curve,) = draw_steps(below, course, ("viscous_nms_per_rad", label, FILTERED), "(b)")
        curve.set_label("compensated")
        below.set_xlabel("Time [s]")
        add_legend(figure, [*handles, *true, curve])
        figure.align_ylabels()
        return figure
