"""ArmDrift, TwoSides -> coefficients over sessions with levels and trends; velocity-torque curves of sessions."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.drift.two_sides import JointChange, TwoSides
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting.drift_words import UNITS
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures import sessions as over_sessions
from friction_audit.reporting.figures.style import DASHED, DISSIPATED, FILTERED, FITTED, Look, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SESSION, INTERVAL, ALONE, ISOLATED = "session", "95 % of a session", "not compared", "isolated, not counted"
HELD, TREND, BAND, STEP, WHERE = "level", "trend", "95 % of level or trend", "step", "95 %, where the step is"
LEGEND = (SESSION, INTERVAL, "reference sessions", ALONE, ISOLATED, HELD, TREND, BAND, STEP, WHERE)
NEAR = 1.5  # times the range of the values that intervals may reach beyond it; there they are cut
SMALLEST_SHARE = 0.1  # of the value: a panel is never higher resolved, so that noise does not look like drift


def draw_drift(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw the coefficients of one joint at column width, or of every joint on a sheet, a row for each."""

    def has(found: CoefficientDrift) -> bool:
        return any(math.isfinite(value.value) for value in found.values)

    return over_sessions.draw_pairs(arm, joint, _draw_coefficient, has, LEGEND)


def _draw_coefficient(axes: "Axes", arm: ArmDrift, joint: JointDrift, found: CoefficientDrift) -> None:
    separator = " " if parts.is_narrow(axes) else "\n"
    axes.set_ylabel(f"{over_sessions.coefficient_title(found.coefficient)}{separator}[{UNITS[found.coefficient]}]")
    axes.set_title(over_sessions.verdict_words(found), loc="right", color=FITTED if found.drift else "black")
    over_sessions.shade_reference(axes, arm)
    _draw_values(axes, found)
    _draw_left_out(axes, arm, joint, found)
    if found.change_points:
        _draw_levels(axes, found)
    elif math.isfinite(found.trend_per_session.value):
        _draw_trend(axes, found)
    axes.set_ylim(value_limits(found))


def _draw_values(axes: "Axes", found: CoefficientDrift) -> None:
    """Draw the sessions that were compared, each with its interval, and ring the isolated ones."""
    place = np.array([k + 1.0 for k in found.sessions])
    value, low, high = columns(found.values)
    # One path for all intervals: a file of a thousand sessions stays small.
    bars = np.full((len(place), 3), np.nan)
    bars[:, 0], bars[:, 1] = low, high
    axes.plot(np.repeat(place, 3), bars.ravel(), color=FILTERED, lw=0.7, alpha=0.5, label=INTERVAL)
    style: Look = (
        {"lw": 0.7} if len(place) > over_sessions.MOST_MARKED else {"ls": "none", "marker": "o", "ms": 2.6, "mew": 0.0}
    )
    axes.plot(place, value, color=FILTERED, label=SESSION, **style)
    ringed = np.isin(found.sessions, found.isolated)
    if ringed.any():
        look: Look = {
            "ls": "none",
            "marker": "D",
            "ms": 5.0,
            "mfc": "none",
            "mec": FITTED,
            "mew": 0.8,
            "label": ISOLATED,
        }
        axes.plot(place[ringed], value[ringed], **look)


def _draw_left_out(axes: "Axes", arm: ArmDrift, joint: JointDrift, found: CoefficientDrift) -> None:
    """Draw the sessions that were not compared, hollow, as they are without any correction."""
    values: dict[int, float] = {}
    for k in set(range(len(arm.sessions))).difference(found.sessions):
        summary = next((one for one in arm.sessions[k].joints if one.joint == joint.joint), None)
        value = UNDETERMINED if summary is None else summary.coefficients.get(found.coefficient, UNDETERMINED)
        values[k + 1] = value.value
    if any(map(math.isfinite, values.values())):
        look: Look = {
            "ls": "none",
            "marker": "o",
            "ms": 2.8,
            "mfc": "none",
            "mec": over_sessions.LEFT_OUT,
            "mew": 0.6,
            "label": ALONE,
        }
        axes.plot(list(values), list(values.values()), **look)


def _draw_levels(axes: "Axes", found: CoefficientDrift) -> None:
    """Draw the level before and after each step, and the interval of its place."""
    for low, high, level in stretches(found):
        axes.plot((low, high), (level.value, level.value), color=FITTED, lw=1.2, label=HELD, zorder=4)
        parts.band(axes, np.array([low, high]), np.full(2, level.low), np.full(2, level.high), FITTED, BAND)
    for change in found.change_points:
        low, middle, high = (_border(found, k) for k in (change.low, change.session, change.high))
        axes.axvline(middle, color=FITTED, lw=0.9, ls=(0, (2, 1.5)), label=STEP, zorder=3)
        if high > low:
            axes.axvspan(low, high, color=FITTED, alpha=0.12, lw=0, label=WHERE)


def stretches(found: CoefficientDrift) -> list[tuple[float, float, Coefficient]]:
    """Return from where to where each level holds, in numbers of sessions, one more than there are steps."""
    borders = [_border(found, change.session) for change in found.change_points]
    starts, stops = [found.sessions[0] + 0.5, *borders], [*borders, found.sessions[-1] + 1.5]
    levels = [found.change_points[0].before, *(change.after for change in found.change_points)]
    return list(zip(starts, stops, levels, strict=True))


def _border(found: CoefficientDrift, session: int) -> float:
    """Return where a step lies: midway between a session and the one compared before it."""
    before = max((k for k in found.sessions if k < session), default=session - 1)
    return 0.5 * (before + session) + 1.0


def _draw_trend(axes: "Axes", found: CoefficientDrift) -> None:
    """Draw the trend through the middle of the sessions, with the interval of its slope; thin without drift."""
    place, line, low, high = trend_line(found)
    lw, ls = (1.2, "-") if found.drift else (0.8, DASHED)
    axes.plot(place, line, color=FITTED, label=TREND, zorder=4, lw=lw, ls=ls)
    if np.isfinite(low + high).all():
        parts.band(axes, place, low, high, FITTED, BAND)


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


def value_limits(found: CoefficientDrift) -> tuple[float, float] | None:
    """Return limits that show all values and levels, and of the intervals as much as is near."""
    value, low, high = columns(found.values)
    levels = [one for change in found.change_points for one in (change.before.value, change.after.value)]
    smallest = max(SMALLEST_SHARE * float(np.nanmax(np.abs(value))), 1e-9)
    return parts.limits(np.append(value, levels), np.concatenate([low, high]), near=NEAR, smallest=smallest)


SPREAD = "range of the reference"


class Mean(NamedTuple):
    """Curves of several sessions in one: mean, smallest and largest torque at each speed, each of shape (m,)."""

    speed: Float
    torque: Float
    low: Float
    high: Float


@figure_style()
def draw_curves(arm: ArmDrift, joint: int | None) -> "Figure":
    """Draw the curves of one joint at column width, or of every joint on a sheet."""
    joints = over_sessions.chosen_joints(arm, joint)
    sheet = joint is None
    figure, panels = parts.grid([1.45 if sheet else 2.4] * len(joints), sheet=sheet, across=4, head_in=0.75)
    for axes, one in zip(panels, joints, strict=True):
        _draw_curves(axes, arm, one)
    parts.add_legend(figure)
    over_sessions.label_sheet(figure, arm, joints, "Velocity [rad/s]")
    figure.supylabel("Interaction torque [N m]")
    return figure


def curve_sessions(arm: ArmDrift) -> tuple[int, tuple[int, ...], int] | None:
    """Return the sessions whose curves are drawn: the first, those of the reference, the last; None without any."""
    compared = arm.compared or tuple(range(len(arm.sessions)))
    return (compared[0], arm.reference, compared[-1]) if compared else None


def _draw_curves(axes: "Axes", arm: ArmDrift, joint: JointDrift) -> None:
    """Draw the first session, the mean of the reference and the last session of one joint."""
    parts.label_panel(axes, over_sessions.joint_name(joint))
    drawn = curve_sessions(arm)
    first, reference, last = drawn if drawn is not None else (0, (), 0)
    curves = (
        (f"first (session {first + 1})", (first,), DISSIPATED, ":", 1.3),
        (f"reference (mean of {len(reference)})", reference, over_sessions.REFERENCE, "-", 1.0),
        (f"last (session {last + 1})", (last,), FILTERED, DASHED, 1.1),
    )
    for label, sessions, colour, dash, width in curves if drawn is not None else ():
        found = [one.curve for k in sessions for one in arm.sessions[k].joints if one.joint == joint.joint]
        mean = mean_curve(found)
        if mean is not None:
            axes.plot(mean.speed, mean.torque, color=colour, ls=dash, lw=width, label=label)
            if len(sessions) > 1:
                parts.band(axes, mean.speed, mean.low, mean.high, colour, SPREAD)
    if axes.lines:
        parts.mark_zero(axes, x=True, color="0.6", lw=0.3, zorder=0)
    else:
        parts.write_message(axes, "no session moves this joint", characters=36, instead=True)


def mean_curve(curves: list[SpeedCurve]) -> Mean | None:
    """Return curves in one, on the speeds of the first that has any; a gap where the direction changes.

    Where a curve does not reach, it does not count.
    """
    full = [curve for curve in curves if len(curve.speed_rad_s) > 1]
    if not full:
        return None
    speed = np.asarray(full[0].speed_rad_s)
    table = np.ma.masked_invalid([_at(curve, speed) for curve in full])
    rows = [speed, *(np.ma.filled(column, np.nan) for column in (table.mean(0), table.min(0), table.max(0)))]
    border = int(np.searchsorted(speed, 0.0))  # no line crosses zero
    return Mean(*(row if border in (0, len(speed)) else np.insert(row, border, np.nan) for row in rows))


def _at(curve: SpeedCurve, speed: Float) -> Float:
    """Return the torque of a curve at other speeds, in each direction on its own; NaN where it does not reach."""
    own, torque = np.asarray(curve.speed_rad_s), np.asarray(curve.torque_nm)
    found = np.full(len(speed), np.nan)
    for side in (-1.0, 1.0):
        mine, asked = side * own > 0.0, side * speed > 0.0
        if mine.any():
            found[asked] = np.interp(speed[asked], own[mine], torque[mine], left=np.nan, right=np.nan)
    return found


SIDES = (("before", FILTERED), ("after", FITTED))
COLUMNS = 4


@figure_style()
def draw_side_curves(sides: TwoSides, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint that moved on a sheet."""
    figure, panels, note = _panels(sides, joint)
    for axes, one in panels:
        for place, (label, colour) in enumerate(SIDES):
            _draw_side(axes, one, place, label, colour)
        parts.mark_zero(axes, x=True, color="0.6", lw=0.3, zorder=0)
    parts.add_legend(figure)
    figure.supxlabel(f"Velocity [rad/s]{note}")
    figure.supylabel("Interaction torque [N m]")
    return figure


@figure_style()
def draw_law_change(sides: TwoSides, joint: int | None) -> "Figure":
    """Draw the difference of the friction laws with its 95 % interval at each speed."""
    figure, panels, note = _panels(sides, joint)
    for axes, one in panels:
        if one.law is None:
            parts.write_message(axes, "both coefficients are needed on both sides", characters=24, instead=True)
            continue
        law = one.law
        parts.band(axes, law.speed_rad_s, law.low_nm, law.high_nm, FILTERED, "95 % interval")
        axes.plot(law.speed_rad_s, law.change_nm, color=FILTERED, lw=1.1, label="after less before")
        parts.mark_zero(axes)
    parts.add_legend(figure)
    figure.supxlabel(f"Speed [rad/s]{note}")
    figure.supylabel("Friction torque, after less before [N m]")
    return figure


def _panels(sides: TwoSides, joint: int | None) -> "tuple[Figure, list[tuple[Axes, JointChange]], str]":
    """Return a figure, the panel of each joint with something to draw, and a line on the others."""
    joints, sheet, note = parts.choose(sides.joints, joint, _reach, "no curve and no estimate")
    figure, panels = parts.grid([1.45 if sheet else 2.4] * len(joints), sheet=sheet, across=COLUMNS, head_in=0.75)
    for axes, one in zip(panels, joints, strict=True):
        parts.label_panel(axes, parts.joint_title(one.joint, one.name))
    return figure, list(zip(panels, joints, strict=True)), note


def _reach(joint: JointChange) -> float:
    speeds = [abs(speed) for side in joint.curves for curve in side for speed in curve.speed_rad_s]
    return max(speeds, default=0.0 if joint.law is None else float(joint.law.speed_rad_s[-1]))


def _draw_side(axes: "Axes", joint: JointChange, place: int, label: str, colour: str) -> None:
    """Draw the mean curve of a side; of a result, which holds none, the fitted friction."""
    mean = mean_curve(list(joint.curves[place]))
    if mean is not None:
        axes.plot(mean.speed, mean.torque, color=colour, lw=1.1, label=label)
        if np.any(mean.high > mean.low):
            parts.band(axes, mean.speed, mean.low, mean.high, colour, f"{label}, range of the recordings")
        return
    coulomb, viscous = ((one.before, one.after)[place].value for one in joint.coefficients)
    speed: Float = np.array([-1.0, -1e-9, np.nan, 1e-9, 1.0]) * _reach(joint)  # no line crosses zero
    axes.plot(speed, coulomb * np.sign(speed) + viscous * speed, color=colour, lw=1.1, ls=":", label=f"{label}, fitted")
