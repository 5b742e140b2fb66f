"""Velocity-torque curves of the first session, of the reference and of the last session on one another."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting.drawn_arm import curve_sessions
from friction_audit.reporting.drift_words import coefficient_unit
from friction_audit.reporting.figures.batch_look import (
    CHANGE,
    COEFFICIENTS,
    ESTIMATE,
    FIRST,
    LAST,
    LEFT_OUT,
    LEVEL,
    MOST_MARKED,
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
    verdict_words,
)
from friction_audit.reporting.figures.diagnose_look import draw_grid
from friction_audit.reporting.figures.style import add_legend, figure_style, is_narrow, label_panel, say_in_panel

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


HEIGHT_IN = {True: 1.45, False: 2.4}
"""Height of a panel on a sheet and alone. [in]"""
ACROSS = 4
SPREAD = "range of the reference"
FEWEST_POINTS = 2


class Mean(NamedTuple):
    """Curves of several sessions in one: mean, smallest and largest torque at each speed, each of shape (m,)."""

    speed: Float
    torque: Float
    low: Float
    high: Float


def draw_curves(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet."""
    with figure_style():
        joints = chosen_joints(arm, joint)
        sheet = joint is None

        def panel(one: JointDrift) -> "Callable[[Axes], list[Artist]]":
            return lambda axes: _draw_panel(axes, arm, one)

        heights = [HEIGHT_IN[sheet]] * len(joints)
        figure, handles = draw_grid([panel(one) for one in joints], heights, sheet=sheet, across=ACROSS)
        labels = [label for label, _ in _names(arm)]
        add_legend(figure, in_order(handles, [*labels, SPREAD]))
        figure.supxlabel("Velocity [rad/s]", fontsize=7.5)
        if sheet:
            name_joints_left_out(figure, arm, joints)
        figure.supylabel("Interaction torque [N m]", fontsize=7.5)
        return figure


def _names(arm: ArmDrift) -> list[tuple[str, tuple[int, ...]]]:
    """Return what each curve is called, and the sessions that it is made of."""
    drawn = curve_sessions(arm)
    if drawn is None:
        return []
    first, reference, last = drawn
    return [
        (f"first (session {first + 1})", (first,)),
        (f"reference (mean of {len(reference)})", reference),
        (f"last (session {last + 1})", (last,)),
    ]


def _draw_panel(axes: "Axes", arm: ArmDrift, joint: JointDrift) -> "list[Artist]":
    """Draw the curves of one joint; return the legend's entries."""
    label_panel(axes, joint_name(joint))
    looks = ((FIRST, ":", 1.3), (REFERENCE, "-", 1.0), (LAST, (0, (4, 1.5)), 1.1))
    handles: list[Artist] = []
    for (label, sessions), (colour, dash, width) in zip(_names(arm), looks, strict=False):
        mean = mean_curve([curve_of(arm, session, joint.joint) for session in sessions])
        if mean is None:
            continue
        if len(sessions) > 1:
            band = axes.fill_between(mean.speed, mean.low, mean.high, color=colour, alpha=0.2, lw=0, label=SPREAD)
            handles.append(band)
        handles += axes.plot(mean.speed, mean.torque, color=colour, ls=dash, lw=width, label=label)
    if not handles:
        axes.set_xticks([])
        axes.set_yticks([])
        say_in_panel(axes, "no session moves this joint", characters=36)
        return []
    for line in (axes.axhline, axes.axvline):
        line(0.0, color="0.6", lw=0.3, zorder=0)
    return handles


def curve_of(arm: ArmDrift, session: int, joint: int) -> SpeedCurve:
    """Return the curve of a joint in a session; an empty one if there is none."""
    return next((one.curve for one in arm.sessions[session].joints if one.joint == joint), SpeedCurve())


def mean_curve(curves: list[SpeedCurve]) -> Mean | None:
    """Return curves in one, on the speeds of the first that has any; a gap where the direction changes.

    Where a curve does not reach, it does not count.
    """
    full = [curve for curve in curves if len(curve.speed_rad_s) >= FEWEST_POINTS]
    if not full:
        return None
    speed = np.asarray(full[0].speed_rad_s)
    table = np.array([_at(curve, speed) for curve in full])
    with np.errstate(invalid="ignore"):
        middle = np.array([_mean(column) for column in table.T])
    low, high = np.fmin.reduce(table), np.fmax.reduce(table)
    return Mean(*(_parted(speed, column) for column in (speed, middle, low, high)))


def _at(curve: SpeedCurve, speed: Float) -> Float:
    """Return the torque of a curve at other speeds, in each direction on its own; NaN where it does not reach."""
    own, torque = np.asarray(curve.speed_rad_s), np.asarray(curve.torque_nm)
    found = np.full(len(speed), np.nan)
    for side in (-1.0, 1.0):
        mine, asked = side * own > 0.0, side * speed > 0.0
        if mine.any():
            found[asked] = np.interp(speed[asked], own[mine], torque[mine], left=np.nan, right=np.nan)
    return found


def _mean(column: Float) -> float:
    known = column[np.isfinite(column)]
    return float(known.mean()) if len(known) else float("nan")


def _parted(speed: Float, column: Float) -> Float:
    """Return a column with NaN between the two directions, so that no line crosses zero."""
    border = int(np.searchsorted(speed, 0.0))
    return column if border in (0, len(speed)) else np.insert(column, border, np.nan)


SESSION, INTERVAL, ALONE, ISOLATED, BASELINE = (
    "session", "95 % of a session", "not compared", "isolated, not counted", "reference sessions",
)  # fmt: skip
HELD, TREND, BAND, STEP, WHERE = "level", "trend", "95 % of level or trend", "step", "95 %, where the step is"
LEGEND = (SESSION, INTERVAL, BASELINE, ALONE, ISOLATED, HELD, TREND, BAND, STEP, WHERE)
"""Labels in the order in which they are read."""
NEAR = 1.5
"""Times the range of the values that intervals may reach beyond it; there they are cut."""
SMALLEST_SHARE = 0.1
"""Of the value: a panel is never higher resolved than that, so that noise does not look like drift."""


def draw_drift(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw one joint at column width, Coulomb above viscous, or every joint on a sheet, a row for each."""
    return draw_pairs(arm, joint, _draw_panel_batch_drift, LEGEND)


def _draw_panel_batch_drift(axes: "Axes", arm: ArmDrift, joint: JointDrift, coefficient: str) -> "list[Artist]":
    """Draw one coefficient of one joint; return the legend's entries."""
    narrow = is_narrow(axes.get_figure(root=True))
    label_panel(axes, "" if narrow and coefficient != COEFFICIENTS[0] else joint_name(joint))
    number_sessions(axes, arm)
    unit = coefficient_unit(coefficient)
    axes.set_ylabel(f"{coefficient_title(coefficient)}{' ' if narrow else chr(10)}[{unit}]")
    found = of_coefficient(joint, coefficient)
    if found is None or not any(math.isfinite(value.value) for value in found.values):
        axes.set_yticks([])
        say_in_panel(axes, _without_markup(found.message if found else "not estimated"), characters=44)
        return []
    axes.set_title(verdict_words(found), loc="right", color=CHANGE if found.drift else "black")
    shade_reference(axes, [k + 1.0 for k in arm.reference])
    handles = [*_draw_values(axes, found), *_draw_left_out(axes, arm, joint, found), *_draw_levels(axes, found)]
    axes.set_ylim(*value_limits(found))
    return [*handles, _reference_handle()]


def _without_markup(message: str) -> str:
    """Return the first sentence of a message, without the advice behind the semicolon."""
    return message.partition(";")[0]


def _draw_values(axes: "Axes", found: CoefficientDrift) -> "list[Artist]":
    """Draw the sessions that were compared, each with its interval."""
    place = np.array([k + 1.0 for k in found.sessions])
    value, low, high = columns(found.values)
    many = len(place) > MOST_MARKED
    # One path for all intervals: a file of a thousand sessions stays small.
    bars = np.full((len(place), 3), np.nan)
    bars[:, 0], bars[:, 1] = low, high
    (line,) = axes.plot(np.repeat(place, 3), bars.ravel(), color=ESTIMATE, lw=0.7, alpha=0.5, label=INTERVAL)
    style = {"lw": 0.7} if many else {"ls": "none", "marker": "o", "ms": 2.6, "mew": 0.0}
    (dots,) = axes.plot(place, value, color=ESTIMATE, label=SESSION, **style)
    return [dots, line, *_mark_isolated(axes, found)]


def _mark_isolated(axes: "Axes", found: CoefficientDrift) -> "list[Artist]":
    """Ring the sessions that none of their neighbours comes near."""
    at = {session: value.value for session, value in zip(found.sessions, found.values, strict=True)}
    places = [k + 1 for k in found.isolated]
    if not places:
        return []
    values = [at[k] for k in found.isolated]
    return list(
        axes.plot(places, values, ls="none", marker="D", ms=5.0, mfc="none", mec=CHANGE, mew=0.8, label=ISOLATED)
    )


def _draw_left_out(axes: "Axes", arm: ArmDrift, joint: JointDrift, found: CoefficientDrift) -> "list[Artist]":
    """Draw the sessions that were not compared, hollow."""
    places = sorted(set(range(len(arm.sessions))).difference(found.sessions))
    values = [raw_value(arm, k, joint.joint, found.coefficient).value for k in places]
    if not any(map(math.isfinite, values)):
        return []
    return list(
        axes.plot(
            [k + 1 for k in places], values, ls="none", marker="o", ms=2.8, mfc="none", mec=LEFT_OUT, mew=0.6,
            label=ALONE,
        )
    )  # fmt: skip


def raw_value(arm: ArmDrift, session: int, joint: int, coefficient: str) -> Coefficient:
    """Return a coefficient as a session has it, before anything was made alike."""
    summary = next((one for one in arm.sessions[session].joints if one.joint == joint), None)
    return UNDETERMINED if summary is None else summary.coefficients.get(coefficient, UNDETERMINED)


def _draw_levels(axes: "Axes", found: CoefficientDrift) -> "list[Artist]":
    """Draw the level before and after each step, or the trend; return the legend's entries."""
    handles: list[Artist] = []
    for low, high, level in stretches(found):
        handles += axes.plot((low, high), (level.value, level.value), color=LEVEL, lw=1.2, label=HELD, zorder=4)
        band = axes.fill_between((low, high), level.low, level.high, color=LEVEL, alpha=0.2, lw=0, label=BAND)
        handles.append(band)
    for change in found.change_points:
        low, middle, high = (_border(found, k) for k in (change.low, change.session, change.high))
        handles.append(axes.axvline(middle, color=CHANGE, lw=0.9, ls=(0, (2, 1.5)), label=STEP, zorder=3))
        if high > low:
            handles.append(axes.axvspan(low, high, color=CHANGE, alpha=0.12, lw=0, label=WHERE))
    if not found.change_points:
        handles += _draw_trend(axes, found)
    return handles


def stretches(found: CoefficientDrift) -> list[tuple[float, float, Coefficient]]:
    """Return from where to where each level holds, in numbers of sessions, one more than there are steps."""
    if not found.change_points:
        return []
    borders = [_border(found, change.session) for change in found.change_points]
    starts, stops = [found.sessions[0] + 0.5, *borders], [*borders, found.sessions[-1] + 1.5]
    levels = [found.change_points[0].before, *(change.after for change in found.change_points)]
    return list(zip(starts, stops, levels, strict=True))


def _border(found: CoefficientDrift, session: int) -> float:
    """Return where a step lies: midway between a session and the one compared before it."""
    before = max((k for k in found.sessions if k < session), default=session - 1)
    return 0.5 * (before + session) + 1.0


def _draw_trend(axes: "Axes", found: CoefficientDrift) -> "list[Artist]":
    """Draw the trend through the middle of the sessions, with the interval of its slope; thin where nothing drifts."""
    if not math.isfinite(found.trend_per_session.value):
        return []
    place, line, low, high = trend_line(found)
    style = {"lw": 1.2, "ls": "-"} if found.drift else {"lw": 0.8, "ls": (0, (4, 1.5))}
    handles: list[Artist] = [*axes.plot(place, line, color=LEVEL, label=TREND, zorder=4, **style)]  # type: ignore[arg-type]
    if np.isfinite(low + high).all():
        handles.append(axes.fill_between(place, low, high, color=LEVEL, alpha=0.2, lw=0, label=BAND))
    return handles


def trend_line(found: CoefficientDrift) -> tuple[Float, Float, Float, Float]:
    """Return places, the trend, and both ends of its slope's interval, all through the median of the sessions."""
    number = np.array([k + 1.0 for k in found.sessions])
    value, _, _ = columns(found.values)
    known = np.isfinite(value)
    slope = found.trend_per_session
    pivot = float(np.median(number[known]))
    level = float(np.median(value[known] - slope.value * (number[known] - pivot)))
    place = np.array([number[0], pivot, number[-1]])
    away = place - pivot
    ends = np.sort([level + slope.low * away, level + slope.high * away], axis=0)
    return place, level + slope.value * away, ends[0], ends[1]


def columns(values: tuple[Coefficient, ...]) -> tuple[Float, Float, Float]:
    """Return values, lower and upper ends, each of shape (m,)."""
    table = np.array([(one.value, one.low, one.high) for one in values], np.float64).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def value_limits(found: CoefficientDrift) -> tuple[float, float]:
    """Return limits that show all values and levels, and of the intervals as much as is near."""
    value, low, high = columns(found.values)
    levels = [one for change in found.change_points for one in (change.before.value, change.after.value)]
    shown = np.concatenate([value, levels])
    shown = shown[np.isfinite(shown)]
    bottom, top = float(shown.min()), float(shown.max())
    reach = NEAR * max(top - bottom, SMALLEST_SHARE * max(abs(top), abs(bottom)))
    ends = np.concatenate([low, high, shown])
    inside = np.clip(ends[np.isfinite(ends)], bottom - reach, top + reach)
    margin = 0.06 * max(float(np.ptp(inside)), reach, 1e-9)
    return float(inside.min()) - margin, float(inside.max()) + margin


def _reference_handle() -> "Artist":
    from matplotlib.patches import Patch

    return Patch(facecolor=REFERENCE, alpha=0.25, lw=0, label=BASELINE)
