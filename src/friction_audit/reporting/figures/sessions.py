"""What the figures of an arm over its sessions share: which joints, the axis of sessions, pairs of panels."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.errors import shortened
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.reporting import drift_words
from friction_audit.reporting.figures import panels
from friction_audit.reporting.figures.panels import add_legend, is_narrow, label_panel, pairs, write_message
from friction_audit.reporting.figures.style import GREEN, MUTED, Look, figure_style
from friction_audit.reporting.words import NOTHING, format_date, joint_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DrawPanel = Callable[["Axes", ArmDrift, JointDrift, CoefficientDrift], None]
REFERENCE, LEFT_OUT = GREEN, MUTED
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
    if missing and not is_narrow(figure):
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


@figure_style()
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
    figure, rows = pairs(len(joints), sheet=joint is None)
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
                write_message(
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
        places,
        [str(k) if date == NOTHING else f"{k}\n{date[part]}" for k, date in zip(places, dates, strict=True)],
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
        look: Look = {"facecolor": REFERENCE, "alpha": 0.12, "lw": 0, "zorder": 0, "label": "reference sessions"}
        axes.axvspan(run[0] - 0.5, run[-1] + 0.5, **look)
