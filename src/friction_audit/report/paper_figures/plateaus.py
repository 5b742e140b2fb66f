"""Fig. 9: interaction torque over velocity, with friction and with friction perfectly compensated."""

from typing import TYPE_CHECKING

from friction_audit.report.figures.layout import add_legend, label_panel, new_figure
from friction_audit.report.figures.style import COLUMN_IN, FILTERED, FITTED, MUTED, figure_style
from friction_audit.report.paper_figures.course import Course

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_plateaus(raw: Course, aided: Course) -> "Figure":
    """Draw both curves, dashed and solid as in the paper."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.5)
        axes = figure.subplots()
        axes.axhline(0.0, color=MUTED, lw=0.4)
        axes.axvline(0.0, color=MUTED, lw=0.4)
        dashed = axes.plot(
            raw.dq, raw.interaction_nm, color=FITTED, ls=(0, (4, 1.5)), lw=1.0, label="combined friction"
        )
        solid = axes.plot(aided.dq, aided.interaction_nm, color=FILTERED, lw=1.0, label="compensated")
        label_panel(axes, "")
        axes.set_xlabel("Velocity [rad/s]")
        axes.set_ylabel("Interaction torque [N m]")
        add_legend(figure, [*dashed, *solid])
        return figure
