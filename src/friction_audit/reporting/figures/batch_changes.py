"""All joints at a glance: how much each coefficient changed, and how small a change would have been seen."""

import math
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, ControlPoint, JointDrift
from friction_audit.joint_log import Float
from friction_audit.reporting.drift_words import (
    DRIFT,
    STEADY,
    TEMPERATURE,
    UNTESTED,
    coefficient_unit,
    drift_verdict,
    total_text,
)
from friction_audit.reporting.figures.batch_look import (
    COEFFICIENTS,
    ESTIMATE,
    LEFT_OUT,
    MOST_MARKED,
    OUTSIDE,
    REFERENCE,
    chosen_joints,
    coefficient_title,
    draw_pairs,
    in_order,
    joint_name,
    name_joints_left_out,
    number_sessions,
    of_coefficient,
    shade_reference,
)
from friction_audit.reporting.figures.style import (
    COLUMN_IN,
    DISSIPATED,
    MUTED,
    SHEET_IN,
    add_legend,
    figure_style,
    is_narrow,
    label_panel,
    new_figure,
    say_in_panel,
)
from friction_audit.reporting.words import NOTHING, count_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


HEAD_IN, ROW_IN, LEAST_IN = 0.85, 0.24, 0.6
UNSEEN = "too small to be seen, at 90 % power"
MARKS = {
    DRIFT: (OUTSIDE, "s", "changed"),
    TEMPERATURE: (DISSIPATED, "^", "changes with temperature"),
    STEADY: (ESTIMATE, "o", "no drift found"),
}
"""Colour, marker and label of each verdict that comes with a change."""
LEGEND = (*(label for _, _, label in MARKS.values()), UNSEEN)
NARROWEST = 5.0
"""Percent either side of no change that a panel shows at least."""
FARTHEST = 2.0
"""Times the changes and their intervals that a bar of what cannot be seen may stretch a panel; there it is cut."""
ROOM = 1.15


def draw_changes(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a line for each; Coulomb beside viscous."""
    with figure_style():
        joints = chosen_joints(arm, joint)
        height = HEAD_IN + max(ROW_IN * len(joints), LEAST_IN)
        figure = new_figure(SHEET_IN if joint is None else COLUMN_IN, height)
        panels = figure.subplots(1, 2, sharey=True, squeeze=False)[0]
        handles: list[Artist] = []
        for axes, coefficient in zip(panels, COEFFICIENTS, strict=True):
            handles += _draw_panel(axes, joints, coefficient)
        panels[0].set_yticks(range(len(joints)), [joint_name(one) for one in joints])
        panels[0].set_ylim(len(joints) - 0.5, -0.5)
        add_legend(figure, in_order(handles, LEGEND))
        figure.supxlabel("Change from the reference to the last sessions [%]", fontsize=7.5)
        if joint is None:
            name_joints_left_out(figure, arm, joints)
        return figure


def _draw_panel(axes: "Axes", joints: tuple[JointDrift, ...], coefficient: str) -> "list[Artist]":
    """Draw one coefficient of all joints; return the legend's entries."""
    label_panel(axes, coefficient_title(coefficient))
    axes.tick_params(axis="y", length=0)
    axes.axvline(0.0, color=MUTED, lw=0.5, zorder=0)
    handles: list[Artist] = []
    reach, unseen = NARROWEST, [0.0]
    for place, joint in enumerate(joints):
        found = of_coefficient(joint, coefficient)
        if found is None or math.isnan(found.total.value) or drift_verdict(found) == UNTESTED:
            _say(axes, place, found)
            continue
        handles += _draw_row(axes, place, found)
        ends = (found.total.low, found.total.high, found.total.value)
        reach = max(reach, *(100.0 * abs(end) for end in ends if math.isfinite(end)))
        unseen.append(100.0 * found.smallest_drift)
    reach = max(reach, *(min(one, FARTHEST * reach) for one in unseen if math.isfinite(one)))
    axes.set_xlim(-ROOM * reach, ROOM * reach)
    return handles


def _draw_row(axes: "Axes", place: int, found: CoefficientDrift) -> "list[Artist]":
    """Draw the change with its interval over what could not have been seen."""
    handles: list[Artist] = []
    if math.isfinite(found.smallest_drift):
        width = 200.0 * found.smallest_drift
        bar = axes.barh(place, width, left=-width / 2, height=0.7, color=LEFT_OUT, alpha=0.18, lw=0, label=UNSEEN)
        handles.append(bar.patches[0])
        bar.patches[0].set_label(UNSEEN)
    colour, marker, label = MARKS[drift_verdict(found)]
    axes.hlines(place, 100.0 * found.total.low, 100.0 * found.total.high, color=colour, lw=1.0)
    handles += axes.plot(
        100.0 * found.total.value, place, color=colour, marker=marker, ms=3.8, mew=0.0, ls="none", label=label
    )
    return handles


def _say(axes: "Axes", place: int, found: CoefficientDrift | None) -> None:
    """Write into the line why there is no percentage."""
    words = "not testable" if found is None else total_text(found)
    text = drift_verdict(found) if found is not None and words == NOTHING else words
    axes.annotate(
        text, (0.02, place), xycoords=("axes fraction", "data"), va="center", ha="left", fontsize=6.5, color=MUTED
    )


INSIDE, OUT, LIMITS, BASELINE = "within the limits", "outside", "limits of a steady joint", "reference sessions"
LEGEND_BATCH_CONTROL = (INSIDE, OUT, LIMITS, BASELINE)


def draw_control(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, Coulomb above viscous, or every joint on a sheet, a row for each."""
    return draw_pairs(arm, joint, _draw_panel_batch_control, LEGEND_BATCH_CONTROL)


def _draw_panel_batch_control(axes: "Axes", arm: ArmDrift, joint: JointDrift, coefficient: str) -> "list[Artist]":
    """Draw one coefficient of one joint; return the legend's entries."""
    first = coefficient == COEFFICIENTS[0]
    label_panel(axes, "" if is_narrow(axes.get_figure(root=True)) and not first else joint_name(joint))
    number_sessions(axes, arm)
    found = of_coefficient(joint, coefficient)
    control = found.control if found else ()
    relative = any(math.isfinite(point.relative.value) for point in control)
    unit = "%" if relative else coefficient_unit(coefficient)
    axes.set_ylabel(f"{coefficient_title(coefficient)}\n[{unit}]")
    if not control:
        axes.set_yticks([])
        say_in_panel(axes, found.message.partition(";")[0] if found else "not estimated", characters=44)
        return []
    outside = sum(point.outside for point in control)
    words = f"{count_of(outside, 'session')} outside" if outside else "all within"
    axes.set_title(words, loc="right", color=OUTSIDE if outside else "black")
    shade_reference(axes, [k + 1.0 for k in arm.reference])
    return _draw_points(axes, control, relative=relative)


def _draw_points(axes: "Axes", control: tuple[ControlPoint, ...], *, relative: bool) -> "list[Artist]":
    """Draw deviations and limits; return the legend's entries."""
    from matplotlib.patches import Patch

    place = np.array([point.session + 1 for point in control])
    numbers = [point.relative if relative else point.deviation for point in control]
    scale = 100.0 if relative else 1.0
    value, low, high = (scale * np.array([getattr(one, end) for one in numbers]) for end in ("value", "low", "high"))
    outside = np.array([point.outside for point in control])
    many = len(place) > MOST_MARKED
    band = axes.fill_between(
        place, low, high, step=None if many else "mid", color=LEFT_OUT, alpha=0.16, lw=0, label=LIMITS
    )
    axes.axhline(0.0, color=LEFT_OUT, lw=0.6)
    axes.set_ylim(*chart_limits(value, low, high))
    line = {"lw": 0.7} if many else {"lw": 0.4, "marker": "o", "ms": 2.6, "mew": 0.0}
    handles: list[Artist] = [band, *axes.plot(place, value, color=ESTIMATE, label=INSIDE, **line)]
    if outside.any():
        mark = {"ls": "none", "marker": "s", "ms": 1.6 if many else 3.4, "mew": 0.0}
        handles += axes.plot(place[outside], value[outside], color=OUTSIDE, label=OUT, zorder=4, **mark)  # type: ignore[arg-type]
    return [*handles, Patch(facecolor=REFERENCE, alpha=0.25, lw=0, label=BASELINE)]


def chart_limits(value: Float, low: Float, high: Float) -> tuple[float, float]:
    """Return the ends of a panel that shows all deviations, and the limits of the usual sessions."""
    limits = np.abs(np.concatenate([low, high]))
    limits = limits[np.isfinite(limits)]
    reach = max(FARTHEST * float(np.median(limits)) if len(limits) else 0.0, float(np.nanmax(np.abs(value))))
    ends = np.concatenate([value, low, high])
    inside = np.clip(ends[np.isfinite(ends)], -reach, reach)
    margin = 0.06 * max(float(np.ptp(inside)), 1e-9)
    return float(inside.min()) - margin, float(inside.max()) + margin
