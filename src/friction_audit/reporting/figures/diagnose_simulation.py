"""Measured against simulated, torque and motion, before and after the effects were added, on a few locked cycles."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.result import JointDiscrepancy, SimulationGap, Traces
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.figures.diagnose_look import (
    DASHED,
    DECLARED,
    GROWN,
    HEAD_IN,
    added,
    chosen_joints,
    grown_name,
    joint_name,
    once,
    say_why,
)
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    FILTERED,
    MUTED,
    RAW,
    SHADE,
    SHEET_IN,
    add_legend,
    break_at_gaps,
    figure_style,
    is_narrow,
    joint_series,
    label_panel,
    new_figure,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

SHOWN = 4
"""Locked cycles in a panel."""
GAP = 0.04
"""Of the time shown, between one cycle and the next."""
LONGEST_STEP = 1.5
"""Rows that lie farther apart than so many usual steps have others between them that were left out."""
POINTS = 4000
LEAST_ROOM = 0.17
"""Of the axis, from one date in words to the next."""
FARTHEST_RAW, FARTHEST_DECLARED = 0.5, 1.5
"""Times the range of the other curves that raw torque, and the motion of a declared model that runs away, may stretch
a panel; there they are cut."""
MARGIN, SMALLEST = 0.04, 0.001
"""Share of a panel's height above and below all curves, and its least height. [N m or rad/s]"""
FILTERED_LABEL = "measured, below"
TORQUE, RESIDUAL, MOTION = "Torque [N m]", "Measured less\nmodel [N m]", "Velocity [rad/s]"


class Piece(NamedTuple):
    """A stretch of the log that is shown, and where its beginning stands in the panel. [s]"""

    start: float
    stop: float
    place: float


def draw_simulation(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, panels above each other, or every joint on a sheet, a row for each."""
    with figure_style():
        joints = chosen_joints(found, joint)
        figure, rows = _panels(joints, sheet=joint is None)
        handles = [handle for row, one in zip(rows, joints, strict=True) for handle in _draw_joint(row, found, one)]
        add_legend(figure, _named(once(handles), joints))
        figure.supxlabel("Time within the locked cycles shown [s]", fontsize=7.5)
        figure.align_ylabels()
        return figure


def _panels(joints: Sequence[JointDiscrepancy], *, sheet: bool) -> "tuple[Figure, list[list[Axes]]]":
    across = 3 if any(one.simulation is not None for one in joints) else 2
    if sheet:
        figure = new_figure(SHEET_IN, HEAD_IN + 1.25 * len(joints))
        return figure, figure.subplots(len(joints), across, squeeze=False, sharex="row").tolist()
    figure = new_figure(COLUMN_IN, HEAD_IN + 1.3 * across)
    return figure, figure.subplots(across, 1, squeeze=False, sharex=True).T.tolist()


def _draw_joint(panels: "list[Axes]", found: Diagnosis, joint: JointDiscrepancy) -> "list[Artist]":
    """Draw torque, residual and motion of one joint; return the legend's entries."""
    if joint.traces is None:
        for axes in panels[1:]:
            axes.set_axis_off()
        return say_why(panels[0], joint_name(joint), joint)
    pieces = shown_cycles(joint.traces, joint.simulation)
    handles = _draw_torque(panels[0], found, joint, pieces)
    _draw_residual(panels[1], joint, pieces)
    if joint.simulation is not None:
        handles += _draw_motion(panels[2], joint, joint.simulation, pieces)
    elif len(panels) > len((TORQUE, RESIDUAL)):
        panels[2].set_axis_off()
    drawn = panels if joint.simulation is not None else panels[: len((TORQUE, RESIDUAL))]
    for axes, label in zip(drawn, (TORQUE, RESIDUAL, MOTION), strict=False):
        _divide(axes, pieces)
        label_panel(axes, joint_name(joint) if axes is panels[0] else "")
        axes.set_ylabel(label)
    _date(panels[1], pieces)
    return handles


def shown_cycles(traces: Traces, motion: SimulationGap | None = None, most: int = SHOWN) -> tuple[Piece, ...]:
    """Return locked cycles from the first to the last, evenly chosen, put behind each other.

    Args:
        traces: Of one joint, with at least one locked cycle.
        motion: Where there is one, cycles that it holds go before those that it lacks.
        most: Number of cycles.
    """
    locked = np.unique(traces.cycle[traces.locked])
    moved = locked if motion is None else _simulated(traces, locked, motion)
    locked = moved if len(moved) else locked
    chosen = locked[np.unique(np.linspace(0, len(locked) - 1, min(most, len(locked))).round().astype(int))]
    spans = [(float(t[0]), float(t[-1])) for t in (traces.t[traces.cycle == number] for number in chosen)]
    gap = GAP * sum(stop - start for start, stop in spans)
    pieces: list[Piece] = []
    for start, stop in spans:
        before = pieces[-1] if pieces else None
        place = 0.0 if before is None else before.place + before.stop - before.start + gap
        pieces.append(Piece(start, stop, place))
    return tuple(pieces)


def _simulated(traces: Traces, cycles: NDArray[np.int64], motion: SimulationGap) -> NDArray[np.int64]:
    """Return the cycles whose first row lies within the simulated motion."""
    begins = np.array([traces.t[traces.cycle == number][0] for number in cycles])
    known = motion.t[np.isfinite(motion.t)]
    near = np.abs(known[np.clip(np.searchsorted(known, begins), 0, len(known) - 1)] - begins)
    return np.asarray(cycles[near <= LONGEST_STEP * np.median(np.diff(traces.t))], np.int64)


def lay_out(pieces: Sequence[Piece], t: Float, signal: Float) -> tuple[Float, Float]:
    """Return place in the panel and signal of the samples that are shown, NaN between cycles and over left-out rows.

    Args:
        pieces: The cycles.
        t: Ascending; NaN where a curve is interrupted, shape (n,). [s]
        signal: Shape (n,).
    """
    usual = float(np.nanmedian(np.diff(t))) if len(t) > 1 else 0.0
    x: list[Float] = []
    y: list[Float] = []
    for piece in pieces:
        inside = (t >= piece.start) & (t <= piece.stop)
        x.append(np.append(t[inside] - piece.start + piece.place, np.nan))
        y.append(np.append(break_at_gaps(t[inside], signal[inside], LONGEST_STEP * usual), np.nan))
    return np.concatenate(x), np.concatenate(y)


def _draw_torque(axes: "Axes", found: Diagnosis, joint: JointDiscrepancy, pieces: Sequence[Piece]) -> "list[Artist]":
    """Draw the torque as recorded, behind the filter, and as both models say; return the legend's entries."""
    traces, series = joint.traces, joint_series(found.estimate, joint.joint)
    assert traces is not None
    raw = thin_extremes(*lay_out(pieces, series.t, series.driving_torque), POINTS)
    handles = axes.plot(*raw, color=RAW, lw=0.5, label="measured, raw", zorder=1)
    shown = lay_out(pieces, traces.t, traces.measured)
    handles += axes.plot(*shown, color=FILTERED, lw=1.0, label=f"{FILTERED_LABEL} {traces.corner_hz:.3g} Hz", zorder=2)
    models = _draw_models(axes, joint, pieces, traces.t, (traces.before, traces.after))
    axes.set_ylim(*limits_with((shown[1], *(_heights(line) for line in models)), raw[1], FARTHEST_RAW))
    return [*handles, *models]


def _heights(line: "Line2D") -> Float:
    return np.asarray(line.get_ydata(), np.float64)


def limits_with(shown: Sequence[Float], other: Float, farthest: float) -> tuple[float, float]:
    """Return limits that hold all curves but one, and of that one what is near, with a margin.

    Args:
        shown: Curves that are seen whole, NaN where they are interrupted, with a number at least.
        other: The one that may leave the panel: a single wild sample must not make all else a line.
        farthest: Times the range of the others that it may reach beyond them.
    """
    heights = np.concatenate(shown)
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    reach = farthest * (high - low)
    bottom = max(float(np.nanmin(other, initial=low)), low - reach)
    top = min(float(np.nanmax(other, initial=high)), high + reach)
    margin = MARGIN * max(top - bottom, SMALLEST)
    return bottom - margin, top + margin


def _draw_models(
    axes: "Axes", joint: JointDiscrepancy, pieces: Sequence[Piece], t: Float, curves: tuple[Float, Float]
) -> "list[Line2D]":
    """Draw a curve of the declared model and, where effects were added, of the grown one."""
    before, after = curves
    x, y = lay_out(pieces, t, before)
    handles = axes.plot(x, y, color=DECLARED, lw=0.8, ls=DASHED, label="declared model", zorder=3)
    if added(joint):
        x, y = lay_out(pieces, t, after)
        handles += axes.plot(x, y, color=GROWN, lw=0.8, label=grown_name(joint), zorder=4)
    return list(handles)


def _draw_residual(axes: "Axes", joint: JointDiscrepancy, pieces: Sequence[Piece]) -> None:
    traces = joint.traces
    assert traces is not None
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    _draw_models(axes, joint, pieces, traces.t, (traces.measured - traces.before, traces.measured - traces.after))


def _draw_motion(
    axes: "Axes", joint: JointDiscrepancy, motion: SimulationGap, pieces: Sequence[Piece]
) -> "list[Artist]":
    """Draw the velocity as measured and as both models move under the measured torque; return the legend's entry."""
    shown = lay_out(pieces, motion.t, motion.measured)
    handles = axes.plot(*shown, color=BORDER, lw=1.0, label="measured velocity", zorder=2)
    declared, *grown = _draw_models(axes, joint, pieces, motion.t, (motion.declared, motion.grown))
    whole = (shown[1], *(_heights(line) for line in grown))
    axes.set_ylim(*limits_with(whole, _heights(declared), FARTHEST_DECLARED))
    return list(handles)


def _divide(axes: "Axes", pieces: Sequence[Piece]) -> None:
    """Grey out what lies between the cycles."""
    for one, following in pairwise(pieces):
        axes.axvspan(one.place + one.stop - one.start, following.place, color=SHADE, lw=0, zorder=0)
    axes.set_xlim(0.0, pieces[-1].place + pieces[-1].stop - pieces[-1].start)


def _date(axes: "Axes", pieces: Sequence[Piece]) -> None:
    """Write above each cycle when it began; on a sheet, or over short cycles, there is room for the number alone."""
    middles = [piece.place + 0.5 * (piece.stop - piece.start) for piece in pieces]
    room = min((following - one for one, following in pairwise(middles)), default=np.inf)
    wide = room >= LEAST_ROOM * (pieces[-1].place + pieces[-1].stop - pieces[-1].start)
    words = "from " if wide and is_narrow(axes.get_figure(root=True)) else ""
    for piece, middle in zip(pieces, middles, strict=True):
        axes.annotate(
            f"{words}{piece.start:.1f} s",
            (middle, 1.0),
            xycoords=("data", "axes fraction"),
            ha="center",
            va="bottom",
            fontsize=5.5,
            color=MUTED,
        )


def _named(handles: "list[Artist]", joints: Sequence[JointDiscrepancy]) -> "list[Artist]":
    """Call the grown models of several joints by one name, once, and so their filters."""
    if len(joints) == 1:
        return handles
    names = {grown_name(one) for one in joints if added(one)}
    for handle in handles:
        if handle.get_label() in names:
            handle.set_label("with the effects named")
        elif str(handle.get_label()).startswith(FILTERED_LABEL):
            handle.set_label("measured, low-passed")
    return once(handles)
