"""Velocity and interaction torque over time."""

from typing import TYPE_CHECKING

from friction_audit.audit import Estimate
from friction_audit.joint_log import Float
from friction_audit.report.figures.joint_series import JointSeries, all_series, joint_series
from friction_audit.report.figures.layout import (
    add_legend,
    cycle_handles,
    label_panel,
    new_pairs,
    shade_cycles,
)
from friction_audit.report.figures.smoothing import cutoff_hz, median_rate_hz, smooth
from friction_audit.report.figures.style import FILTERED, RAW, figure_style
from friction_audit.report.figures.thinning import break_at_gaps, thin_extremes

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = ("Velocity [rad/s]", "Torque [N m]")
POINTS = 6000
"""Points of a curve: a page is 2100 dots wide at 300 dots per inch, so nothing can be lost."""
GAP_PERIODS = 20
"""Sampling periods without a sample after which no line is drawn."""


def draw_signals(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw one joint at column width, velocity above torque, or every joint on a sheet, a row for each."""
    with figure_style():
        joints = all_series(estimate) if joint is None else (joint_series(estimate, joint),)
        figure, pairs = new_pairs(len(joints), sheet=joint is None)
        found = [_draw_joint(pair, series) for pair, series in zip(pairs, joints, strict=True)]
        add_legend(figure, found[0] + cycle_handles(joints))
        figure.align_ylabels()
        figure.supxlabel("Time [s]", fontsize=7.5)
        return figure


def _draw_joint(pair: "tuple[Axes, Axes]", series: JointSeries) -> "list[Artist]":
    """Draw velocity and torque of one joint; return the legend's entries."""
    handles: list[Artist] = []
    for axes, signal, label in zip(pair, (series.dq, series.torque), LABELS, strict=True):
        shade_cycles(axes, series)
        handles = _draw_signal(axes, series.t, signal)
        axes.set_xlim(series.t[0], series.t[-1])
        label_panel(axes, series.title if axes is pair[0] else "")
        axes.set_ylabel(label)
    return handles


def _draw_signal(axes: "Axes", t: Float, signal: Float) -> "list[Artist]":
    """Draw a signal raw and filtered; return both curves."""
    longest_s = GAP_PERIODS / median_rate_hz(t)
    curves = (
        (signal, RAW, 0.5, "raw"),
        (smooth(t, signal), FILTERED, 0.7, f"filtered, {cutoff_hz(t):.3g} Hz"),
    )
    handles: list[Artist] = []
    for values, color, width, label in curves:
        stamps, kept = thin_extremes(t, values, POINTS)
        whole = break_at_gaps(stamps, kept, longest_s + 2 * (t[-1] - t[0]) / len(stamps))
        handles += axes.plot(stamps, whole, color=color, lw=width, label=label, rasterized=True)
    return handles
