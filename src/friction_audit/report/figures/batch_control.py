"""Control chart: each session's deviation from the reference, and the limits that a steady joint keeps to."""

import math
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.report import ArmDrift, ControlPoint, JointDrift
from friction_audit.joint_log import Float
from friction_audit.report.drift_words import coefficient_unit, count_of
from friction_audit.report.figures.batch_look import (
    COEFFICIENTS,
    ESTIMATE,
    LEFT_OUT,
    MOST_MARKED,
    OUTSIDE,
    REFERENCE,
    coefficient_title,
    draw_pairs,
    joint_name,
    number_sessions,
    of_coefficient,
    shade_reference,
)
from friction_audit.report.figures.layout import is_narrow, label_panel, say_in_panel

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INSIDE, OUT, LIMITS, BASELINE = "within the limits", "outside", "limits of a steady joint", "reference sessions"
LEGEND = (INSIDE, OUT, LIMITS, BASELINE)
FARTHEST = 2.0
"""Times the median limit that limits may stretch a panel; those of sessions that tell little are cut there."""


def draw_control(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, Coulomb above viscous, or every joint on a sheet, a row for each."""
    return draw_pairs(arm, joint, _draw_panel, LEGEND)


def _draw_panel(axes: "Axes", arm: ArmDrift, joint: JointDrift, coefficient: str) -> "list[Artist]":
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
