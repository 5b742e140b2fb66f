"""Fig. 14: velocity against interaction torque, method by method."""

from collections.abc import Sequence
from math import ceil
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.report.compare_figures.look import LOOKS, LOST
from friction_audit.report.compare_figures.trial import TrialCourse
from friction_audit.report.figures.layout import label_panel, new_figure
from friction_audit.report.figures.smoothing import smooth
from friction_audit.report.figures.style import COLUMN_IN, MUTED, figure_style
from friction_audit.report.figures.thinning import every_nth

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DRAWN = 3000
ACROSS = 3
LONGEST_TITLE = 16
"""Characters above a panel."""
GROUND = "#c8c8c8"
"""Colour of what every method is held against."""


def draw_loops(courses: Sequence[TrialCourse], joint: int) -> "Figure":
    """Draw a panel for every method, the first one's curve in the background of all others.

    Args:
        courses: The methods, after the second cycle; the first is no compensation.
        joint: Number of the joint.
    """
    rows = ceil(len(courses) / ACROSS)
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 0.3 + 1.3 * rows)
        panels = figure.subplots(rows, min(ACROSS, len(courses)), squeeze=False, sharex=True, sharey=True)
        for axes, course in zip(panels.flat, courses, strict=False):
            if course is not courses[0]:
                axes.plot(*_curve(courses[0]), color=GROUND, lw=0.5, zorder=1)
            axes.plot(*_curve(course), color=LOOKS[course.method].colour, lw=0.6, zorder=2)
            _finish(axes, course)
        for axes in panels.flat[len(courses) :]:
            axes.set_visible(False)
        for column in range(panels.shape[1]):
            panels.flat[max(n for n in range(len(courses)) if n % panels.shape[1] == column)].tick_params(
                labelbottom=True
            )
        figure.supxlabel(f"Velocity of joint {joint} [rad/s]", fontsize=7.5)
        figure.supylabel("Interaction torque [N m]", fontsize=7.5)
        return figure


def _finish(axes: "Axes", course: TrialCourse) -> None:
    axes.axhline(0.0, color=MUTED, lw=0.3, zorder=0)
    axes.axvline(0.0, color=MUTED, lw=0.3, zorder=0)
    label_panel(axes, fill(course.label, LONGEST_TITLE), across=3)
    if course.lost:
        axes.text(0.04, 0.96, "loop lost", transform=axes.transAxes, va="top", fontsize=6.5, color=LOST)


def _curve(course: TrialCourse) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and torque after the second cycle, filtered for the eye as in the paper."""
    part = course.t >= course.from_s
    if not part.any():
        return np.empty(0), np.empty(0)
    t = course.t[part]
    thin = every_nth(len(t), DRAWN)
    return smooth(t, course.dq[part])[thin], smooth(t, course.interaction_nm[part])[thin]
