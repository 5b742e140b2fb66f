"""LogReplay -> the paper's Fig. 10 for any log: signals, net energy, coefficients, with and without a compensator."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.series import MOST_SHADED, shade_stretches

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from friction_audit.compensation.result import JointReplay, Signals
    from friction_audit.pipeline import LogReplay

POINTS = 4000  # of a curve: more than a column has pixels
LEAST_COEFFICIENT = 0.05  # least height of the panel of the coefficients, which may all be zero [N m, N m s/rad]
SMALLEST_TORQUE_NM = 0.5  # half height of the torque panel of a joint at rest, whose noise would fill it
SMALLEST_SPEED_RAD_S = 0.1  # half width of the panel of a joint that stands still
MOST_OF_WITHOUT = 3.0  # times the largest speed and torque without a compensator beyond which a diverging one is cut
WITHOUT: dict[str, Any] = {"color": theme.FITTED, "ls": theme.DASHED}


@theme.figure_style()
def draw_replay(found: "LogReplay", joint: parts.Numbers) -> "Figure":
    """Draw one joint at column width, or every joint that was replayed on a sheet, a row for each."""
    joints, sheet, note = parts.choose(found.replay.joints, joint, lambda one: not one.reason, "not replayed")
    title = f"{found.replay.counterfactual.title}{note}"
    figure = _draw_sheet(joints, title) if sheet else _draw_column(joints[0], title)
    figure.align_ylabels()
    return figure


def _draw_column(joint: "JointReplay", title: str) -> "Figure":
    figure = parts.new_figure(theme.COLUMN_IN, 5.6)
    panels = figure.subplots(5, 1, sharex=True)
    _draw_velocity(panels[0], joint)
    _draw_torque(panels[1], joint)
    _draw_energy(panels[2], joint)
    _draw_coefficient(panels[3], joint, "viscous_nms_per_rad", theme.FILTERED, "")
    _draw_coefficient(panels[4], joint, "coulomb_nm", theme.DISSIPATED, "")
    names = ("Velocity\n[rad/s]", "Torque\n[N m]", "Energy [J]", "Viscous\n[N m s/rad]", "Coulomb\n[N m]")
    for axes, label in zip(panels, names, strict=True):
        parts.label_panel(
            axes,
            f"{parts.joint_title(joint.joint, joint.name)}, {title}" if axes is panels[0] else "",
            y=label,
            across=6,
        )
    _finish(panels, joint, characters=44)
    parts.add_legend(figure)
    panels[4].set_xlabel("Time [s]")
    return figure


def _draw_sheet(joints: "Sequence[JointReplay]", title: str) -> "Figure":
    figure = parts.new_figure(theme.SHEET_IN, 0.9 + len(joints))
    rows = figure.subplots(len(joints), 4, squeeze=False, sharex=True)
    for row, joint in zip(rows, joints, strict=True):
        _draw_torque(row[0], joint)
        _draw_energy(row[1], joint)
        _draw_coefficient(row[2], joint, "coulomb_nm", theme.DISSIPATED, "")
        _draw_coefficient(row[3], joint, "viscous_nms_per_rad", theme.FILTERED, "")
        for axes in row:
            parts.label_panel(axes, across=4)
        row[0].set_ylabel(parts.joint_title(joint.joint, joint.name))
        _finish(row, joint, characters=30)
    for axes, text in zip(
        rows[0], ("torque [N m]", "net energy [J]", "Coulomb [N m]", "viscous [N m s/rad]"), strict=True
    ):
        axes.set_title(text, loc="left")
    figure.supxlabel(f"Time [s], {title}")
    parts.add_legend(figure)
    return figure


def _finish(panels: "Sequence[Axes]", joint: "JointReplay", *, characters: int) -> None:
    """Shade the compensator's cycles; say where there is nothing to see, and where the loop diverges."""
    for axes in panels:
        history = joint.history
        few = history is not None and len(history.stop) <= MOST_SHADED
        starts, stops = (history.start_s, history.stop_s) if few and history is not None else ((), ())
        shade_stretches(axes, starts, stops, joint.without.t)
        if joint.reason and len(axes.lines) <= 1:
            axes.set_yticks([])
    reason = f"not replayed: {joint.reason.partition(';')[0]}" if joint.reason else ""
    parts.write_message(panels[len(panels) // 2], reason, characters=characters)
    if joint.replayed is not None and len(joint.replayed.t) < len(joint.without.t):
        for axes in panels:
            axes.axvline(joint.replayed.t[-1], color=theme.BORDER, lw=0.8)
        panels[0].annotate("diverges", (joint.replayed.t[-1], 0.9), xycoords=("data", "axes fraction"), fontsize=6.5)


def _within(limits: tuple[float, float], least: float, most: float) -> tuple[float, float]:
    """Return limits that reach at least so far to both sides, and at most so far."""
    most = max(most, least)
    return max(min(limits[0], -least), -most), min(max(limits[1], least), most)


def _draw_velocity(axes: "Axes", joint: "JointReplay") -> None:
    shown = joint.without if joint.replayed is None else joint.replayed
    if joint.simulated:
        parts.draw_curve(axes, joint.without.t, joint.without.dq, POINTS, lw=0.6, zorder=3, **WITHOUT)
    parts.draw_raw_and_filtered(axes, shown.t, shown.dq, POINTS)
    reach = float(np.abs(joint.without.dq).max())
    axes.set_ylim(*_within(axes.get_ylim(), 0.0, MOST_OF_WITHOUT * max(reach, SMALLEST_SPEED_RAD_S)))


def _draw_torque(axes: "Axes", joint: "JointReplay") -> None:
    """Draw the interaction torque with compensator raw and filtered, and without it filtered."""
    parts.mark_zero(axes)
    shown, without = joint.replayed, joint.without
    if shown is not None and len(shown.t):
        parts.draw_raw_and_filtered(axes, shown.t, shown.interaction_nm, POINTS, zorder=4, label="with compensator")
    torque = parts.smooth(without.t, without.interaction_nm)
    parts.draw_curve(axes, without.t, torque, POINTS, lw=0.6, zorder=3, label="without compensator", **WITHOUT)
    reach = float(np.abs(without.interaction_nm).max())
    axes.set_ylim(*_within(axes.get_ylim(), SMALLEST_TORQUE_NM, MOST_OF_WITHOUT * reach))


def _draw_energy(axes: "Axes", joint: "JointReplay") -> None:
    """Draw the net energy with and without the compensator, the ends of its cycles marked."""
    parts.mark_zero(axes)
    without, shown, history = joint.without, joint.replayed, joint.history
    if shown is None or history is None:
        return
    parts.draw_curve(axes, without.t, without.net_energy_j, POINTS, lw=0.8, **WITHOUT)
    energy = shown.net_energy_j
    parts.draw_curve(axes, shown.t, energy, POINTS, color=theme.FILTERED, label="with compensator", zorder=4)
    ends = history.stop
    axes.plot(history.stop_s, energy[ends], "o", color=theme.BORDER, ms=1.8, mew=0, zorder=5, label="end of a cycle")


def _draw_coefficient(axes: "Axes", joint: "JointReplay", name: str, colour: str, label: str) -> None:
    """Draw the coefficient compensated over time."""
    parts.mark_zero(axes)
    if joint.history is not None and joint.replayed is not None:
        t, value = applied(joint, name)
        axes.update_datalim([(t[0], LEAST_COEFFICIENT)])
        axes.step(t, value, where="post", color=colour, lw=0.9, label=label or None, zorder=3)


def applied(joint: "JointReplay", name: str) -> tuple[Float, Float]:
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


RAW_WITHOUT = "#f6cfb0"  # as pale to FITTED as RAW is to FILTERED
DOTS, LOOP_POINTS, POINTS_PER_PERIOD = 8000, 12_000, 10


@theme.figure_style()
def draw_replay_velocity_torque(found: "LogReplay", joint: parts.Numbers) -> "Figure":
    """Draw torque over velocity of one joint at column width, or of every joint that was replayed on a sheet."""
    joints, sheet, note = parts.choose(found.replay.joints, joint, lambda one: not one.reason, "not replayed")
    figure, panels = parts.grid([1.75 if sheet else 2.3] * len(joints), sheet=sheet, across=4, head_in=0.6)
    for axes, one in zip(panels, joints, strict=True):
        _draw_loops(axes, one)
    parts.add_legend(figure)
    figure.supxlabel(f"Velocity [rad/s], {found.replay.counterfactual.title}{note}")
    figure.supylabel("Interaction torque [N m]")
    return figure


def draw_panel(axes: "Axes", found: "LogReplay", joint: int) -> None:
    """Draw torque over velocity of one joint into axes, and name them."""
    (one,) = parts.chosen_joints(found.replay.joints, joint)
    _draw_loops(axes, one)
    axes.set(xlabel="Velocity [rad/s]", ylabel="Interaction torque [N m]")


def _draw_loops(axes: "Axes", joint: "JointReplay") -> None:
    parts.mark_zero(axes, x=True, zorder=0)
    without, shown = joint.without, joint.replayed
    _draw_loop(axes, without, 0, (RAW_WITHOUT, theme.FITTED), "without")
    speeds = [float(np.abs(one.dq).max()) for one in (without, shown) if one is not None]
    reach = min(1.05 * max(speeds), MOST_OF_WITHOUT * max(speeds[0], SMALLEST_SPEED_RAD_S))
    reach = max(reach, SMALLEST_SPEED_RAD_S)
    axes.set_xlim(-reach, reach)
    parts.label_panel(axes, parts.joint_title(joint.joint, joint.name), across=4)
    if shown is None or joint.history is None:
        parts.write_message(axes, f"not replayed: {joint.reason.partition(';')[0]}", characters=24)
        return
    # Until the compensator has its first estimate the curve is the one without it.
    active = np.flatnonzero(shown.compensation_nm)
    start = max([0, *joint.history.stop[:1].tolist(), *active[:1].tolist()])
    _draw_loop(axes, shown, start, (theme.RAW, theme.FILTERED), "with")
    if len(shown.t) < len(without.t):
        most = MOST_OF_WITHOUT * float(np.abs(without.interaction_nm).max())
        axes.set_ylim(-most, most)
        axes.annotate("diverges", (0.03, 0.03), xycoords="axes fraction", fontsize=6.5)


def _draw_loop(axes: "Axes", signals: "Signals", start: int, colours: tuple[str, str], name: str) -> None:
    """Draw torque over velocity from a sample on, raw and filtered."""
    t, dq, torque = signals.t[start:], signals.dq[start:], signals.interaction_nm[start:]
    if len(t) < 2:  # noqa: PLR2004
        return
    thin = parts.every_nth(len(t), DOTS)
    parts.draw_dots(axes, dq[thin], torque[thin], colours[0], f"{name}, raw")
    step = max(1, int(parts.median_rate_hz(t) / (POINTS_PER_PERIOD * parts.CUTOFF_HZ)), len(t) // LOOP_POINTS)
    curve = [parts.smooth(t, one)[::step] for one in (dq, torque)]
    label = f"{name}, {parts.cutoff_hz(t):.3g} Hz"
    axes.plot(*curve, color=colours[1], lw=0.4, rasterized=True, label=label)
