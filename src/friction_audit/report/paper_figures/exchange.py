"""Fig. 3: net, kinetic and dissipated energy."""

from typing import TYPE_CHECKING

from friction_audit.joint_log import Float
from friction_audit.report.figures.layout import add_legend, new_figure
from friction_audit.report.figures.style import COLUMN_IN, DISSIPATED, FITTED, figure_style
from friction_audit.report.figures.thinning import thin_extremes
from friction_audit.report.paper_figures.course import Course
from friction_audit.report.paper_figures.panels import DRAWN, draw_energy

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_exchange(course: Course, kinetic_j: Float, dissipated_j: Float) -> "Figure":
    """Draw the net energy input and the two parts that it consists of.

    Args:
        course: The joint.
        kinetic_j: Its kinetic energy E_s, shape (n,). [J]
        dissipated_j: What friction dissipated, shape (n,). [J]
    """
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.4)
        axes = figure.subplots()
        handles = draw_energy(axes, course, "")
        parts = (
            (kinetic_j, FITTED, (0, (4, 1.5)), "kinetic $E_s$"),
            (dissipated_j, DISSIPATED, "-.", "dissipated $E_{dissp}$"),
        )
        for energy, colour, dashes, label in parts:
            handles += axes.plot(*thin_extremes(course.t, energy, DRAWN), color=colour, ls=dashes, label=label)
        for number, (end_s, end_j) in enumerate(zip(course.ends_s, course.ends_j, strict=True), start=1):
            axes.annotate(
                rf"$E^{number}_{{cyclic}}$",
                (end_s, end_j),
                (3, -10),
                textcoords="offset points",
                fontsize=6.5,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
            )
        axes.set_xlabel("Time [s]")
        add_legend(figure, handles)
        return figure
