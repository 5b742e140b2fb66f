"""ArmDrift, TwoSides -> velocity-torque curves of sessions and of two sides, and the change of the friction law."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.drift.two_sides import JointChange, TwoSides
from friction_audit.joint_log import Float
from friction_audit.reporting.drift_words import curve_sessions
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures.style import DASHED, DISSIPATED, FILTERED, FITTED, GREEN


def _draw_curves(panels: Sequence[Axes], arm: ArmDrift, joint: JointDrift) -> None:
    (axes,), (first, reference, last) = panels, curve_sessions(arm)
    for label, sessions, colour, dash, width in (
        (f"first (session {first[0] + 1})", first, DISSIPATED, ":", 1.3),
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
        for sessions in curve_sessions(arm) for k in sessions
        for one in arm.sessions[k].joints if one.joint == joint.joint
    ),
    x="Velocity [rad/s]", y="Interaction torque [N m]",
)  # fmt: skip

COLOURS = {"before": FILTERED, "after": FITTED}


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


LAW_CHANGE = replace(SIDES, draw=_draw_law_change, x="Speed [rad/s]", y="Friction torque, after less before [N m]")
