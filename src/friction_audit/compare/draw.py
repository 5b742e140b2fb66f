"""Comparison -> figures."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.compare.method import PAPER
from friction_audit.compare.methods import NONE
from friction_audit.compare.result import Comparison, Row
from friction_audit.compare.told import tell_curves, tell_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from friction_audit.report.compare_figures import TrialCourse

FIGURES = ("energy", "velocity-torque", "sweep", "summary")
"""Names of the figures; the first two are the paper's Figs 13 and 14."""


def draw(comparison: Comparison) -> "dict[str, Figure]":
    """Return the figures by name; those that have nothing to show are left out."""
    from friction_audit.report.compare_figures import draw_energies, draw_loops, draw_summary, draw_sweeps

    shown = [row for row in comparison.rows if row.role == PAPER]
    joint = _most_loaded(shown[0])
    courses = [_show(row, joint) for row in shown]
    figures = {"energy": draw_energies(courses), "velocity-torque": draw_loops(courses, joint + 1)}
    if comparison.curves:
        none = comparison.row(NONE, PAPER)
        slope = none.interval(lambda outcome: outcome.energy_slope_w).value if none is not None else float("nan")
        figures["sweep"] = draw_sweeps(tell_curves(comparison), slope)
    figures["summary"] = draw_summary(tell_rows(comparison))
    return figures


def _most_loaded(row: Row) -> int:
    """Return the column of the joint that takes most torque to move."""
    return int(np.argmax((row.course.interaction_nm**2).mean(axis=0)))


def _show(row: Row, joint: int) -> "TrialCourse":
    from friction_audit.report.compare_figures import TrialCourse

    course = row.course
    return TrialCourse(
        method=row.method,
        label=row.label,
        t=course.t,
        dq=course.dq[:, joint],
        interaction_nm=course.interaction_nm[:, joint],
        energy_j=course.energy_j,
        from_s=course.from_s,
        lost=bool(np.isfinite(course.lost_s)),
    )
