"""Velocity and interaction torque over time."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures.style import (
    COLUMN_IN,
    CUTOFF_HZ,
    FILTERED,
    FITTED,
    MOST_POINTS,
    RAW,
    SHEET_IN,
    JointSeries,
    add_legend,
    all_series,
    break_at_gaps,
    cutoff_hz,
    cycle_handles,
    every_nth,
    figure_style,
    is_narrow,
    joint_series,
    label_panel,
    median_rate_hz,
    new_figure,
    new_pairs,
    say_in_panel,
    shade_cycles,
    smooth,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LABELS = ("Velocity [rad/s]", "Torque [N m]")
POINTS = 6000
"""Points of a curve: a page is 2100 dots wide at 300 dots per inch, so nothing can be lost."""
GAP_PERIODS = 20
"""Sampling periods without a sample after which no line is drawn."""


def draw_signals(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw one joint at column width, velocity above torque, or every joint on a sheet, a row for each."""
    with figure_style():
        joints = all_series(estimate) if joint is None else (joint_series(estimate, joint),)
        figure, pairs = new_pairs(len(joints), sheet=joint is None)
        found = [_draw_joint(pair, series) for pair, series in zip(pairs, joints, strict=True)]
        add_legend(figure, found[0] + cycle_handles(joints))
        figure.align_ylabels()
        figure.supxlabel("Time [s]", fontsize=7.5)
        return figure


def _draw_joint(pair: "tuple[Axes, Axes]", series: JointSeries) -> "list[Artist]":
    """Draw velocity and torque of one joint; return the legend's entries."""
    handles: list[Artist] = []
    for axes, signal, label in zip(pair, (series.dq, series.torque), LABELS, strict=True):
        shade_cycles(axes, series)
        handles = _draw_signal(axes, series.t, signal)
        axes.set_xlim(series.t[0], series.t[-1])
        label_panel(axes, series.title if axes is pair[0] else "")
        axes.set_ylabel(label)
    return handles


def _draw_signal(axes: "Axes", t: Float, signal: Float) -> "list[Artist]":
    """Draw a signal raw and filtered; return both curves."""
    longest_s = GAP_PERIODS / median_rate_hz(t)
    curves = (
        (signal, RAW, 0.5, "raw"),
        (smooth(t, signal), FILTERED, 0.7, f"filtered, {cutoff_hz(t):.3g} Hz"),
    )
    handles: list[Artist] = []
    for values, color, width, label in curves:
        stamps, kept = thin_extremes(t, values, POINTS)
        whole = break_at_gaps(stamps, kept, longest_s + 2 * (t[-1] - t[0]) / len(stamps))
        handles += axes.plot(stamps, whole, color=color, lw=width, label=label, rasterized=True)
    return handles


COLUMNS = 4
TICKS_ACROSS = 3
ARROWS = 6
ARROW_LENGTH = 0.06
"""Of a panel's width."""
NEAR_REST = 0.2
"""Share of the peak speed below which no arrow is drawn: there the curve is steep and crowded."""
POINTS_PER_PERIOD = 10
"""Samples of the filtered curve per period of its highest frequency: enough for a smooth line."""
SMALLEST_CENTRE_NM = 0.0005
"""What the label's three decimals would round to nothing. [N m]"""
MOST_LOOPS = 60
"""Cycles of the filtered curve above which it would be a blot."""
SMALLEST_SPEED_RAD_S = 0.1
"""Half width of the panel of a joint that stands still. [rad/s]"""


class Loop(NamedTuple):
    """The filtered curve: velocity, torque, and how much of the log it shows."""

    dq: Float
    torque: Float
    every: int


def draw_velocity_torque(estimate: Estimate, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet."""
    with figure_style():
        if joint is None:
            return _draw_sheet(all_series(estimate))
        series = joint_series(estimate, joint)
        figure = new_figure(COLUMN_IN, 2.9)
        handles = _draw_panel(figure.subplots(), series, characters=40)
        shown = None if series.not_determined else fitted_label(series.friction, centre_nm(series))
        add_legend(figure, handles, formula=shown)
        figure.supxlabel("Velocity [rad/s]", fontsize=7.5)
        figure.supylabel(_torque_label(series), fontsize=7.5)
        return figure


def _draw_sheet(joints: tuple[JointSeries, ...]) -> "Figure":
    rows = -(-len(joints) // COLUMNS)
    columns = min(len(joints), COLUMNS)
    figure = new_figure(SHEET_IN, 0.5 + 1.75 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    handles: list[Artist] = []
    for axes, series in zip(panels, joints, strict=False):
        found = _draw_panel(axes, series, characters=24)
        handles = found if len(found) > len(handles) else handles
    for axes in panels[len(joints) :]:
        axes.remove()
    # The numbers differ from panel to panel, so the sheet's legend cannot show them.
    for handle in handles[2:]:
        handle.set_label("fitted friction")
    add_legend(figure, handles)
    figure.supxlabel("Velocity [rad/s]", fontsize=7.5)
    figure.supylabel(_torque_label(joints[0]), fontsize=7.5)
    return figure


def _torque_label(series: JointSeries) -> str:
    return "Interaction torque [N m]" if series.compensation is None else "Interaction and compensator torque [N m]"


def _draw_panel(axes: "Axes", series: JointSeries, *, characters: int) -> "list[Artist]":
    """Draw one joint; return raw, filtered and (if there is an estimate) fitted curve for the legend."""
    from matplotlib.lines import Line2D

    thinned = every_nth(len(series.t))
    axes.plot(series.dq[thinned], series.driving_torque[thinned], ".", color=RAW, ms=1.2, mew=0, rasterized=True)
    # In the legend the marks are larger, or nobody would see them.
    raw = Line2D([], [], color=RAW, marker=".", ls="", ms=5, mew=0)
    curve = filtered_curve(series)
    loop = filtered_loop(series, curve)
    filtered = axes.plot(loop.dq, loop.torque, color=FILTERED, lw=0.35, rasterized=True)[0]
    _add_arrows(axes, series, curve)
    raw.set_label("raw" if thinned.step == 1 else f"raw, 1 sample in {thinned.step}")
    shown = "" if loop.every == 1 else f", 1 cycle in {loop.every}"
    filtered.set_label(f"filtered, {cutoff_hz(series.t):.3g} Hz{shown}")
    handles: list[Artist] = [raw, filtered]
    if not series.not_determined:
        handles.extend(_draw_fit(axes, series))
    reach = max(SMALLEST_SPEED_RAD_S, 1.05 * float(np.abs(series.dq).max()))
    axes.set_xlim(-reach, reach)
    label_panel(axes, series.title, across=None if is_narrow(axes.get_figure(root=True)) else TICKS_ACROSS)
    say_in_panel(axes, series.not_determined, characters=characters)
    return handles


def filtered_curve(series: JointSeries) -> tuple[Float, Float]:
    """Return velocity [rad/s] and torque [N m] after the filter, shape (n,) each."""
    return smooth(series.t, series.dq), smooth(series.t, series.driving_torque)


def filtered_loop(series: JointSeries, curve: tuple[Float, Float]) -> Loop:
    """Return the filtered curve, thinned to smooth lines; of a long log every k-th cycle, gaps between them as NaN."""
    step = max(1, int(median_rate_hz(series.t) / (POINTS_PER_PERIOD * CUTOFF_HZ)))
    dq, torque = (signal[::step] for signal in curve)
    every = max(-(-len(dq) // MOST_POINTS), -(-len(series.cycles.joint) // MOST_LOOPS))
    if every <= 1:
        return Loop(dq, torque, 1)
    every |= 1  # odd, so that strokes there and strokes back are both shown
    shown = np.zeros(len(series.t), dtype=np.bool_)
    for start, stop in zip(series.cycles.start[::every], series.cycles.stop[::every], strict=True):
        shown[start:stop] = True
    return Loop(np.where(shown[::step], dq, np.nan), torque, every)


def fitted_torque(friction: JointFriction, dq: Float) -> Float | None:
    """Return the friction torque of the whole-log estimate, or None where a coefficient of its model is missing.

    Args:
        friction: The joint's friction.
        dq: Velocity, shape (n,). [rad/s]

    Returns:
        Friction torque, shape (n,). [N m]
    """
    coulomb = 0.0 if friction.model == "viscous" else friction.coulomb.value
    viscous = 0.0 if friction.model == "coulomb" else friction.viscous.value
    torque = coulomb * np.sign(dq) + viscous * dq
    return None if np.isnan(coulomb + viscous) else torque


def centre_nm(series: JointSeries) -> float:
    """Return the constant around which the curve is drawn: the middle of what friction leaves while moving. [N m]

    An offset of the torque sensor or an error of gravity shifts the measured curve; friction itself has no constant.
    """
    moving = np.abs(series.dq) > NEAR_REST * np.abs(series.dq).max()
    friction = fitted_torque(series.friction, series.dq[moving])
    return 0.0 if friction is None else float(np.median(series.driving_torque[moving] - friction))


def fitted_label(friction: JointFriction, centre: float) -> str:
    """Return the fitted curve's formula with its numbers, for the legend.

    Args:
        friction: The joint's friction.
        centre: Constant that the curve is drawn around. [N m]
    """
    terms = []
    if friction.model != "viscous":
        terms.append(rf"{friction.coulomb.value:.3f}\,\mathrm{{sgn}}\,\dot{{q}}")
    if friction.model != "coulomb":
        terms.append(rf"{friction.viscous.value:+.3f}\,\dot{{q}}")
    if abs(centre) >= SMALLEST_CENTRE_NM:
        terms.append(f"{centre:+.3f}")
    return f"fitted: ${''.join(terms).removeprefix('+')}$"


def _draw_fit(axes: "Axes", series: JointSeries) -> "list[Artist]":
    reach = float(np.abs(series.dq).max())
    # Two points beside zero on each side make the step of the Coulomb term upright.
    dq = np.array([-reach, -1e-9, 1e-9, reach])
    torque = fitted_torque(series.friction, dq)
    if torque is None:
        return []
    centre = centre_nm(series)
    label = fitted_label(series.friction, centre)
    return list(axes.plot(dq, torque + centre, color=FITTED, lw=1.3, zorder=4, label=label))


def typical_strokes(series: JointSeries) -> slice:
    """Return the samples of two neighbouring cycles of middling peak speed, if possible there and back."""
    kept = series.cycles.rows(series.cycles.reason == 0)
    if len(kept.joint) < 2:  # noqa: PLR2004
        return slice(0, 0)
    direction = np.array([np.sign(series.dq[a:b].sum()) for a, b in zip(kept.start, kept.stop, strict=True)])
    distance = np.abs(kept.peak_speed_rad_s - np.median(kept.peak_speed_rad_s))
    apart = distance[1:] + distance[:-1] + 2 * distance.max() * (direction[1:] == direction[:-1])
    row = int(np.argmin(apart))
    return slice(int(kept.start[row]), int(kept.stop[row + 1]) + 1)


def _add_arrows(axes: "Axes", series: JointSeries, curve: tuple[Float, Float]) -> None:
    """Add arrows in the direction of time, evenly spread along a typical pair of strokes, away from rest."""
    strokes = typical_strokes(series)
    if strokes.stop - strokes.start < 2 * ARROWS:
        return
    dq, torque = (signal[strokes] for signal in curve)
    # A white rim keeps the strokes apart from the curve around them.
    axes.plot(dq, torque, color="white", lw=2.2, rasterized=True)
    axes.plot(dq, torque, color=FILTERED, lw=0.9, rasterized=True)
    steps = np.hypot(np.diff(dq) / np.ptp(dq), np.diff(torque) / (np.ptp(torque) or 1.0))  # a torque may be constant
    steps[np.abs(dq[1:]) < NEAR_REST * np.abs(dq).max()] = 0.0
    length = np.concatenate([[0.0], np.cumsum(steps)])
    for share in (np.arange(ARROWS) + 0.5) / ARROWS:
        tail, head = np.searchsorted(length, share * length[-1] + np.array([0.0, ARROW_LENGTH]))
        head = min(int(head), len(dq) - 1)
        axes.annotate(
            "",
            xy=(float(dq[head]), float(torque[head])),
            xytext=(float(dq[tail]), float(torque[tail])),
            arrowprops={
                "arrowstyle": "-|>",
                "color": FILTERED,
                "lw": 0.5,
                "mutation_scale": 9,
                "shrinkA": 0,
                "shrinkB": 0,
            },
            zorder=5,
        )
