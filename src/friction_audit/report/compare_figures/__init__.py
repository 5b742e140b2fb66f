"""Comparison of compensation methods -> figures; the paper's Figs 13 and 14, the sweeps, and a summary."""

from friction_audit.report.compare_figures.energies import draw_energies
from friction_audit.report.compare_figures.loops import draw_loops
from friction_audit.report.compare_figures.summary import draw_summary
from friction_audit.report.compare_figures.sweeps import draw_sweeps
from friction_audit.report.compare_figures.trial import TrialCourse

__all__ = ["TrialCourse", "draw_energies", "draw_loops", "draw_summary", "draw_sweeps"]
