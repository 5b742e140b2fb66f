"""Panels that several of the paper's figures have in common."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.report.figures.layout import label_panel
from friction_audit.report.figures.smoothing import smooth
from friction_audit.report.figures.style import BORDER, FILTERED, FITTED, MUTED, RAW, SHADE
from friction_audit.report.figures.thinning import every_nth, thin_extremes
from friction_audit.report.paper_figures.course import Course

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

DRAWN = 4000
"""Points of a curve: more than a column has pixels."""

ARROWS_AT = 0.6
"""Share of a stroke's peak speed at which an arrow stands."""
ARROW_SAMPLES = 40
"""Samples from the middle of an arrow to its ends."""


def shade(axes: "Axes", course: Course) -> None:
    """Shade every other cycle and end the axis with the course."""
    edges = [course.t[0], *course.ends_s, course.t[-1]]
    for start, stop in zip(edges[:-1:2], edges[1::2], strict=False):
        axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0)
    axes.set_xlim(course.t[0], course.t[-1])


def draw_energy(axes: "Axes", course: Course, title: str) -> "list[Artist]":
    """Draw the net energy with the ends of its cycles marked; return the legend's entries."""
    shade(axes, course)
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    curve = axes.plot(*thin_extremes(course.t, course.energy_j, DRAWN), color=FILTERED, label="net energy $E_m$")
    dots = axes.plot(course.ends_s, course.ends_j, "o", color=BORDER, ms=2.4, mew=0, zorder=5, label="end of a cycle")
    label_panel(axes, title)
    axes.set_ylabel("Energy [J]")
    return [*curve, *dots]


def draw_steps(axes: "Axes", course: Course, values: "tuple[str, str, str]", title: str) -> "list[Artist]":
    """Draw a coefficient or a damping; ``values`` are the course's attribute, the axis' label and the colour."""
    name, label, colour = values
    shade(axes, course)
    curve = axes.plot(*thin_extremes(course.t, getattr(course, name), DRAWN), color=colour)
    label_panel(axes, title)
    axes.set_ylabel(label)
    return list(curve)


def draw_raw_and_filtered(axes: "Axes", course: Course, name: str) -> "list[Artist]":
    """Draw a signal as measured and filtered over time; return the legend's entries."""
    signal = getattr(course, name)
    raw = axes.plot(*thin_extremes(course.t, signal, DRAWN), color=RAW, lw=0.5, label="raw", rasterized=True)
    curve = axes.plot(
        *thin_extremes(course.t, smooth(course.t, signal), DRAWN), color=FILTERED, label="filtered (10 Hz)"
    )
    return [*raw, *curve]


def draw_loop(axes: "Axes", course: Course, title: str) -> "list[Artist]":
    """Draw interaction torque against velocity, as measured and filtered; return the legend's entries."""
    axes.plot(course.dq, course.interaction_nm, ".", ms=1.0, mew=0, color=RAW, rasterized=True, zorder=1)
    raw = axes.plot([], [], ".", color=RAW, label="raw")
    dq, torque = smooth(course.t, course.dq), smooth(course.t, course.interaction_nm)
    thin = every_nth(len(course.t), DRAWN)
    curve = axes.plot(dq[thin], torque[thin], color=FILTERED, lw=0.6, label="filtered (10 Hz)", zorder=2)
    for fastest in (int(np.argmax(dq)), int(np.argmin(dq))):
        _add_arrows(axes, dq, torque, fastest)
    label_panel(axes, title)
    axes.set_xlabel("Velocity [rad/s]")
    axes.set_ylabel("Interaction torque [N m]")
    return [*raw, *curve]


def _add_arrows(axes: "Axes", dq: Float, torque: Float, fastest: int) -> None:
    """Add two arrows in the direction of time: on the way to the fastest sample of a stroke, and on the way back."""
    half = ARROWS_AT * dq[fastest]
    side = np.sign(dq[fastest])
    rising = fastest - int(np.argmax(side * dq[fastest::-1] < abs(half)))
    falling = fastest + int(np.argmax(side * dq[fastest:] < abs(half)))
    for place in (rising, falling):
        tail, head = max(place - ARROW_SAMPLES, 0), min(place + ARROW_SAMPLES, len(dq) - 1)
        style = {"arrowstyle": "-|>", "color": FITTED, "lw": 0.9, "mutation_scale": 9, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (dq[head], torque[head]), (dq[tail], torque[tail]), arrowprops=style, zorder=5)
