"""Diagnosis -> measured against simulated torque and motion, with and without the effects, on a few held-out cycles."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from friction_audit.diagnosis.result import JointDiagnosis, SimulationGap, Traces
from friction_audit.joint_log import Float, median_step
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.diagnosis_words import plain_names
from friction_audit.reporting.figures import panels as parts, style as theme
from friction_audit.reporting.figures.estimate import series_of
from friction_audit.reporting.figures.profiles import AUGMENTED, NOMINAL, RESIDUAL, write_verdict
from friction_audit.reporting.words import enumerate_words

SHOWN = 4  # held-out cycles in a panel
GAP = 0.04  # of the time shown, between one cycle and the next
LONGEST_STEP = 1.5  # usual steps of time beyond which samples were left out
POINTS = 4000
LEAST_ROOM = 0.15  # of the axis, from one cycle's label to the next
# Times the range of the other curves that raw torque, and the motion of a nominal model that runs away, may stretch
# a panel; there they are cut.
FARTHEST_RAW, FARTHEST_NOMINAL = 0.5, 1.5
SMALLEST = 0.001  # least height of a panel [N m or rad/s]
LABELS = ("Torque [N m]", "Residual\ntorque [N m]", "Velocity [rad/s]")


class Piece(NamedTuple):
    """A stretch of the log that is shown, and where its beginning stands in the panel. [s]"""

    start: float
    stop: float
    place: float


def _draw(panels: Sequence[Axes], found: Diagnosis, joint: JointDiagnosis) -> None:
    motion, traces, alone = joint.simulation, joint.traces, parts.is_narrow(panels[0])
    drawn = panels[: 1 if traces is None else 2 if motion is None else 3]
    for axes in panels[len(drawn) :]:
        axes.set_axis_off()
    if traces is None:
        write_verdict(panels[0], joint)
        return
    pieces = shown_cycles(traces, motion)
    names = plain_names(enumerate_words(effect.name for effect in joint.added)) if alone else "the effects named"
    with_effects = f"with {names}" if joint.added else ""
    filtered = f"measured, below {traces.corner_hz:.3g} Hz" if alone else "measured, low-passed"
    (friction,) = parts.chosen_joints(found.estimate.friction.joints, joint.joint)
    series = series_of(found.estimate, friction)
    length_s, raw = pieces[-1].place + pieces[-1].stop - pieces[-1].start, np.empty(0)
    if len(series.t):  # a command has freed the samples of the log, which take most of the memory
        thin = parts.every_nth(int(length_s / median_step(series.t)), POINTS)
        # The stamps of a log may jitter by half of their step, those of the samples of the diagnosis do not.
        x, raw = lay_out(pieces, series.t[thin], series.driving[thin], float(np.median(np.diff(traces.t))))
        panels[0].plot(x, raw, color=theme.RAW, lw=0.5, label="measured, raw", zorder=1)
    look: theme.Look = {"color": theme.FILTERED, "lw": 1.0, "label": filtered, "zorder": 2}
    measured = _draw_curve(panels[0], pieces, traces.t, traces.measured, **look)
    models = _draw_models(panels[0], pieces, traces.t, (traces.before, traces.after), with_effects)
    panels[0].set_ylim(parts.limits(np.concatenate([measured, *models]), raw, near=FARTHEST_RAW, smallest=SMALLEST))
    parts.mark_zero(panels[1])
    residuals = (traces.measured - traces.before, traces.measured - traces.after)
    _draw_models(panels[1], pieces, traces.t, residuals, with_effects)
    if motion is not None:
        look = {"color": theme.BORDER, "lw": 1.0, "label": "measured velocity", "zorder": 2}
        measured = _draw_curve(panels[2], pieces, motion.t, motion.measured, **look)
        both = (motion.nominal, motion.augmented)
        nominal, *augmented = _draw_models(panels[2], pieces, motion.t, both, with_effects)
        shown = np.concatenate([measured, *augmented])
        panels[2].set_ylim(parts.limits(shown, nominal, near=FARTHEST_NOMINAL, smallest=SMALLEST))
    for axes, label in zip(drawn, LABELS, strict=False):
        for one, following in pairwise(pieces):
            axes.axvspan(one.place + one.stop - one.start, following.place, color=theme.SHADE, lw=0, zorder=0)
        axes.set_xlim(0.0, length_s)
        axes.set_ylabel(label)
    _label_cycles(panels[1], pieces, length_s)


def _label_cycles(axes: Axes, pieces: Sequence[Piece], length_s: float) -> None:
    """Write above each cycle when it began, where there is room."""
    look: theme.Look = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "bottom", "fontsize": 6}
    labelled = -np.inf
    for piece in pieces:
        middle = piece.place + 0.5 * (piece.stop - piece.start)
        if middle - labelled >= LEAST_ROOM * length_s:
            axes.annotate(f"{piece.start:.1f} s", (middle, 1.0), color=theme.MUTED, **look)
            labelled = middle


def shown_cycles(traces: Traces, motion: SimulationGap | None = None, most: int = SHOWN) -> tuple[Piece, ...]:
    """Return held-out cycles from the first to the last, evenly chosen, in a row; simulated ones before others."""
    held_out = np.unique(traces.cycle[traces.held_out])
    if motion is not None:
        begins = np.array([traces.t[traces.cycle == number][0] for number in held_out])
        known = motion.t[np.isfinite(motion.t)]
        near = np.abs(known[np.clip(np.searchsorted(known, begins), 0, len(known) - 1)] - begins)
        moved = held_out[near <= LONGEST_STEP * np.median(np.diff(traces.t))]
        held_out = moved if len(moved) else held_out
    chosen = held_out[np.unique(np.linspace(0, len(held_out) - 1, min(most, len(held_out))).round().astype(int))]
    spans = [(float(t[0]), float(t[-1])) for t in (traces.t[traces.cycle == number] for number in chosen)]
    lengths = [stop - start for start, stop in spans]
    places = np.cumsum([0.0, *(length + GAP * sum(lengths) for length in lengths[:-1])])
    return tuple(Piece(*span, float(place)) for span, place in zip(spans, places, strict=True))


def lay_out(pieces: Sequence[Piece], t: Float, signal: Float, usual_s: float) -> tuple[Float, Float]:
    """Return places and signal, shape (n,), of what is shown, NaN between cycles and over far longer steps."""
    shown: list[Float] = []
    for piece in pieces:
        inside = (t >= piece.start) & (t <= piece.stop)
        whole = parts.break_at_gaps(t[inside], signal[inside], LONGEST_STEP * usual_s)
        shown += [np.stack([t[inside] - piece.start + piece.place, whole]), np.full((2, 1), np.nan)]
    x, y = np.concatenate(shown, axis=1)
    return x, y


def _draw_curve(axes: Axes, pieces: Sequence[Piece], t: Float, signal: Float, **look: object) -> Float:
    x, y = lay_out(pieces, t, signal, float(np.nanmedian(np.diff(t))) if len(t) > 1 else 0.0)
    axes.plot(x, y, **look)  # type: ignore[arg-type]
    return y


def _draw_models(axes: Axes, pieces: Sequence[Piece], t: Float, curves: Sequence[Float], added: str) -> list[Float]:
    """Draw a curve of the nominal model and, where effects were added, of the augmented one; return what is drawn."""
    look: theme.Look = {"color": NOMINAL, "lw": 0.8, "ls": theme.DASHED, "label": "nominal model", "zorder": 3}
    drawn = [_draw_curve(axes, pieces, t, curves[0], **look)]
    if added:
        drawn.append(_draw_curve(axes, pieces, t, curves[1], color=AUGMENTED, lw=0.8, label=added, zorder=4))
    return drawn


SIMULATION = replace(
    RESIDUAL, draw=_draw, height_in=(1.25, 1.3), x="Time within the held-out cycles shown [s]", y="", shared="row",
    panels=lambda found, joint, sheet: (
        3 if any(one.simulation for one in (found.joints if sheet else [joint])) else 2
    ),
)  # fmt: skip
