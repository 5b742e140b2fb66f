"""TwoSides -> velocity-torque curves of both sides on one another, and the change of the friction law."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.two_sides import JointChange, TwoSides
from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures.drift import mean_curve
from friction_audit.reporting.figures.style import FILTERED, FITTED, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
