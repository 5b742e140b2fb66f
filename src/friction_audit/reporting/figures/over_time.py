"""Estimate -> figures over time: signals, net energy, friction coefficients."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.series import JointSeries, choose_series, estimated, shade_cycles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from friction_audit.pipeline import Estimate

POINTS = 6000  # of a curve: a page is 2100 dots wide at 300 dots per inch, so nothing can be lost
GAP_PERIODS = 20  # sampling periods without a sample after which no line is drawn


@theme.figure_style()
def draw_signals(estimate: "Estimate", joint: parts.Numbers) -> "Figure":
    """Draw velocity and torque of one joint above each other, or every joint that moved on a sheet, a row for each."""
    joints, sheet, note = choose_series(estimate, joint)
    figure, rows = parts.pairs(len(joints), sheet=sheet)
    for row, series in zip(rows, joints, strict=True):
        signals = ((series.dq, "Velocity [rad/s]", series.title), (series.torque, "Torque [N m]", ""))
        for axes, (signal, label, title) in zip(row, signals, strict=True):
            shade_cycles(axes, series)
            _draw_signal(axes, series.t, signal)
            axes.set_xlim(series.t[0], series.t[-1])
            parts.label_panel(axes, title, y=label)
    parts.add_legend(figure)
    figure.align_ylabels()
    figure.supxlabel(f"Time [s]{note}")
    return figure


def _draw_signal(axes: "Axes", t: Float, signal: Float) -> None:
    """Draw a signal raw and filtered, with gaps where the log has some."""
    filtered = f"filtered, {parts.cutoff_hz(t):.3g} Hz"
    for values, colour, width, label in (
        (signal, theme.RAW, 0.5, "raw"),
        (parts.smooth(t, signal), theme.FILTERED, 0.7, filtered),
    ):
        stamps, kept = parts.thin_extremes(t, values, POINTS)
        longest_s = GAP_PERIODS / parts.median_rate_hz(t) + 2 * (t[-1] - t[0]) / len(stamps)
        whole = parts.break_at_gaps(stamps, kept, longest_s)
        axes.plot(stamps, whole, color=colour, lw=width, label=label, rasterized=True)


CYCLES_ZOOMED = 40  # cycles of a long log that are drawn apart: the shortest are then still a millimetre wide
SMALLEST_ENERGY_J = 0.01  # half height of the panel of a joint that stands still


@theme.figure_style()
def draw_energy(estimate: "Estimate", joint: parts.Numbers) -> "Figure":
    """Draw the net energy of one joint or of those that moved on a sheet; of a long log its first cycles apart."""
    joints, sheet, note = choose_series(estimate, joint)
    if any(series.is_crowded for series in joints):
        figure = _draw_long(joints)
    else:
        figure, panels = parts.grid([1.4 if sheet else 1.8] * len(joints), sheet=sheet, across=2, head_in=0.6)
        for axes, series in zip(panels, joints, strict=True):
            _draw_cycles(axes, series)
            parts.label_panel(axes, series.title)
            parts.write_message(axes, series.not_determined)
    parts.add_legend(figure, ("net energy", "dissipated, per cycle", "zero velocity"))
    figure.supxlabel(f"Time [s]{note}")
    figure.supylabel("Net energy [J]")
    return figure


def _draw_long(joints: tuple[JointSeries, ...]) -> "Figure":
    """Draw the whole log and its first cycles: side by side on a sheet, below each other for one joint."""
    alone = len(joints) == 1
    figure = parts.new_figure(*((theme.COLUMN_IN, 3.6) if alone else (theme.SHEET_IN, 0.6 + 1.15 * len(joints))))
    rows = figure.subplots(2, 1, squeeze=False).T if alone else figure.subplots(len(joints), 2, squeeze=False)
    for (whole, zoomed), series in zip(rows, joints, strict=True):
        part = series.first_cycles(CYCLES_ZOOMED)
        _draw_net_energy(whole, series)
        parts.label_panel(whole, series.title)
        parts.write_message(whole, series.not_determined)
        if not len(part.cycles.joint):
            zoomed.remove()
            continue
        where = f"part drawn {'below' if alone else 'on the right'}"
        whole.axvspan(part.t[0], part.t[-1], facecolor=theme.ZOOMED, linewidth=0, zorder=0, label=where)
        _draw_cycles(zoomed, part)
        parts.label_panel(zoomed, f"cycles 1 to {len(part.cycles.joint)} of {len(series.cycles.joint)}")
    return figure


def _draw_cycles(axes: "Axes", series: JointSeries) -> None:
    """Draw the net energy, shade the cycles and mark their borders."""
    shade_cycles(axes, series)
    energy = _draw_net_energy(axes, series)
    cycles = series.cycles
    if not len(cycles.start):
        return
    edges, stairs = dissipated_stairs(series)
    # The last step holds until the log ends.
    held = np.append(edges, max(series.t[-1], edges[-1])), np.append(stairs, stairs[-1])
    axes.step(*held, where="post", color=theme.DISSIPATED, lw=0.9, label="dissipated, per cycle")
    borders = np.concatenate([cycles.start[:1], cycles.stop])
    axes.plot(
        series.t[borders], energy[borders], "o", color=theme.BORDER, ms=2.0, mew=0, zorder=5, label="zero velocity"
    )


def _draw_net_energy(axes: "Axes", series: JointSeries) -> Float:
    energy = series.net_energy_j
    axes.set_xlim(series.t[0], series.t[-1])
    if np.ptp(energy) < SMALLEST_ENERGY_J:
        axes.set_ylim(-SMALLEST_ENERGY_J, SMALLEST_ENERGY_J)
    parts.draw_curve(axes, series.t, energy, 20_000, color=theme.FILTERED, lw=0.9, label="net energy")
    return energy


def dissipated_stairs(series: JointSeries) -> tuple[Float, Float]:
    """Return the borders of the cycles [s] and what friction took up to each of them [J]."""
    cycles = series.cycles
    edges = np.concatenate([cycles.start_s[:1], cycles.stop_s])
    return edges, np.concatenate([np.zeros(min(len(edges), 1)), np.cumsum(cycles.dissipated_j)])


UNSETTLED = 10.0  # times the median width beyond which an interval, of early windows of one speed, stretches no panel
NEAR = 1.5  # times the range of the values that bands may reach beyond it; there they are cut
SMALLEST_SHARE, SMALLEST_RANGE = 0.02, 1e-6  # of the value, and of all: a panel is never higher resolved


@theme.figure_style()
def draw_coefficients(estimate: "Estimate", joint: parts.Numbers) -> "Figure":
    """Draw Coulomb and viscous friction of one joint above each other, or every joint on a sheet, a row for each."""
    joints, sheet, note = choose_series(estimate, joint, estimated)
    figure, rows = parts.pairs(len(joints), sheet=sheet)
    windows = sorted({min(series.friction.window, series.friction.cycles) for series in joints})
    cycles = " to ".join(str(one) for one in dict.fromkeys((windows[0], windows[-1])))
    window = "last cycle" if cycles == "1" else f"last {cycles} cycles"
    cut = False
    for row, series in zip(rows, joints, strict=True):
        friction, history = series.friction, series.friction.history
        coulomb = (history.coulomb_nm, history.coulomb_low_nm, history.coulomb_high_nm)
        viscous = (history.viscous_nms_per_rad, history.viscous_low_nms_per_rad, history.viscous_high_nms_per_rad)
        parts.label_panel(row[0], series.title, y="Coulomb [N m]")
        parts.label_panel(row[1], "", y="Viscous [N m s/rad]")
        for axes, values, whole in zip(row, (coulomb, viscous), (friction.coulomb, friction.viscous), strict=True):
            axes.set_xlim(series.t[0], series.t[-1])
            ends = y_limits(*values, whole)
            if ends is None:
                axes.set_yticks([])
                parts.write_message(axes, series.not_determined or _absence(friction, axes.get_ylabel()))
                continue
            axes.set_ylim(*ends)
            bounds = np.concatenate([*values[1:], [whole.low, whole.high]])
            cut |= bool((bounds < ends[0]).any() or (bounds > ends[1]).any())
            _draw_coefficient(axes, np.append(history.stop_s, series.t[-1]), values, whole, window)
    for axes in figure.axes:
        for found in axes.collections:
            found.set_label("95 % interval, clipped" if cut else "95 % interval")
    parts.add_legend(figure, (window, "95 % interval", "95 % interval, clipped"))
    figure.align_ylabels()
    figure.supxlabel(f"Time [s]{note}")
    return figure


def _draw_coefficient(
    axes: "Axes", t: Float, values: tuple[Float, Float, Float], whole: Coefficient, window: str
) -> None:
    """Draw one coefficient as steps that hold until the next, with its band, and its whole-log value."""
    if np.isfinite(values[0]).any():
        middle, low, high = (np.append(column, column[-1]) for column in values)
        t = np.maximum.accumulate(t)
        axes.step(t, middle, where="post", color=theme.FILTERED, label=window)
        parts.band(axes, t, low, high, theme.FILTERED, "95 % interval", step="post", alpha=0.22)
    if np.isfinite(whole.value):
        axes.axhline(whole.value, color=theme.FITTED, lw=0.9, ls=theme.DASHED, label="whole log")
    if np.isfinite(whole.low + whole.high):
        axes.axhspan(whole.low, whole.high, color=theme.FITTED, alpha=0.18, lw=0, label="95 %, whole log")


def y_limits(value: Float, low: Float, high: Float, whole: Coefficient) -> tuple[float, float] | None:
    """Return limits that show the values and the whole-log interval, and of the bands as much as is near.

    Args:
        value: Coefficient after each cycle, shape (m,); NaN where there is none.
        low: Lower end of its interval, shape (m,).
        high: Upper end, shape (m,).
        whole: The coefficient over the whole log.
    """
    width = high - low
    known = width[np.isfinite(width)]
    settled = ~(width > UNSETTLED * np.median(known)) if len(known) else np.isfinite(value)
    shown = np.concatenate([value[settled], [whole.value, whole.low, whole.high]])
    largest = float(np.nanmax(np.abs(shown), initial=0.0))
    smallest = max(SMALLEST_SHARE * largest, SMALLEST_RANGE)
    return parts.limits(shown, np.concatenate([low, high]), near=NEAR, smallest=smallest)


def _absence(friction: JointFriction, label: str) -> str:
    """Return why one coefficient is missing where the other is there."""
    fitted = friction.model == "combined" or label.lower().startswith(friction.model)
    return "not determined" if fitted else f"not in the {friction.model} model"
