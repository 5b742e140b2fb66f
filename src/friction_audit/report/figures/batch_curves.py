"""Velocity-torque curves of the first session, of the reference and of the last session on one another."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.joint_log import Float
from friction_audit.report.drawn_arm import curve_sessions
from friction_audit.report.figures.batch_look import (
    FIRST,
    LAST,
    REFERENCE,
    chosen_joints,
    in_order,
    joint_name,
    name_joints_left_out,
)
from friction_audit.report.figures.diagnose_look import draw_grid
from friction_audit.report.figures.layout import add_legend, label_panel, say_in_panel
from friction_audit.report.figures.style import figure_style

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
