"""LogReplay -> the paper's Fig. 10 for any log: signals, net energy, coefficients, with and without a compensator."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from friction_audit.compensation.result import JointReplay, Signals
from friction_audit.joint_log import median_step
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.figures.estimate import MOST_SHADED, POINTS_PER_PERIOD, SMALLEST_SPEED_RAD_S

POINTS = 4000  # of a curve: more than a column has pixels
LEAST_COEFFICIENT = 0.05  # least height of the panel of the coefficients, which may all be zero [N m, N m s/rad]
SMALLEST_TORQUE_NM = 0.5  # half height of the torque panel of a joint at rest, whose noise would fill it
MOST_OF_WITHOUT = 3.0  # times the largest speed and torque without a compensator beyond which a diverging one is cut
WITH = "with compensator"
WITHOUT: dict[str, Any] = {"color": theme.FITTED, "ls": theme.DASHED}


def _draw_over_time(panels: Sequence[Axes], _: LogReplay, joint: JointReplay) -> None:
    narrow, title = parts.is_narrow(panels[0]), panels[0].get_title(loc="left")
    for axes, (name, draw) in zip(panels, list(PANELS.items())[-len(panels) :], strict=True):
        draw(axes, joint)
        heads = axes is panels[0] if narrow else axes.get_subplotspec().is_first_row()  # type: ignore[union-attr]
        head = title if narrow else name.replace("\n", " ")
        parts.label_panel(axes, head if heads else "", y=name if narrow else "", across=6 if narrow else 4)
        axes.set_xlim(joint.without.t[0], joint.without.t[-1])
        if joint.history is not None and len(joint.history.stop) <= MOST_SHADED:
            parts.shade_stretches(axes, joint.history.start_s, joint.history.stop_s)
        if joint.reason and len(axes.lines) <= 1:
            axes.set_yticks([])
        if joint.replayed is not None and len(joint.replayed.t) < len(joint.without.t):
            end = joint.replayed.t[-1]
            axes.axvline(end, color=theme.BORDER, lw=0.8)
            if axes is panels[0]:
                axes.annotate("diverges", (end, 0.9), xycoords=("data", "axes fraction"), fontsize=6.5)
    if not narrow:
        panels[0].set_ylabel(title)
    parts.write_reason(panels[len(panels) // 2], "not replayed", joint.reason, characters=44 if narrow else 30)


def _limit(axes: Axes, least: float, most: float) -> None:
    """Let the y axis reach at least so far to both sides, and at most so far."""
    (low, high), most = axes.get_ylim(), max(most, least)
    axes.set_ylim(max(min(low, -least), -most), min(max(high, least), most))


def _draw_velocity(axes: Axes, joint: JointReplay) -> None:
    shown = joint.without if joint.replayed is None else joint.replayed
    if joint.simulated:
        parts.draw_curve(axes, joint.without.t, joint.without.dq, POINTS, lw=0.6, zorder=3, **WITHOUT)
    look = {} if joint.replayed is None else {"label": WITH}
    parts.draw_raw_and_filtered(axes, shown.t, shown.dq, POINTS, **look)
    _limit(axes, 0.0, MOST_OF_WITHOUT * max(float(np.abs(joint.without.dq).max()), SMALLEST_SPEED_RAD_S))


def _draw_torque(axes: Axes, joint: JointReplay) -> None:
    parts.mark_zero(axes)
    shown, without = joint.replayed, joint.without
    if shown is not None and len(shown.t):
        parts.draw_raw_and_filtered(axes, shown.t, shown.interaction_nm, POINTS, zorder=4, label=WITH)
    torque = parts.smooth(without.t, without.interaction_nm)
    parts.draw_curve(axes, without.t, torque, POINTS, lw=0.6, zorder=3, label="without compensator", **WITHOUT)
    _limit(axes, SMALLEST_TORQUE_NM, MOST_OF_WITHOUT * float(np.abs(without.interaction_nm).max()))


def _draw_energy(axes: Axes, joint: JointReplay) -> None:
    parts.mark_zero(axes)
    without, shown, history = joint.without, joint.replayed, joint.history
    if shown is None or history is None:
        return
    parts.draw_curve(axes, without.t, without.net_energy_j, POINTS, lw=0.8, **WITHOUT)
    energy = shown.net_energy_j
    parts.draw_curve(axes, shown.t, energy, POINTS, color=theme.FILTERED, label=WITH, zorder=4)
    dots: theme.Look = {"color": theme.BORDER, "ms": 1.8, "mew": 0, "zorder": 5, "label": "end of a cycle"}
    axes.plot(history.stop_s, energy[history.stop], "o", **dots)


def _draw_coefficient(axes: Axes, joint: JointReplay, name: str, colour: str) -> None:
    """Draw the coefficient compensated over time: steps, the last one up to where the replay ends."""
    parts.mark_zero(axes)
    if joint.history is None or joint.replayed is None or joint.last is None:
        return
    kind, _, unit = name.partition("_")
    t, last = joint.replayed.t, getattr(joint.last, name)
    ends = np.concatenate([t[:1], joint.history.stop_s, t[-1:]])
    value = np.concatenate([getattr(joint.history, f"{kind}_applied_{unit}"), [last, last]])
    axes.update_datalim([(t[0], LEAST_COEFFICIENT)])
    axes.step(ends, value, where="post", color=colour, lw=0.9, zorder=3)


PANELS: dict[str, Callable[..., None]] = {
    "Velocity\n[rad/s]": _draw_velocity,
    "Torque\n[N m]": _draw_torque,
    "Energy [J]": _draw_energy,
    "Viscous\n[N m s/rad]": partial(_draw_coefficient, name="viscous_nms_per_rad", colour=theme.FILTERED),
    "Coulomb\n[N m]": partial(_draw_coefficient, name="coulomb_nm", colour=theme.DISSIPATED),
}

REPLAY = parts.Layout(
    joints=lambda found: found.replay.joints, has=lambda _, joint: not joint.reason, lacks="not replayed",
    draw=_draw_over_time, panels=lambda _, __, sheet: 4 if sheet else 5, height_in=(1.0, 0.95), head_in=0.9,
    x=lambda found: f"Time [s], {found.replay.counterfactual.code}", shared="all",
)  # fmt: skip

RAW_WITHOUT = "#f6cfb0"  # as pale to FITTED as RAW is to FILTERED
DOTS, LOOP_POINTS = 8000, 12_000


def _draw_loops(panels: Sequence[Axes], _: LogReplay, joint: JointReplay) -> None:
    (axes,) = panels
    parts.mark_zero(axes, x=True, zorder=0)
    without, shown = joint.without, joint.replayed
    _draw_loop(axes, without, 0, (RAW_WITHOUT, theme.FITTED), "without")
    speeds = [float(np.abs(one.dq).max()) for one in (without, shown) if one is not None]
    reach = min(1.05 * max(speeds), MOST_OF_WITHOUT * max(speeds[0], SMALLEST_SPEED_RAD_S))
    reach = max(reach, SMALLEST_SPEED_RAD_S)
    axes.set_xlim(-reach, reach)
    axes.locator_params(axis="x", nbins=4)
    if shown is None or joint.history is None:
        parts.write_reason(axes, "not replayed", joint.reason, characters=24)
        return
    # Until the compensator has its first estimate the curve is the one without it.
    active = np.flatnonzero(shown.compensation_nm)
    start = max([0, *joint.history.stop[:1].tolist(), *active[:1].tolist()])
    _draw_loop(axes, shown, start, (theme.RAW, theme.FILTERED), "with")
    if len(shown.t) < len(without.t):
        most = MOST_OF_WITHOUT * float(np.abs(without.interaction_nm).max())
        axes.set_ylim(-most, most)
        axes.annotate("diverges", (0.03, 0.03), xycoords="axes fraction", fontsize=6.5)


def _draw_loop(axes: Axes, signals: Signals, start: int, colours: tuple[str, str], name: str) -> None:
    t, dq, torque = signals.t[start:], signals.dq[start:], signals.interaction_nm[start:]
    if len(t) < 2:  # noqa: PLR2004
        return
    thin = parts.every_nth(len(t), DOTS)
    parts.draw_dots(axes, dq[thin], torque[thin], colours[0], f"{name}, raw")
    step = max(1, int(1.0 / median_step(t) / (POINTS_PER_PERIOD * parts.CUTOFF_HZ)), len(t) // LOOP_POINTS)
    curve = [parts.smooth(t, one)[::step] for one in (dq, torque)]
    label = f"{name}, {parts.cutoff_hz(t):.3g} Hz"
    axes.plot(*curve, color=colours[1], lw=0.4, rasterized=True, label=label)


REPLAY_VELOCITY_TORQUE = replace(
    REPLAY, draw=_draw_loops, panels=1, across=4, height_in=(1.75, 2.3), head_in=0.6, shared=False,
    x=lambda found: f"Velocity [rad/s], {found.replay.counterfactual.code}", y="Interaction torque [N m]",
)  # fmt: skip
