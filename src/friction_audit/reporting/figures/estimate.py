"""Estimate -> the series of a joint; signals, net energy and coefficients over time, torque over velocity."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from friction_audit.friction.history import UNITS, Band, Coefficient, JointFriction
from friction_audit.joint_log import Float, median_step
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.words import count_of

MOST_SHADED = 80  # cycles in one panel above which stripes would only be grey


class JointSeries(NamedTuple):
    """One joint's signals of shape (n,), and its cycles, whose start and stop are indices into them."""

    t: Float  # [s]
    dq: Float  # velocity [rad/s]
    torque: Float  # interaction torque F_m [N m]
    driving: Float  # what acts against friction and inertia: F_m and the torque of a logged compensator [N m]
    cycles: EnergyCycles


def series_of(estimate: Estimate, friction: JointFriction) -> JointSeries:
    """Return the series of a joint."""
    seen, cycles = estimate.interaction, estimate.cycles
    column = seen.joint_numbers.index(friction.joint)
    return JointSeries(seen.t, seen.dq[:, column], seen.torque[:, column], seen.driving(column), cycles[column])


def shade_cycles(axes: Axes, series: JointSeries) -> None:
    """Shade every other cycle of a joint and hatch the rejected ones; end the axis with the signals."""
    cycles = series.cycles
    axes.set_xlim(series.t[0], series.t[-1])
    if len(cycles.start) > MOST_SHADED:
        axes.plot([], [], " ", label=f"more than {MOST_SHADED} cycles are not shaded")
        return
    for row, (start, stop, reason) in enumerate(zip(cycles.start_s, cycles.stop_s, cycles.reason, strict=True)):
        if reason:
            look: theme.Look = {"facecolor": "none", "edgecolor": theme.REJECTED, "hatch": "/////"}
            axes.axvspan(start, stop, linewidth=0, zorder=0, label="rejected cycle", **look)
        elif row % 2 == 0:
            axes.axvspan(start, stop, facecolor=theme.SHADE, linewidth=0, zorder=0, label="every other cycle")


POINTS = 6000  # of a curve: a page is 2100 dots wide at 300 dots per inch, so nothing can be lost


def _draw_signals(panels: Sequence[Axes], estimate: Estimate, friction: JointFriction) -> None:
    series = series_of(estimate, friction)
    signals = ((series.dq, "Velocity [rad/s]"), (series.torque, "Torque [N m]"))
    for axes, (signal, label) in zip(panels, signals, strict=True):
        shade_cycles(axes, series)
        parts.draw_raw_and_filtered(axes, series.t, signal, POINTS, rasterized=True)
        axes.set_ylabel(label)


SIGNALS = parts.Layout(
    joints=lambda estimate: estimate.friction.joints, lacks="did not move", draw=_draw_signals, panels=2,
    has=lambda _, friction: friction.moving_s > 0.0 or not friction.reason, height_in=(1.15, 1.3), head_in=0.6,
    x="Time [s]", shared=True,
)  # fmt: skip

SMALLEST_ENERGY_J = 0.01  # half height of the panel of a joint that stands still


def _draw_energy(panels: Sequence[Axes], estimate: Estimate, friction: JointFriction) -> None:
    from scipy.integrate import cumulative_trapezoid

    (axes,), series = panels, series_of(estimate, friction)
    shade_cycles(axes, series)
    cycles = series.cycles
    power = cumulative_trapezoid(series.torque * series.dq, series.t, initial=0)
    energy = power - power[cycles.start[0] if len(cycles.start) else 0]  # zero at the first cycle's start
    if np.ptp(energy) < SMALLEST_ENERGY_J:
        axes.set_ylim(-SMALLEST_ENERGY_J, SMALLEST_ENERGY_J)
    parts.draw_curve(axes, series.t, energy, 20_000, color=theme.FILTERED, lw=0.9, label="net energy")
    if len(cycles.start):
        edges = np.concatenate([cycles.start_s[:1], cycles.stop_s])
        stairs = np.concatenate([[0.0], np.cumsum(cycles.sums.dissipated_j)])
        # The last step holds until the log ends.
        held = np.append(edges, max(series.t[-1], edges[-1])), np.append(stairs, stairs[-1])
        axes.step(*held, where="post", color=theme.DISSIPATED, lw=0.9, label="dissipated, per cycle")
        borders = np.concatenate([cycles.start[:1], cycles.stop])
        dots: theme.Look = {"color": theme.BORDER, "ms": 2.0, "mew": 0, "zorder": 5, "label": "zero velocity"}
        axes.plot(series.t[borders], energy[borders], "o", **dots)
    parts.write_reason(axes, "not determined", friction.reason)


ENERGY = replace(
    SIGNALS, draw=_draw_energy, panels=1, across=2, height_in=(1.4, 1.8), y="Net energy [J]", shared=False,
    legend=("net energy", "dissipated, per cycle", "zero velocity"),
)  # fmt: skip

UNSETTLED = 10.0  # times the median width beyond which an interval, of early windows of one speed, stretches no panel
NEAR = 1.5  # times the range of the values that bands may reach beyond it; there they are cut
SMALLEST_SHARE, SMALLEST_RANGE = 0.02, 1e-6  # of the value, and of all: a panel is never higher resolved
WINDOW, INTERVAL = "moving window", "95 % interval"


def _draw_coefficients(panels: Sequence[Axes], estimate: Estimate, friction: JointFriction) -> None:
    """Draw Coulomb and viscous friction as steps that hold until the next, with their bands, and of the whole log."""
    series, history = series_of(estimate, friction), friction.history
    window = f"window: {count_of(min(friction.window, friction.cycles), 'cycle')}"
    title = window if friction.method == "energy" else "from torque regression"
    panels[-1].set_title(title * (not friction.reason), loc="right", color=theme.MUTED)
    t = np.maximum.accumulate(np.append(history.stop_s, series.t[-1]))
    for axes, name, label in zip(panels, UNITS, ("Coulomb [N m]", "Viscous [N m s/rad]"), strict=True):
        band, whole = getattr(history, name), getattr(friction, name)
        axes.set_ylabel(label)
        axes.set_xlim(series.t[0], series.t[-1])
        ends = y_limits(band, whole)
        if ends is None:
            axes.set_yticks([])
            fitted = friction.model in ("combined", name)
            absence = "not determined" if fitted else f"not in the {friction.model} model"
            parts.write_message(axes, "" if friction.reason else absence)
            parts.write_reason(axes, "not determined", friction.reason)
            continue
        axes.set_ylim(*ends)
        middle, low, high = band
        if np.isfinite(middle).any():
            axes.step(t, np.append(middle, middle[-1]), where="post", color=theme.FILTERED, label=WINDOW)
            interval = INTERVAL * bool(np.isfinite(low).any())  # the paper's estimator has none
            axes.stairs(high, t, baseline=low, fill=True, color=theme.FILTERED, alpha=0.22, lw=0, label=interval)
        if np.isfinite(whole.value):
            axes.axhline(whole.value, color=theme.FITTED, lw=0.9, ls=theme.DASHED, label="whole log")
        if np.isfinite(whole.low + whole.high):
            axes.axhspan(whole.low, whole.high, color=theme.FITTED, alpha=0.18, lw=0, label="95 %, whole log")


def y_limits(band: Band, whole: Coefficient) -> tuple[float, float] | None:
    """Return limits that show the values, NaN for none, the whole-log interval, and of the bands what is near."""
    value, low, high = band
    width = high - low
    known = width[np.isfinite(width)]
    settled = ~(width > UNSETTLED * np.median(known)) if len(known) else np.isfinite(value)
    shown = np.concatenate([value[settled], [whole.value, whole.low, whole.high]])
    smallest = max(SMALLEST_SHARE * float(np.nanmax(np.abs(shown), initial=0.0)), SMALLEST_RANGE)
    return parts.limits(shown, np.concatenate([low, high]), near=NEAR, smallest=smallest)


COEFFICIENTS = replace(
    SIGNALS, has=lambda _, friction: not friction.reason, lacks="no estimate", draw=_draw_coefficients,
    legend=(WINDOW, INTERVAL),
)  # fmt: skip

NEAR_REST = 0.2  # share of the peak speed below which the torque of a reversal hides an offset
POINTS_PER_PERIOD = 10  # of the filtered curve, per period of its highest frequency: enough for a smooth line
SMALLEST_CENTRE_NM = 0.0005  # the label's three decimals would round less to nothing
MOST_LOOPS = 60  # cycles of the filtered curve above which it would be a blot
SMALLEST_SPEED_RAD_S = 0.1  # half width of the panel of a joint that stands still


def _draw_loop(panels: Sequence[Axes], estimate: Estimate, friction: JointFriction) -> None:
    (axes,), series = panels, series_of(estimate, friction)
    alone = len(axes.figure.axes) == 1
    thinned = parts.every_nth(len(series.t))
    raw = "raw" if thinned.step == 1 else f"raw, 1 sample in {thinned.step}"
    parts.draw_dots(axes, series.dq[thinned], series.driving[thinned], theme.RAW, raw)
    dq, torque, every = filtered_loop(series)
    filtered = f"filtered, {parts.cutoff_hz(series.t):.3g} Hz{'' if every == 1 else f', 1 cycle in {every}'}"
    axes.plot(dq, torque, color=theme.FILTERED, lw=0.35, rasterized=True, label=filtered)
    if alone:  # on a sheet there is no room for arrows
        parts.draw_arrows(axes, dq, torque)
    reach = float(np.abs(series.dq).max())
    # Two points next to zero on each side make the step of the Coulomb term upright.
    speed = np.array([-reach, -1e-9, 1e-9, reach])
    if not friction.reason and np.isfinite(fitted_torque(friction, speed)).all():
        # The median of what friction leaves in motion: an offset of the sensor or an error of gravity.
        moving = np.abs(series.dq) > NEAR_REST * reach
        centre = float(np.median(series.driving[moving] - fitted_torque(friction, series.dq[moving])))
        # The numbers differ from panel to panel, so the sheet's legend cannot show them.
        label = fitted_label(friction, centre) if alone else "fitted friction"
        axes.plot(speed, fitted_torque(friction, speed) + centre, color=theme.FITTED, lw=1.3, zorder=4, label=label)
    axes.set_xlim(*np.array([-1.0, 1.0]) * max(SMALLEST_SPEED_RAD_S, 1.05 * reach))
    if not alone:
        axes.locator_params(axis="x", nbins=3)
    parts.write_reason(axes, "not determined", friction.reason, characters=40 if alone else 24)


def filtered_loop(series: JointSeries) -> tuple[Float, Float, int]:
    """Return filtered velocity and torque, thinned; of a long log every k-th cycle, gaps between them as NaN; and k."""
    step = max(1, int(1.0 / median_step(series.t) / (POINTS_PER_PERIOD * parts.CUTOFF_HZ)))
    dq, torque = (parts.smooth(series.t, signal)[::step] for signal in (series.dq, series.driving))
    every = max(-(-len(dq) // parts.MOST_POINTS), -(-len(series.cycles.start) // MOST_LOOPS))
    if every <= 1:
        return dq, torque, 1
    every |= 1  # odd, so that strokes there and strokes back are both shown
    shown = np.zeros(len(series.t), dtype=np.bool_)
    for start, stop in zip(series.cycles.start[::every], series.cycles.stop[::every], strict=True):
        shown[start:stop] = True
    return np.where(shown[::step], dq, np.nan), torque, every


def fitted_torque(friction: JointFriction, dq: Float) -> Float:
    """Return the friction torque [N m] of the whole-log estimate at velocities of shape (n,)."""
    coulomb = 0.0 if friction.model == "viscous" else friction.coulomb.value
    viscous = 0.0 if friction.model == "coulomb" else friction.viscous.value
    return coulomb * np.sign(dq) + viscous * dq


def fitted_label(friction: JointFriction, centre: float) -> str:
    """Return the fitted curve's formula with its numbers, drawn around a constant [N m], for the legend."""
    terms = []
    if friction.model != "viscous":
        terms.append(rf"{friction.coulomb.value:.3f}\,\mathrm{{sgn}}\,\dot{{q}}")
    if friction.model != "coulomb":
        terms.append(rf"{friction.viscous.value:+.3f}\,\dot{{q}}")
    if abs(centre) >= SMALLEST_CENTRE_NM:
        terms.append(f"{centre:+.3f}")
    return f"fitted: ${''.join(terms).removeprefix('+')}$"


VELOCITY_TORQUE = replace(
    SIGNALS, draw=_draw_loop, panels=1, across=4, height_in=(1.75, 2.4), head_in=0.5, shared=False,
    x="Velocity [rad/s]",
    y=lambda of: f"Interaction{'' if of.interaction.compensation is None else ' and compensator'} torque [N m]",
)  # fmt: skip
