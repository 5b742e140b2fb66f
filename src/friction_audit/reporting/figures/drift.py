"""ArmDrift, TwoSides -> coefficients over sessions, control chart, changes of all joints, velocity-torque curves."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from friction_audit.drift.report import FEWEST_SESSIONS, ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.drift.two_sides import JointChange, TwoSides
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting import drift_words
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.figures.style import DASHED, FILTERED, FITTED, GREEN, MUTED, Look
from friction_audit.reporting.words import NOTHING, count_of, format_date, scaled

MOST_MARKED = 150  # sessions in a panel above which markers would only be a blot; a line takes their place
MOST_TICKS = 6

Head = tuple[str, bool] | None  # what stands above a panel, and whether it is an alert; None where nothing is drawn
TITLES = {coefficient: word.capitalize() for coefficient, word in drift_words.NAMES.items()}


def _verdict(found: CoefficientDrift) -> str:
    """Return the verdict on a coefficient in the few words that fit above a panel."""
    if found.shape == "too_few":
        return f"drift needs {FEWEST_SESSIONS} sessions"
    word, total = drift_words.drift_verdict(found), drift_words.total_text(found)
    if word == drift_words.DRIFT and len(found.change_points) == 1:
        (change,) = found.change_points
        return f"{drift_words.format_change(change)} at session {change.session + 1}"
    return f"{total} in all" if word == drift_words.DRIFT and total != NOTHING else word


def _draw_both(draw: Any, panels: Sequence[Axes], arm: ArmDrift, joint: JointDrift) -> None:
    """Draw Coulomb above or left of viscous friction over the sessions, or why there is nothing."""
    places = range(1, len(arm.sessions) + 1, max(1, -(-len(arm.sessions) // MOST_TICKS)))
    dates, (_, part) = [format_date(arm.sessions[place - 1].start_s) for place in places], _dates(arm)
    ticks = [f"{k}" if date == NOTHING else f"{k}\n{date[part]}" for k, date in zip(places, dates, strict=True)]
    for axes, found in zip(panels, joint.coefficients, strict=True):
        if not parts.is_narrow(axes):
            axes.set_title(panels[0].get_title(loc="left"), loc="left")
        axes.set_xlim(0.2, len(arm.sessions) + 0.8)
        axes.set_xticks(places, ticks)
        axes.set_ylabel(TITLES[found.coefficient])
        if (drawn := draw(axes, arm, joint, found)) is None:
            axes.set_yticks([])
            reason = drift_words.headline(found, arm.sessions).partition(";")[0]
            parts.write_message(axes, reason if found.shape == "too_few" else "no reference")
            continue
        words, alert = drawn
        # No panel has ticks above; to look for them takes a third of the time, and a place given ends it.
        axes.set_title(words, loc="right", y=1.0, color=FITTED if alert else "black")


def _dates(arm: ArmDrift) -> tuple[str, slice]:
    """Return the name of an axis of sessions, and the part of a date at its ticks, which have room for two of three."""
    years = sorted({date[:4] for date in {format_date(session.start_s) for session in arm.sessions} - {NOTHING}})
    if len(years) > 1:
        return "Session (year-month)", slice(None, 7)
    return f"Session (month-day, {years[0]})" if years else "Session", slice(5, None)


def _shade_reference(axes: Axes, arm: ArmDrift) -> None:
    """Shade each run of neighbouring sessions of the reference along the axis."""
    places = np.sort(np.array(arm.reference, np.int64)) + 1
    for run in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else ():
        axes.axvspan(run[0] - 0.5, run[-1] + 0.5, fc=GREEN, alpha=0.12, lw=0, zorder=0, label="reference sessions")


SESSION, INTERVAL, ALONE, ISOLATED = "session", "95 % of a session", "not compared", "isolated, not counted"
HELD, TREND, BAND, STEP, WHERE = "level", "trend", "95 % of level or trend", "step", "95 %, where the step is"
NEAR = 1.5  # times the range of the values that intervals may reach beyond it; there they are cut
SMALLEST_SHARE = 0.1  # of the value: a panel is never higher resolved, so that noise does not look like drift


def _draw_coefficient(axes: Axes, arm: ArmDrift, joint: JointDrift, found: CoefficientDrift) -> Head:
    """Draw values, levels or trend; return the verdict in words, and whether it is drift."""
    if not any(math.isfinite(one.value) for one in found.values):
        return None
    separator = " " if parts.is_narrow(axes) else "\n"
    axes.set_ylabel(f"{TITLES[found.coefficient]}{separator}[{drift_words.UNITS[found.coefficient]}]")
    _shade_reference(axes, arm)
    place = np.array([k + 1.0 for k in found.sessions])
    value, low, high = np.array([(one.value, one.low, one.high) for one in found.values]).T
    # One path for all intervals: a file of a thousand sessions stays small.
    bars = np.stack([low, high, np.full(len(place), np.nan)], axis=1).ravel()
    axes.plot(np.repeat(place, 3), bars, color=FILTERED, lw=0.7, alpha=0.5, label=INTERVAL)
    style: Look = {"lw": 0.7} if len(place) > MOST_MARKED else {"ls": "none", "marker": "o", "ms": 2.6, "mew": 0.0}
    axes.plot(place, value, color=FILTERED, label=SESSION, **style)
    ringed = np.isin(found.sessions, found.isolated)
    if ringed.any():
        axes.plot(place[ringed], value[ringed], "D", ms=5.0, mfc="none", mec=FITTED, mew=0.8, label=ISOLATED)
    if found.change_points:
        _draw_levels(axes, found)
    elif math.isfinite(found.trend_per_session.value):
        _draw_trend(axes, found)
    # All values and levels; of intervals, and of sessions not compared (without any correction), what is near.
    levels = [one for change in found.change_points for one in (change.before.value, change.after.value)]
    left_out = np.array([
        (k + 1, one.coefficients.get(found.coefficient, UNDETERMINED).value)
        for k in set(range(len(arm.sessions))).difference(found.sessions)
        for one in arm.sessions[k].joints
        if one.joint == joint.joint
    ]).reshape(-1, 2)  # fmt: skip
    smallest = max(SMALLEST_SHARE * float(np.nanmax(np.abs(value))), 1e-9)
    others = np.concatenate([low, high, left_out[:, 1]])
    bottom, top = parts.limits(np.append(value, levels), others, near=NEAR, smallest=smallest) or (0.0, 1.0)
    axes.set_ylim(bottom, top)
    left_out = left_out[(left_out[:, 1] > bottom) & (left_out[:, 1] < top)]
    if len(left_out):
        axes.plot(*left_out.T, "o", ms=2.8, mfc="none", mec=MUTED, mew=0.6, label=ALONE)
    return _verdict(found), found.drift


def _draw_levels(axes: Axes, found: CoefficientDrift) -> None:
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


def _draw_trend(axes: Axes, found: CoefficientDrift) -> None:
    """Draw the trend through the median of the sessions, with the interval of its slope; thin without drift."""
    number, value = np.array([k + 1.0 for k in found.sessions]), np.array([one.value for one in found.values])
    known, slope = np.isfinite(value), found.trend_per_session
    pivot = float(np.median(number[known]))
    level = float(np.median(value[known] - slope.value * (number[known] - pivot)))
    place = np.array([number[0], pivot, number[-1]])
    line, *ends = (level + one * (place - pivot) for one in (slope.value, slope.low, slope.high))
    lw, ls = (1.2, "-") if found.drift else (0.8, DASHED)
    axes.plot(place, line, color=FITTED, label=TREND, zorder=4, lw=lw, ls=ls)
    if np.isfinite(ends).all():
        low, high = np.sort(ends, axis=0)
        parts.band(axes, place, low, high, FITTED, BAND)


DRIFT = parts.Layout(
    joints=lambda arm: arm.joints, lacks="no estimate", draw=partial(_draw_both, _draw_coefficient), panels=2,
    has=lambda _, joint: any(math.isfinite(one.value) for found in joint.coefficients for one in found.values),
    height_in=(1.15, 1.3), head_in=0.6,
    x=lambda arm: _dates(arm)[0], shared=True,
    legend=(SESSION, INTERVAL, "reference sessions", ALONE, ISOLATED, HELD, TREND, BAND, STEP, WHERE),
)  # fmt: skip

LEGEND = ("limits of a steady joint", "within the limits", "outside", "reference sessions")


def _draw_chart(axes: Axes, arm: ArmDrift, _: JointDrift, found: CoefficientDrift) -> Head:
    """Draw deviations and limits: in percent, or in the coefficient's unit near a level of zero."""
    if not (control := found.control):
        return None
    relative = any(math.isfinite(point.relative.value) for point in control)
    unit = "%" if relative else drift_words.UNITS[found.coefficient]
    axes.set_ylabel(f"{TITLES[found.coefficient]}\n[{unit}]")
    numbers = [point.relative if relative else point.deviation for point in control]
    scale = 100.0 if relative else 1.0
    value, low, high = (scale * np.array([getattr(one, end) for one in numbers]) for end in ("value", "low", "high"))
    place = np.array([point.session + 1 for point in control])
    outside = np.array([point.outside for point in control])
    _shade_reference(axes, arm)
    many = len(place) > MOST_MARKED
    parts.band(axes, place, low, high, MUTED, LEGEND[0], step=None if many else "mid", alpha=0.16)
    parts.mark_zero(axes, color=MUTED, lw=0.6)
    # A session with wide limits does not stretch the chart.
    bounds = np.concatenate([low, high])
    reach = FARTHEST * float(np.nanmedian(np.abs(bounds))) if np.isfinite(bounds).any() else 0.0
    reach = max(reach, float(np.nanmax(np.abs(value))))
    axes.set_ylim(parts.limits(value, np.clip(bounds, -reach, reach), near=math.inf, smallest=1e-9))
    line: Look = {"lw": 0.7} if many else {"lw": 0.4, "marker": "o", "ms": 2.6, "mew": 0.0}
    axes.plot(place, value, color=FILTERED, label=LEGEND[1], **line)
    if outside.any():
        size = 1.6 if many else 3.4
        axes.plot(place[outside], value[outside], "s", color=FITTED, ms=size, mew=0.0, zorder=4, label=LEGEND[2])
    words = f"{count_of(int(outside.sum()), 'session')} outside" if outside.any() else "all within"
    return words, bool(outside.any())


CONTROL = replace(DRIFT, draw=partial(_draw_both, _draw_chart), legend=LEGEND)

MARKS = {
    drift_words.DRIFT: (FITTED, "s", "changed"),
    drift_words.TEMPERATURE: (theme.DISSIPATED, "^", "changes with temperature"),
    drift_words.STEADY: (FILTERED, "o", "no drift found"),
}  # colour, marker and label of each verdict that comes with a change
NARROWEST = 5.0  # percent either side of no change that a panel shows at least
FARTHEST = 2.0  # times the changes and their intervals that the undetectable may stretch a panel; there it is cut


@theme.figure_style()
def draw_changes(arm: ArmDrift, numbers: parts.Numbers = None) -> Figure:
    """Draw one joint at column width, or every joint on a sheet, a line for each; Coulomb next to viscous."""
    joints, note = parts.choose(arm.joints, numbers, partial(DRIFT.has, arm), DRIFT.lacks)
    width = theme.COLUMN_IN if isinstance(numbers, int) else theme.SHEET_IN
    figure, both = parts.grid([max(0.24 * len(joints), 0.6)] * 2, 2, width, 0.85, sharey=True)
    for k, (axes, title) in enumerate(zip(both, TITLES.values(), strict=True)):
        parts.label_panel(axes, title)
        axes.tick_params(axis="y", length=0)
        parts.mark_zero(axes, x=True, y=False, lw=0.5, zorder=0)
        reach, undetectable = NARROWEST, [0.0]
        for place, found in enumerate(one.coefficients[k] for one in joints):
            verdict, words = drift_words.drift_verdict(found), drift_words.total_text(found)
            if math.isnan(found.total.value) or verdict == drift_words.UNTESTED:
                where: Look = {"xycoords": ("axes fraction", "data"), "va": "center", "fontsize": 6.5, "color": MUTED}
                axes.annotate(verdict if words == NOTHING else words, (0.02, place), **where)
                continue
            percent = scaled(found.total, 100.0)
            value, low, high, width = percent.value, percent.low, percent.high, 100.0 * found.smallest_drift
            if math.isfinite(width):
                look: Look = {"color": MUTED, "alpha": 0.18, "lw": 0, "label": "not detectable with 90 % power"}
                axes.barh(place, 2.0 * width, left=-width, height=0.7, **look)
            colour, marker, label = MARKS[verdict]
            axes.hlines(place, low, high, color=colour, lw=1.0)
            axes.plot(value, place, color=colour, marker=marker, ms=3.8, mew=0.0, ls="none", label=label)
            reach = max(reach, *(abs(end) for end in (low, high, value) if math.isfinite(end)))
            undetectable.append(width)
        reach = max(reach, *(min(one, FARTHEST * reach) for one in undetectable if math.isfinite(one)))
        axes.set_xlim(-1.15 * reach, 1.15 * reach)
    both[0].set_yticks(range(len(joints)), [parts.joint_title(one.joint, one.name) for one in joints])
    both[0].set_ylim(len(joints) - 0.5, -0.5)
    parts.add_legend(figure, [label for _, _, label in MARKS.values()])
    figure.supxlabel(f"Change from the reference to the last sessions [%]{note}")
    return figure


CHANGES = draw_changes


def _draw_curves(panels: Sequence[Axes], arm: ArmDrift, joint: JointDrift) -> None:
    (axes,), (first, reference, last) = panels, drift_words.curve_sessions(arm)
    for label, sessions, colour, dash, width in (
        (f"first (session {first[0] + 1})", first, theme.DISSIPATED, ":", 1.3),
        (f"reference (mean of {len(reference)})", reference, GREEN, "-", 1.0),
        (f"last (session {last[0] + 1})", last, FILTERED, DASHED, 1.1),
    ):
        found = [one.curve for k in sessions for one in arm.sessions[k].joints if one.joint == joint.joint]
        speed, torque, low, high = mean_curve(found)
        if len(speed):
            axes.plot(speed, torque, color=colour, ls=dash, lw=width, label=label)
            if len(sessions) > 1:
                parts.band(axes, speed, low, high, colour, "range of the reference")
    if axes.lines:
        parts.mark_zero(axes, x=True, color="0.6", lw=0.3, zorder=0)
    else:
        parts.write_message(axes, "no session moves this joint", characters=36, instead=True)


def mean_curve(curves: Sequence[SpeedCurve]) -> Float:
    """Return speeds of the first of some curves, and mean, smallest and largest torque of all where they reach.

    They are of shape (4, m), with a gap where the direction changes; m is 0 without any curve.
    """
    broken = [
        np.insert((one.speed_rad_s, one.torque_nm), np.searchsorted(one.speed_rad_s, 0.0), (0.0, np.nan), axis=1)
        for one in curves
        if len(one.speed_rad_s) > 1
    ]
    if not broken:
        return np.empty((4, 0))
    speed = broken[0][0]
    table = np.ma.masked_invalid([np.interp(speed, one[0], one[1], left=np.nan, right=np.nan) for one in broken])
    return np.stack([speed, *(np.ma.filled(one, np.nan) for one in (table.mean(0), table.min(0), table.max(0)))])


CURVES = parts.Layout(
    joints=lambda arm: arm.joints, lacks="no curve", draw=_draw_curves, across=4,
    has=lambda arm, joint: any(
        one.curve.speed_rad_s
        for sessions in drift_words.curve_sessions(arm) for k in sessions
        for one in arm.sessions[k].joints if one.joint == joint.joint
    ),
    x="Velocity [rad/s]", y="Interaction torque [N m]",
)  # fmt: skip

COLOURS = {"before": FILTERED, "after": FITTED}  # of the two sides


def _draw_sides(panels: Sequence[Axes], _: TwoSides, joint: JointChange) -> None:
    """Draw the mean curve of each side; of a result, which holds none, the fitted friction."""
    (axes,) = panels
    parts.mark_zero(axes, x=True, color="0.6", lw=0.3, zorder=0)
    for place, (label, colour) in enumerate(COLOURS.items()):
        speed, torque, low, high = mean_curve(joint.curves[place])
        if not len(speed):
            coulomb, viscous = ((one.before, one.after)[place].value for one in joint.coefficients)
            speed = np.array([-1.0, -1e-9, np.nan, 1e-9, 1.0]) * _reach(joint)  # no line crosses zero
            torque = coulomb * np.sign(speed) + viscous * speed
            axes.plot(speed, torque, color=colour, lw=1.1, ls=":", label=f"{label}, fitted")
            continue
        axes.plot(speed, torque, color=colour, lw=1.1, ls=DASHED if place else "-", label=label)
        if np.any(high > low):
            parts.band(axes, speed, low, high, colour, f"{label}, range of the recordings")


def _reach(joint: JointChange) -> float:
    speeds = [abs(speed) for side in joint.curves for curve in side for speed in curve.speed_rad_s]
    return max(speeds, default=0.0 if joint.law is None else float(joint.law.speed_rad_s[-1]))


SIDES = replace(CURVES, has=lambda _, joint: _reach(joint), lacks="no curve and no estimate", draw=_draw_sides)


def _draw_law_change(panels: Sequence[Axes], _: TwoSides, joint: JointChange) -> None:
    (axes,), law = panels, joint.law
    if law is None:
        parts.write_message(axes, "both coefficients are needed on both sides", characters=24, instead=True)
        return
    parts.band(axes, law.speed_rad_s, law.low_nm, law.high_nm, FILTERED, "95 % interval")
    axes.plot(law.speed_rad_s, law.change_nm, color=FILTERED, lw=1.1, label="after less before")
    parts.mark_zero(axes)


LAW_CHANGE = replace(SIDES, draw=_draw_law_change, x="Speed [rad/s]", y="Change of friction [N m]")
