"""The paper's Fig. 11 for any log: interaction torque against velocity, without a compensator and with it."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.audit import Estimate, LogReplay
from friction_audit.replay.result import JointReplay, Signals
from friction_audit.report.figures.layout import add_legend, label_panel, new_figure, say_in_panel
from friction_audit.report.figures.names import joint_title
from friction_audit.report.figures.replay import MOST_OF_WITHOUT, SMALLEST_SPEED_RAD_S, replayed
from friction_audit.report.figures.smoothing import CUTOFF_HZ, cutoff_hz, median_rate_hz, smooth
from friction_audit.report.figures.style import COLUMN_IN, FILTERED, FITTED, MUTED, RAW, SHEET_IN, figure_style
from friction_audit.report.figures.thinning import every_nth

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 4
RAW_WITHOUT = "#f6cfb0"
"""As pale beside its curve as RAW is beside FILTERED."""
DOTS = 8000
LOOP_POINTS = 12_000
POINTS_PER_PERIOD = 10


def draw_replay_velocity_torque(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw what the default compensator would have left of the friction curve."""
    return draw_log_replay_velocity_torque(replayed(estimate, joint), joint)


def draw_log_replay_velocity_torque(found: LogReplay, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet."""
    with figure_style():
        title = found.replay.counterfactual.title
        joints = [one for one in found.replay.joints if joint is None or one.joint == joint]
        columns = 1 if joint is not None else min(len(joints), COLUMNS)
        rows = -(-len(joints) // columns)
        size = (COLUMN_IN, 2.9) if joint is not None else (SHEET_IN, 0.6 + 1.75 * rows)
        figure = new_figure(*size)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        drawn = [_draw_panel(axes, one) for axes, one in zip(panels, joints, strict=False)]
        for axes in panels[len(joints) :]:
            axes.remove()
        add_legend(figure, max(drawn, key=len))
        figure.supxlabel(f"Velocity [rad/s], {title}", fontsize=7.5)
        figure.supylabel("Interaction torque [N m]", fontsize=7.5)
        return figure


def _draw_panel(axes: "Axes", joint: JointReplay) -> "list[Artist]":
    """Draw one joint; return the legend's entries."""
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=0)
    axes.axvline(0.0, color=MUTED, lw=0.4, zorder=0)
    handles = _draw_curve(axes, joint.without, (RAW_WITHOUT, FITTED), "without")
    speeds = [float(np.abs(one.dq).max()) for one in (joint.without, joint.replayed) if one is not None]
    reach = min(1.05 * max(speeds), MOST_OF_WITHOUT * max(speeds[0], SMALLEST_SPEED_RAD_S))
    reach = max(reach, SMALLEST_SPEED_RAD_S)
    axes.set_xlim(-reach, reach)
    label_panel(axes, joint_title(joint.joint, joint.name), across=4)
    if joint.replayed is None or joint.history is None:
        say_in_panel(axes, f"not replayed: {joint.reason.partition(';')[0]}", characters=24)
        return handles
    # What the compensator has not yet learnt is the curve without it once more.
    start = int(joint.history.stop[0]) if len(joint.history.stop) else 0
    active = np.flatnonzero(joint.replayed.compensation_nm)
    start = max(start, int(active[0]) if len(active) else 0)
    handles += _draw_curve(axes, _from(joint.replayed, start), (RAW, FILTERED), "with")
    if len(joint.replayed.t) < len(joint.without.t):
        most = MOST_OF_WITHOUT * float(np.abs(joint.without.interaction_nm).max())
        axes.set_ylim(-most, most)
        axes.annotate("diverges", (0.03, 0.03), xycoords="axes fraction", fontsize=6.5)
    return handles


def _from(signals: Signals, start: int) -> Signals:
    return Signals(
        t=signals.t[start:],
        dq=signals.dq[start:],
        interaction_nm=signals.interaction_nm[start:],
        compensation_nm=signals.compensation_nm[start:],
        passivity_nm=signals.passivity_nm[start:],
    )


def _draw_curve(axes: "Axes", signals: Signals, colours: tuple[str, str], name: str) -> "list[Artist]":
    """Draw a friction curve raw and filtered; return the legend's entries."""
    from matplotlib.lines import Line2D

    if len(signals.t) < 2:  # noqa: PLR2004
        return []
    thin = every_nth(len(signals.t), DOTS)
    axes.plot(signals.dq[thin], signals.interaction_nm[thin], ".", color=colours[0], ms=1.2, mew=0, rasterized=True)
    step = max(1, int(median_rate_hz(signals.t) / (POINTS_PER_PERIOD * CUTOFF_HZ)), len(signals.t) // LOOP_POINTS)
    dq, torque = (smooth(signals.t, one)[::step] for one in (signals.dq, signals.interaction_nm))
    label = f"{name}, {cutoff_hz(signals.t):.3g} Hz"
    curve = axes.plot(dq, torque, color=colours[1], lw=0.4, rasterized=True, label=label)
    return [Line2D([], [], color=colours[0], marker=".", ls="", ms=5, mew=0, label=f"{name}, raw"), *curve]
