"""ArmDrift -> the change of all joints with the smallest one that would be detected, and the control chart."""

import math
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.reporting import drift_words
from friction_audit.reporting.figures import sessions as over_sessions
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.panels import add_legend, band, label_panel, limits, mark_zero, new_figure
from friction_audit.reporting.words import NOTHING, count_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKS = {
    drift_words.DRIFT: (theme.FITTED, "s", "changed"),
    drift_words.TEMPERATURE: (theme.DISSIPATED, "^", "changes with temperature"),
    drift_words.STEADY: (theme.FILTERED, "o", "no drift found"),
}  # colour, marker and label of each verdict that comes with a change
UNDETECTABLE = "not detectable with 90 % power"
NARROWEST = 5.0  # percent either side of no change that a panel shows at least
FARTHEST = 2.0  # times the changes and their intervals that the undetectable may stretch a panel; there it is cut


@theme.figure_style()
def draw_changes(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a line for each; Coulomb next to viscous."""
    joints = over_sessions.chosen_joints(arm, joint)
    figure = new_figure(theme.SHEET_IN if joint is None else theme.COLUMN_IN, 0.85 + max(0.24 * len(joints), 0.6))
    panels = figure.subplots(1, 2, sharey=True)
    for axes, coefficient in zip(panels, over_sessions.COEFFICIENTS, strict=True):
        label_panel(axes, over_sessions.coefficient_title(coefficient))
        axes.tick_params(axis="y", length=0)
        mark_zero(axes, x=True, y=False, lw=0.5, zorder=0)
        reach, undetectable = NARROWEST, [0.0]
        for place, one in enumerate(joints):
            found = over_sessions.of_coefficient(one, coefficient)
            if (
                found is None
                or math.isnan(found.total.value)
                or drift_words.drift_verdict(found) == drift_words.UNTESTED
            ):
                _write_reason(axes, place, found)
                continue
            _draw_change(axes, place, found)
            ends = (found.total.low, found.total.high, found.total.value)
            reach = max(reach, *(100.0 * abs(end) for end in ends if math.isfinite(end)))
            undetectable.append(100.0 * found.smallest_drift)
        reach = max(reach, *(min(one, FARTHEST * reach) for one in undetectable if math.isfinite(one)))
        axes.set_xlim(-1.15 * reach, 1.15 * reach)
    panels[0].set_yticks(range(len(joints)), [over_sessions.joint_name(one) for one in joints])
    panels[0].set_ylim(len(joints) - 0.5, -0.5)
    add_legend(figure, [label for _, _, label in MARKS.values()])
    over_sessions.label_sheet(figure, arm, joints, "Change from the reference to the last sessions [%]")
    return figure


def _draw_change(axes: "Axes", place: int, found: CoefficientDrift) -> None:
    """Draw the change with its interval over what would not be detected."""
    if math.isfinite(found.smallest_drift):
        width = 200.0 * found.smallest_drift
        look: theme.Look = {"color": over_sessions.LEFT_OUT, "alpha": 0.18, "lw": 0, "label": UNDETECTABLE}
        axes.barh(place, width, left=-width / 2, height=0.7, **look)
    colour, marker, label = MARKS[drift_words.drift_verdict(found)]
    axes.hlines(place, 100.0 * found.total.low, 100.0 * found.total.high, color=colour, lw=1.0)
    look = {"color": colour, "marker": marker, "ms": 3.8, "mew": 0.0, "ls": "none", "label": label}
    axes.plot(100.0 * found.total.value, place, **look)


def _write_reason(axes: "Axes", place: int, found: CoefficientDrift | None) -> None:
    """Write into the line why there is no percentage."""
    words = "not testable" if found is None else drift_words.total_text(found)
    text = drift_words.drift_verdict(found) if found is not None and words == NOTHING else words
    axes.annotate(text, (0.02, place), xycoords=("axes fraction", "data"), va="center", fontsize=6.5, color=theme.MUTED)


LEGEND = ("limits of a steady joint", "within the limits", "outside", "reference sessions")


def draw_control(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw the control chart of one joint at column width, or of every joint on a sheet, a row for each."""
    return over_sessions.draw_pairs(arm, joint, _draw_chart, lambda found: bool(found.control), LEGEND)


def _draw_chart(axes: "Axes", arm: ArmDrift, _: JointDrift, found: CoefficientDrift) -> None:
    """Draw deviations and limits: in percent, or in the coefficient's unit near a level of zero."""
    control = found.control
    relative = any(math.isfinite(point.relative.value) for point in control)
    unit = "%" if relative else drift_words.UNITS[found.coefficient]
    axes.set_ylabel(f"{over_sessions.coefficient_title(found.coefficient)}\n[{unit}]")
    numbers = [point.relative if relative else point.deviation for point in control]
    scale = 100.0 if relative else 1.0
    value, low, high = (scale * np.array([getattr(one, end) for one in numbers]) for end in ("value", "low", "high"))
    place = np.array([point.session + 1 for point in control])
    outside = np.array([point.outside for point in control])
    words = f"{count_of(int(outside.sum()), 'session')} outside" if outside.any() else "all within"
    axes.set_title(words, loc="right", color=theme.FITTED if outside.any() else "black")
    over_sessions.shade_reference(axes, arm)
    many = len(place) > over_sessions.MOST_MARKED
    band(axes, place, low, high, over_sessions.LEFT_OUT, LEGEND[0], step=None if many else "mid", alpha=0.16)
    mark_zero(axes, color=over_sessions.LEFT_OUT, lw=0.6)
    # A session with wide limits does not stretch the chart.
    bounds = np.concatenate([low, high])
    reach = FARTHEST * float(np.nanmedian(np.abs(bounds))) if np.isfinite(bounds).any() else 0.0
    reach = max(reach, float(np.nanmax(np.abs(value))))
    axes.set_ylim(limits(value, np.clip(bounds, -reach, reach), near=math.inf, smallest=1e-9))
    line: theme.Look = {"lw": 0.7} if many else {"lw": 0.4, "marker": "o", "ms": 2.6, "mew": 0.0}
    axes.plot(place, value, color=theme.FILTERED, label=LEGEND[1], **line)
    if outside.any():
        mark: theme.Look = {"ls": "none", "marker": "s", "ms": 1.6 if many else 3.4, "mew": 0.0, "zorder": 4}
        axes.plot(place[outside], value[outside], color=theme.FITTED, label=LEGEND[2], **mark)
