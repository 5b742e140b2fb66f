"""ArmDrift -> the axis of sessions and pairs of panels that figures share; changes of all joints; the control chart."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.errors import shortened
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.reporting import drift_words
from friction_audit.reporting.figures import panels
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.panels import add_legend, label_panel, mark_zero
from friction_audit.reporting.words import NOTHING, count_of, format_date, joint_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DrawPanel = Callable[["Axes", ArmDrift, JointDrift, CoefficientDrift], None]
REFERENCE, LEFT_OUT = theme.GREEN, theme.MUTED
MOST_MARKED = 150  # sessions in a panel above which markers would only be a blot; a line takes their place
MOST_TICKS = 6
MOST_LETTERS = 16  # of a name in a panel
COEFFICIENTS = ("coulomb_nm", "viscous_nms_per_rad")


def chosen_joints(arm: ArmDrift, joint: int | None) -> tuple[JointDrift, ...]:
    """Return one joint, given by its number, or with None all that have an estimate or a curve in some session.

    Raises:
        UsageError: If the arm does not have that joint.
    """
    chosen = panels.chosen_joints(arm.joints, joint)
    return chosen if joint is not None else tuple(one for one in chosen if _moves(arm, one)) or chosen


def _moves(arm: ArmDrift, joint: JointDrift) -> bool:
    curves = (one.curve for session in arm.sessions for one in session.joints if one.joint == joint.joint)
    estimated = any(math.isfinite(value.value) for found in joint.coefficients for value in found.values)
    return estimated or any(curve.speed_rad_s for curve in curves)


def label_sheet(figure: "Figure", arm: ArmDrift, drawn: Sequence[JointDrift], label: str) -> None:
    """Name the x axis of all panels, and below it the joints that are not drawn; ``drawn`` is one joint, or a sheet."""
    missing = [one.joint for one in arm.joints if one not in drawn]
    if missing and not panels.is_narrow(figure):
        label += f"\nnot drawn, for lack of any estimate: joint {write_joint_numbers(missing)}"
    figure.supxlabel(label)


def joint_name(joint: JointDrift) -> str:
    """Return what a panel calls a joint."""
    return f"joint {shortened(joint_label(joint.joint, joint.name), MOST_LETTERS)}"


def of_coefficient(joint: JointDrift, coefficient: str) -> CoefficientDrift | None:
    """Return what became of a coefficient, or None if it was not estimated."""
    return next((found for found in joint.coefficients if found.coefficient == coefficient), None)


def coefficient_title(coefficient: str) -> str:
    """Return the name of a coefficient as a label begins."""
    name = drift_words.NAMES[coefficient]
    return name[:1].upper() + name[1:]


def verdict_words(found: CoefficientDrift) -> str:
    """Return the verdict on a coefficient in the few words that fit above a panel."""
    word = drift_words.drift_verdict(found)
    if word != drift_words.DRIFT:
        return word
    if len(found.change_points) == 1:
        (change,) = found.change_points
        return f"{drift_words.format_change(change)} at session {change.session + 1}"
    return f"{drift_words.total_text(found)} in all" if drift_words.total_text(found) != NOTHING else drift_words.DRIFT


@theme.figure_style()
def draw_pairs(
    arm: ArmDrift,
    joint: int | None,
    draw_panel: DrawPanel,
    has: Callable[[CoefficientDrift], bool],
    legend: Sequence[str],
) -> "Figure":
    """Draw Coulomb above viscous friction of one joint over the sessions, or every joint on a sheet, a row for each.

    Args:
        arm: The arm.
        joint: Number of the joint, or None.
        draw_panel: Draws one coefficient of one joint.
        has: Whether there is something to draw of a coefficient.
        legend: Labels in the order in which they are read.
    """
    from matplotlib import rcParams

    rcParams["axes.titley"] = 1.0  # no panel has ticks above: to look for them takes a third of the time
    joints = chosen_joints(arm, joint)
    figure, rows = panels.pairs(len(joints), sheet=joint is None)
    for row, one in zip(rows, joints, strict=True):
        for axes, coefficient in zip(row, COEFFICIENTS, strict=True):
            second = joint is not None and coefficient != COEFFICIENTS[0]
            label_panel(axes, "" if second else joint_name(one))
            _number_sessions(axes, arm)
            found = of_coefficient(one, coefficient)
            axes.set_ylabel(coefficient_title(coefficient))
            if found is not None and has(found):
                draw_panel(axes, arm, one, found)
            else:
                axes.set_yticks([])
                panels.write_message(
                    axes, drift_words.headline(found, arm.sessions).partition(";")[0] if found else "not estimated"
                )
    add_legend(figure, legend)
    figure.align_ylabels()
    label_sheet(figure, arm, joints, session_label(arm))
    return figure


def _number_sessions(axes: "Axes", arm: ArmDrift) -> None:
    """Let an axis run over all sessions of an arm; ticks carry the number and, where known, the day or month."""
    places = tick_places(len(arm.sessions))
    axes.set_xlim(0.2, len(arm.sessions) + 0.8)
    dates = [format_date(arm.sessions[place - 1].start_s) for place in places]
    part = slice(None, 7) if len(_years(arm)) > 1 else slice(5, None)  # a tick has room for two of the three
    axes.set_xticks(
        places, [str(k) if date == NOTHING else f"{k}\n{date[part]}" for k, date in zip(places, dates, strict=True)]
    )


def tick_places(count: int) -> list[int]:
    """Return at most MOST_TICKS numbers from 1 to ``count``, evenly apart, the first among them."""
    return list(range(1, count + 1, max(1, -(-count // MOST_TICKS))))


def _years(arm: ArmDrift) -> set[str]:
    return {date[:4] for date in {format_date(session.start_s) for session in arm.sessions} - {NOTHING}}


def session_label(arm: ArmDrift) -> str:
    """Return the name of the axis of sessions."""
    years = _years(arm)
    if not years:
        return "Session"
    return "Session (year-month)" if len(years) > 1 else f"Session (month-day, {years.pop()})"


def shade_reference(axes: "Axes", arm: ArmDrift) -> None:
    """Shade each run of neighbouring sessions of the reference along the axis."""
    places = np.sort(np.array(arm.reference, np.int64)) + 1
    for run in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else ():
        look: theme.Look = {"facecolor": REFERENCE, "alpha": 0.12, "lw": 0, "zorder": 0, "label": "reference sessions"}
        axes.axvspan(run[0] - 0.5, run[-1] + 0.5, **look)


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
    joints = chosen_joints(arm, joint)
    figure = panels.new_figure(
        theme.SHEET_IN if joint is None else theme.COLUMN_IN, 0.85 + max(0.24 * len(joints), 0.6)
    )
    both = figure.subplots(1, 2, sharey=True)
    for axes, coefficient in zip(both, COEFFICIENTS, strict=True):
        label_panel(axes, coefficient_title(coefficient))
        axes.tick_params(axis="y", length=0)
        mark_zero(axes, x=True, y=False, lw=0.5, zorder=0)
        reach, undetectable = NARROWEST, [0.0]
        for place, one in enumerate(joints):
            found = of_coefficient(one, coefficient)
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
    both[0].set_yticks(range(len(joints)), [joint_name(one) for one in joints])
    both[0].set_ylim(len(joints) - 0.5, -0.5)
    add_legend(figure, [label for _, _, label in MARKS.values()])
    label_sheet(figure, arm, joints, "Change from the reference to the last sessions [%]")
    return figure


def _draw_change(axes: "Axes", place: int, found: CoefficientDrift) -> None:
    """Draw the change with its interval over what would not be detected."""
    if math.isfinite(found.smallest_drift):
        width = 200.0 * found.smallest_drift
        look: theme.Look = {"color": LEFT_OUT, "alpha": 0.18, "lw": 0, "label": UNDETECTABLE}
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
    return draw_pairs(arm, joint, _draw_chart, lambda found: bool(found.control), LEGEND)


def _draw_chart(axes: "Axes", arm: ArmDrift, _: JointDrift, found: CoefficientDrift) -> None:
    """Draw deviations and limits: in percent, or in the coefficient's unit near a level of zero."""
    control = found.control
    relative = any(math.isfinite(point.relative.value) for point in control)
    unit = "%" if relative else drift_words.UNITS[found.coefficient]
    axes.set_ylabel(f"{coefficient_title(found.coefficient)}\n[{unit}]")
    numbers = [point.relative if relative else point.deviation for point in control]
    scale = 100.0 if relative else 1.0
    value, low, high = (scale * np.array([getattr(one, end) for one in numbers]) for end in ("value", "low", "high"))
    place = np.array([point.session + 1 for point in control])
    outside = np.array([point.outside for point in control])
    words = f"{count_of(int(outside.sum()), 'session')} outside" if outside.any() else "all within"
    axes.set_title(words, loc="right", color=theme.FITTED if outside.any() else "black")
    shade_reference(axes, arm)
    many = len(place) > MOST_MARKED
    panels.band(axes, place, low, high, LEFT_OUT, LEGEND[0], step=None if many else "mid", alpha=0.16)
    mark_zero(axes, color=LEFT_OUT, lw=0.6)
    # A session with wide limits does not stretch the chart.
    bounds = np.concatenate([low, high])
    reach = FARTHEST * float(np.nanmedian(np.abs(bounds))) if np.isfinite(bounds).any() else 0.0
    reach = max(reach, float(np.nanmax(np.abs(value))))
    axes.set_ylim(panels.limits(value, np.clip(bounds, -reach, reach), near=math.inf, smallest=1e-9))
    line: theme.Look = {"lw": 0.7} if many else {"lw": 0.4, "marker": "o", "ms": 2.6, "mew": 0.0}
    axes.plot(place, value, color=theme.FILTERED, label=LEGEND[1], **line)
    if outside.any():
        mark: theme.Look = {"ls": "none", "marker": "s", "ms": 1.6 if many else 3.4, "mew": 0.0, "zorder": 4}
        axes.plot(place[outside], value[outside], color=theme.FITTED, label=LEGEND[2], **mark)
