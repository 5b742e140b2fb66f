"""The paper's Fig. 10 for any log: signals, net energy with and without a compensator, coefficients."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.compensation.result import JointReplay, Signals
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate, LogReplay, replay_estimate
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    CUTOFF_HZ,
    DISSIPATED,
    FILTERED,
    FITTED,
    MOST_SHADED,
    MUTED,
    RAW,
    SHADE,
    SHEET_IN,
    add_legend,
    cutoff_hz,
    every_nth,
    figure_style,
    joint_title,
    label_panel,
    median_rate_hz,
    new_figure,
    say_in_panel,
    smooth,
    thin_extremes,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


POINTS = 4000
"""Points of a curve: more than a column has pixels."""
ROW_IN = 1.0
DASHED = (0, (4, 1.5))
LABELS = {"viscous_nms_per_rad": "viscous", "coulomb_nm": "Coulomb"}
LEAST_COEFFICIENT = 0.05
"""Least height of the panel of the coefficients, which may all be zero. [N m, N m s/rad]"""
SMALLEST_TORQUE_NM = 0.5
"""Half height of the torque panel of a joint at rest, whose noise would fill it."""
SMALLEST_SPEED_RAD_S = 0.1
"""Half width of the panel of a joint that stands still. [rad/s]"""
MOST_OF_WITHOUT = 3.0
"""Times the largest speed and torque without a compensator beyond which a diverging one is cut off."""


def draw_replay(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw what the default compensator would have done along the recorded motion."""
    return draw_log_replay(replayed(estimate, joint), joint)


def replayed(estimate: Estimate, joint: int | None) -> LogReplay:
    """Replay one joint of a log, or all of them, with the default settings."""
    return replay_estimate(estimate, ReplaySettings(), joints=None if joint is None else (joint,))


def draw_log_replay(found: LogReplay, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a row for each."""
    with figure_style():
        title = found.replay.counterfactual.title
        if joint is None:
            return _draw_sheet(found.replay.joints, title)
        return _draw_column(next(one for one in found.replay.joints if one.joint == joint), title)


def _draw_column(joint: JointReplay, title: str) -> "Figure":
    figure = new_figure(COLUMN_IN, 5.6)
    panels = figure.subplots(5, 1, sharex=True)
    handles = _draw_velocity(panels[0], joint) + _draw_torque(panels[1], joint)[2:]
    handles += _draw_energy(panels[2], joint)
    panels[0].set_ylabel("Velocity\n[rad/s]")
    panels[1].set_ylabel("Torque\n[N m]")
    panels[2].set_ylabel("Energy [J]")
    _draw_coefficient(panels[3], joint, "viscous_nms_per_rad", FILTERED)
    panels[3].set_ylabel("Viscous\n[N m s/rad]")
    _draw_coefficient(panels[4], joint, "coulomb_nm", DISSIPATED)
    panels[4].set_ylabel("Coulomb\n[N m]")
    titles = (f"{_name(joint)}, {title}", "", "", "", "")
    _finish(panels, joint, titles)
    add_legend(figure, handles)
    panels[4].set_xlabel("Time [s]")
    figure.align_ylabels()
    return figure


def _draw_sheet(joints: "Sequence[JointReplay]", title: str) -> "Figure":
    figure = new_figure(SHEET_IN, 0.9 + ROW_IN * len(joints))
    rows = figure.subplots(len(joints), 3, squeeze=False, sharex=True)
    found: list[list[Artist]] = []
    for row, joint in zip(rows, joints, strict=True):
        handles = _draw_torque(row[0], joint) + _draw_energy(row[1], joint)[1:]
        viscous = _draw_coefficient(row[2], joint, "viscous_nms_per_rad", FILTERED)
        coulomb = _draw_coefficient(row[2], joint, "coulomb_nm", DISSIPATED)
        found.append([*handles, *viscous, *coulomb])
        _finish(row, joint, ("", "", ""))
        row[0].set_ylabel(_name(joint))
    for axes, text in zip(rows[0], ("torque [N m]", "net energy [J]", "coefficients [N m], [N m s/rad]"), strict=True):
        axes.set_title(text, loc="left")
    figure.supxlabel(f"Time [s], {title}", fontsize=7.5)
    add_legend(figure, max(found, key=len))
    figure.align_ylabels()
    return figure


def _within(limits: tuple[float, float], least: float, most: float) -> tuple[float, float]:
    """Return limits that reach at least so far to both sides, and at most so far."""
    most = max(most, least)
    return max(min(limits[0], -least), -most), min(max(limits[1], least), most)


def _name(joint: JointReplay) -> str:
    return joint_title(joint.joint, joint.name)


def _finish(panels: "Sequence[Axes]", joint: JointReplay, titles: tuple[str, ...]) -> None:
    """Shade the cycles, name the panels, and say where there is nothing to see."""
    for axes, text in zip(panels, titles, strict=True):
        shade_replay(axes, joint)
        label_panel(axes, text, across=6)
        if joint.reason and len(axes.lines) <= 1:
            axes.set_yticks([])
    reason = f"not replayed: {joint.reason.partition(';')[0]}" if joint.reason else ""
    middle = panels[len(panels) // 2]
    say_in_panel(middle, reason, characters=30 if len(panels) == len(("torque", "energy", "both")) else 44)
    if joint.replayed is not None and len(joint.replayed.t) < len(joint.without.t):
        for axes in panels:
            axes.axvline(joint.replayed.t[-1], color=BORDER, lw=0.8)
        panels[0].annotate("diverges", (joint.replayed.t[-1], 0.9), xycoords=("data", "axes fraction"), fontsize=6.5)


def shade_replay(axes: "Axes", joint: JointReplay) -> None:
    """Shade every other cycle of the compensator and end the axis with the log."""
    history = joint.history
    if history is not None and len(history.stop) <= MOST_SHADED:
        for start, stop in zip(history.start_s[::2], history.stop_s[::2], strict=True):
            axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0)
    axes.set_xlim(joint.without.t[0], joint.without.t[-1])


def _draw_velocity(axes: "Axes", joint: JointReplay) -> "list[Artist]":
    """Draw the velocity raw and filtered; return the legend's entries."""
    shown = joint.without if joint.replayed is None else joint.replayed
    if joint.simulated:
        t, signal = thin_extremes(joint.without.t, joint.without.dq, POINTS)
        axes.plot(t, signal, color=FITTED, lw=0.6, ls=DASHED, zorder=3)
    t, signal = thin_extremes(shown.t, shown.dq, POINTS)
    raw = axes.plot(t, signal, color=RAW, lw=0.5, label="raw", rasterized=True)
    t, signal = thin_extremes(shown.t, smooth(shown.t, shown.dq), POINTS)
    curve = axes.plot(t, signal, color=FILTERED, lw=0.7, label=f"filtered, {cutoff_hz(shown.t):.3g} Hz")
    reach = float(np.abs(joint.without.dq).max())
    axes.set_ylim(*_within(axes.get_ylim(), 0.0, MOST_OF_WITHOUT * max(reach, SMALLEST_SPEED_RAD_S)))
    return [*raw, *curve]


def _draw_torque(axes: "Axes", joint: JointReplay) -> "list[Artist]":
    """Draw the interaction torque with compensator raw and filtered, and without it filtered."""
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    handles: list[Artist] = []
    shown = joint.replayed
    if shown is not None and len(shown.t):
        t, signal = thin_extremes(shown.t, shown.interaction_nm, POINTS)
        handles += axes.plot(t, signal, color=RAW, lw=0.5, label="raw", rasterized=True)
        t, signal = thin_extremes(shown.t, smooth(shown.t, shown.interaction_nm), POINTS)
        label = f"filtered, {cutoff_hz(shown.t):.3g} Hz"
        handles += axes.plot(t, signal, color=FILTERED, lw=0.7, label=label, zorder=4)
    without = joint.without
    reach = float(np.abs(without.interaction_nm).max())
    t, signal = thin_extremes(without.t, smooth(without.t, without.interaction_nm), POINTS)
    curve = axes.plot(t, signal, color=FITTED, lw=0.6, ls=DASHED, label="without compensator", zorder=3)
    axes.set_ylim(*_within(axes.get_ylim(), SMALLEST_TORQUE_NM, MOST_OF_WITHOUT * reach))
    return [*handles, *curve]


def _draw_energy(axes: "Axes", joint: JointReplay) -> "list[Artist]":
    """Draw the net energy with and without the compensator, the ends of its cycles marked."""
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    without, shown, history = joint.without, joint.replayed, joint.history
    if shown is None or history is None:
        return []
    t, energy = thin_extremes(without.t, without.net_energy_j, POINTS)
    handles: list[Artist] = list(axes.plot(t, energy, color=FITTED, lw=0.8, ls=DASHED, label="without"))
    energy = shown.net_energy_j
    handles += axes.plot(*thin_extremes(shown.t, energy, POINTS), color=FILTERED, label="with compensator", zorder=4)
    dots = axes.plot(history.stop_s, energy[history.stop], "o", color=BORDER, ms=1.8, mew=0, zorder=5)
    dots[0].set_label("end of a cycle")
    return [*handles[1:], *dots]


def _draw_coefficient(axes: "Axes", joint: JointReplay, name: str, colour: str) -> "list[Artist]":
    """Draw the coefficient compensated over time; return the legend's entry."""
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    if joint.history is None or joint.replayed is None:
        return []
    t, value = applied(joint, name)
    axes.update_datalim([(t[0], LEAST_COEFFICIENT)])
    return list(axes.step(t, value, where="post", color=colour, lw=0.9, label=LABELS[name], zorder=3))


def applied(joint: JointReplay, name: str) -> tuple[Float, Float]:
    """Return times [s] and values of a coefficient compensated: steps, the last one up to where the replay ends.

    Args:
        joint: With a result.
        name: ``"coulomb_nm"`` or ``"viscous_nms_per_rad"``.
    """
    assert joint.history is not None
    assert joint.replayed is not None
    assert joint.last is not None
    kind, _, unit = name.partition("_")
    value = getattr(joint.history, f"{kind}_applied_{unit}")
    t = joint.replayed.t
    ends = np.concatenate([t[:1], joint.history.stop_s, t[-1:]])
    last = getattr(joint.last, name)
    return ends, np.concatenate([value, [last, last]])


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
