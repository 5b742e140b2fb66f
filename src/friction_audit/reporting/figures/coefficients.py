"""Friction coefficients over time: a step at each cycle's end, where the estimate becomes known."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures.style import (
    FILTERED,
    FITTED,
    JointSeries,
    add_legend,
    all_series,
    figure_style,
    joint_series,
    label_panel,
    new_pairs,
    say_in_panel,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = ("Coulomb [N m]", "Viscous [N m s/rad]")
UNSETTLED = 10.0
"""Times the median width beyond which an interval says nothing, and neither does its value: early windows of one
speed. They do not stretch the panel."""
NEAR = 1.5
"""Times the range of the values and the whole-log interval that bands may reach beyond it; there they are cut."""
SMALLEST_SHARE, SMALLEST_RANGE = 0.02, 1e-6
"""Of the value, and of all: a panel is never higher resolved than that."""
WINDOW, BAND = "window", "95 %"


def draw_coefficients(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw one joint at column width, Coulomb above viscous, or every joint on a sheet, a row for each."""
    with figure_style():
        joints = all_series(estimate) if joint is None else (joint_series(estimate, joint),)
        figure, pairs = new_pairs(len(joints), sheet=joint is None)
        found = [_draw_joint(pair, series) for pair, series in zip(pairs, joints, strict=True)]
        handles = max(found, key=len)
        _name_window(handles, estimate.settings.friction.cycles_per_point, cut=any(map(_is_cut, figure.axes)))
        add_legend(figure, handles)
        figure.align_ylabels()
        figure.supxlabel("Time [s]", fontsize=7.5)
        return figure


def _draw_joint(pair: "tuple[Axes, Axes]", series: JointSeries) -> "list[Artist]":
    """Draw both coefficients of one joint; return the legend's entries."""
    friction, history = series.friction, series.friction.history
    coulomb = (history.coulomb_nm, history.coulomb_low_nm, history.coulomb_high_nm)
    viscous = (history.viscous_nms_per_rad, history.viscous_low_nms_per_rad, history.viscous_high_nms_per_rad)
    found: list[list[Artist]] = []
    rows = zip(pair, (coulomb, viscous), (friction.coulomb, friction.viscous), LABELS, strict=True)
    for axes, (value, low, high), whole, label in rows:
        found.append(_draw_coefficient(axes, history.stop_s, value, low, high, whole, end_s=float(series.t[-1])))
        axes.set_xlim(series.t[0], series.t[-1])
        label_panel(axes, series.title if axes is pair[0] else "")
        axes.set_ylabel(label)
        limits = y_limits(value, low, high, whole)
        if limits is not None:
            axes.set_ylim(*limits)
        if not found[-1]:
            axes.set_yticks([])
            say_in_panel(axes, series.not_determined or _absence(friction, label), characters=44)
    return max(found, key=len)


def y_limits(value: Float, low: Float, high: Float, whole: Coefficient) -> tuple[float, float] | None:
    """Return limits that show the values and the whole-log interval, and of the bands as much as is near.

    Args:
        value: Coefficient after each cycle, shape (m,); NaN where there is none.
        low: Lower end of its interval, shape (m,).
        high: Upper end, shape (m,).
        whole: The coefficient over the whole log.
    """
    with np.errstate(invalid="ignore"):
        width = high - low
        known = width[np.isfinite(width)]
        settled = ~(width > UNSETTLED * np.median(known)) if len(known) else np.isfinite(value)
    shown = np.concatenate([value[settled], [whole.value, whole.low, whole.high]])
    shown = shown[np.isfinite(shown)]
    if not len(shown):
        return None
    bottom, top = float(shown.min()), float(shown.max())
    reach = NEAR * max(top - bottom, SMALLEST_SHARE * abs(top), SMALLEST_RANGE)
    bands = np.concatenate([low, high, shown])
    inside = np.clip(bands[np.isfinite(bands)], bottom - reach, top + reach)
    margin = 0.05 * max(float(np.ptp(inside)), reach)
    return float(inside.min()) - margin, float(inside.max()) + margin


def _is_cut(axes: "Axes") -> bool:
    """Return True if a panel's bands go on beyond its limits."""
    bottom, top = axes.get_ylim()
    boxes = [band.get_datalim(axes.transData) for band in axes.collections]
    return any(box.y0 < bottom or box.y1 > top for box in boxes)


def _name_window(handles: "list[Artist]", cycles: int, *, cut: bool) -> None:
    """Say in the legend how many cycles a point is made of, and whether bands are cut off."""
    names = {WINDOW: "last cycle" if cycles == 1 else f"last {cycles} cycles", BAND: "95 %, cut at the edge"}
    for handle in handles:
        label = str(handle.get_label())
        if label == WINDOW or (label == BAND and cut):
            handle.set_label(names[label])


def _absence(friction: JointFriction, label: str) -> str:
    """Return why one coefficient is missing where the other is there."""
    fitted = friction.model == "combined" or label.lower().startswith(friction.model)
    return "not determined" if fitted else f"not in the {friction.model} model"


def _draw_coefficient(
    axes: "Axes", stop_s: Float, value: Float, low: Float, high: Float, whole: Coefficient, *, end_s: float
) -> "list[Artist]":
    """Draw one coefficient as steps with its band, and its whole-log value; return the legend's entries."""
    handles: list[Artist] = []
    if np.isfinite(value).any():
        # The last step holds until the log ends.
        t = np.append(stop_s, max(end_s, stop_s[-1]))
        middle, lower, upper = (np.append(column, column[-1]) for column in (value, low, high))
        handles += axes.step(t, middle, where="post", color=FILTERED, label=WINDOW)
        handles.append(axes.fill_between(t, lower, upper, step="post", color=FILTERED, alpha=0.22, lw=0, label=BAND))
    if np.isfinite(whole.value):
        handles.append(axes.axhline(whole.value, color=FITTED, lw=0.9, ls=(0, (4, 1.5)), label="whole log"))
    if np.isfinite(whole.low + whole.high):
        handles.append(axes.axhspan(whole.low, whole.high, color=FITTED, alpha=0.18, lw=0, label="95 %, whole log"))
    return handles
