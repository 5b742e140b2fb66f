"""What the figures of a batch share: their style, which joints, the axis of sessions, colours."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.errors import UsageError, shortened
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.reporting.drift_words import DRIFT, coefficient_name, drift_verdict, format_change, total_text
from friction_audit.reporting.figures.style import (
    DISSIPATED,
    FILTERED,
    FITTED,
    MUTED,
    add_legend,
    figure_style,
    new_pairs,
)
from friction_audit.reporting.words import NOTHING, format_date, joint_label

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DrawPanel = Callable[["Axes", ArmDrift, JointDrift, str], "list[Artist]"]
"""Draws one coefficient of one joint; returns the legend's entries."""
ESTIMATE = FILTERED
LEVEL = FITTED
CHANGE = FITTED
REFERENCE = "#009e73"
LEFT_OUT = MUTED
OUTSIDE = FITTED
FIRST, LAST = DISSIPATED, FILTERED
MOST_MARKED = 150
"""Sessions in a panel above which markers would only be a blot; a line takes their place."""
MOST_TICKS = 6
COEFFICIENTS = ("coulomb_nm", "viscous_nms_per_rad")
LONGEST_NAME = 16
"""Characters of a name that a panel has room for."""


def chosen_joints(arm: ArmDrift, joint: int | None) -> tuple[JointDrift, ...]:
    """Return one joint, given by its number for people, or with None all that there is something to draw of.

    Raises:
        UsageError: If the arm does not have that joint.
    """
    if joint is None:
        return tuple(one for one in arm.joints if not is_silent(arm, one)) or arm.joints
    chosen = tuple(one for one in arm.joints if one.joint == joint)
    if not chosen:
        held = ", ".join(str(one.joint) for one in arm.joints)
        raise UsageError(f"joint {joint}: not in this result, which holds {held}; choose one of them")
    return chosen


def is_silent(arm: ArmDrift, joint: JointDrift) -> bool:
    """Return whether a joint has neither an estimate nor a curve in any session: it never moved."""
    estimated = any(math.isfinite(value.value) for found in joint.coefficients for value in found.values)
    curves = (one.curve for session in arm.sessions for one in session.joints if one.joint == joint.joint)
    return not estimated and not any(curve.speed_rad_s for curve in curves)


def name_joints_left_out(figure: "Figure", arm: ArmDrift, drawn: Sequence[JointDrift]) -> None:
    """Say below a sheet which joints are not on it, where some are not."""
    missing = [one.joint for one in arm.joints if one not in drawn]
    if missing:
        below = figure.get_supxlabel()
        figure.supxlabel(
            f"{below}\nnot drawn, for lack of any estimate: joint {write_joint_numbers(missing)}", fontsize=7.5
        )


def joint_name(joint: JointDrift) -> str:
    """Return what a panel calls a joint."""
    return f"joint {shortened(joint_label(joint.joint, joint.name), LONGEST_NAME)}"


def verdict_words(found: CoefficientDrift) -> str:
    """Return the verdict on a coefficient in the few words that fit above a panel."""
    word = drift_verdict(found)
    if word != DRIFT:
        return word
    if len(found.change_points) == 1:
        (change,) = found.change_points
        return f"{format_change(change.relative, change.after, change.before)} at session {change.session + 1}"
    return f"{total_text(found)} in all" if total_text(found) != NOTHING else DRIFT


def of_coefficient(joint: JointDrift, coefficient: str) -> CoefficientDrift | None:
    """Return what became of a coefficient, or None if nothing is said of it."""
    return next((found for found in joint.coefficients if found.coefficient == coefficient), None)


def coefficient_title(coefficient: str) -> str:
    """Return the name of a coefficient as a label begins."""
    name = coefficient_name(coefficient)
    return name[:1].upper() + name[1:]


def number_sessions(axes: "Axes", arm: ArmDrift) -> None:
    """Let an axis run over all sessions of an arm; ticks carry the number and, where known, the day."""
    count = len(arm.sessions)
    places = tick_places(count)
    axes.set_xlim(0.2, count + 0.8)
    several_years = len(_years(arm)) > 1
    axes.set_xticks(places, [_tick(arm, place, several_years=several_years) for place in places])


def tick_places(count: int) -> list[int]:
    """Return at most MOST_TICKS numbers from 1 to ``count``, evenly apart, the first among them."""
    if count <= 0:
        return []
    step = max(1, -(-count // MOST_TICKS))
    return list(range(1, count + 1, step))


def _tick(arm: ArmDrift, place: int, *, several_years: bool) -> str:
    date = format_date(arm.sessions[place - 1].start_s)
    # A tick has room for two of the three.
    short = date[:7] if several_years else date[5:]
    return str(place) if date == NOTHING else f"{place}\n{short}"


def _years(arm: ArmDrift) -> set[str]:
    dates = {format_date(session.start_s) for session in arm.sessions}
    return {date[:4] for date in dates - {NOTHING}}


def session_label(arm: ArmDrift) -> str:
    """Return the name of the axis of sessions."""
    years = _years(arm)
    if not years:
        return "Session"
    return "Session (year-month)" if len(years) > 1 else f"Session (month-day, {years.pop()})"


def name_axis(figure: "Figure", label: str) -> None:
    """Write one name below all panels."""
    figure.align_ylabels()
    figure.supxlabel(label, fontsize=7.5)


def shade_reference(axes: "Axes", places: Sequence[float]) -> None:
    """Shade each run of neighbouring sessions of the reference along the axis."""
    for low, high in runs(places):
        axes.axvspan(low - 0.5, high + 0.5, facecolor=REFERENCE, alpha=0.12, lw=0, zorder=0)


def draw_pairs(arm: ArmDrift, joint: int | None, draw_panel: DrawPanel, legend: Sequence[str]) -> "Figure":
    """Draw one joint at column width, Coulomb above viscous, or every joint on a sheet, a row for each."""
    from matplotlib import rcParams

    with figure_style():
        rcParams["axes.titley"] = 1.0  # no panel has ticks above: to look for them takes a third of the time
        joints = chosen_joints(arm, joint)
        figure, pairs = new_pairs(len(joints), sheet=joint is None)
        handles: list[Artist] = []
        for pair, one in zip(pairs, joints, strict=True):
            for axes, coefficient in zip(pair, COEFFICIENTS, strict=True):
                handles += draw_panel(axes, arm, one, coefficient)
        add_legend(figure, in_order(handles, legend))
        name_axis(figure, session_label(arm))
        if joint is None:
            name_joints_left_out(figure, arm, joints)
        return figure


def in_order(handles: "Sequence[Artist]", labels: Sequence[str]) -> "list[Artist]":
    """Return the entries of a legend, each label once, in the order of ``labels``."""
    first = {str(handle.get_label()): handle for handle in reversed(handles)}
    return [first[label] for label in labels if label in first]


def runs(places: Sequence[float]) -> list[tuple[float, float]]:
    """Return the first and last of each run of whole numbers without a gap."""
    found: list[tuple[float, float]] = []
    for place in sorted(places):
        if found and place - found[-1][1] <= 1.0:
            found[-1] = (found[-1][0], place)
        else:
            found.append((place, place))
    return found
