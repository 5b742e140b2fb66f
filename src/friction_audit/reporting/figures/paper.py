"""Courses of joints -> figures in the layout of the paper's."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    DISSIPATED,
    FILTERED,
    FITTED,
    MUTED,
    RAW,
    SHADE,
    add_legend,
    every_nth,
    figure_style,
    label_panel,
    new_figure,
    smooth,
    thin_extremes,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Course:
    """One joint over time; n samples, m ends of cycles.

    Attributes:
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        interaction_nm: Interaction torque F_m, shape (n,). [N m]
        energy_j: Net energy E_m, shape (n,). [J]
        ends_s: When cycles end, shape (m,). [s]
        ends_j: Net energy then, shape (m,). [J]
        coulomb_nm: Coulomb friction compensated, shape (n,). [N m]
        viscous_nms_per_rad: Viscous friction compensated, shape (n,). [N m s/rad]
        damping_nms_per_rad: Damping of the passivity controller, shape (n,). [N m s/rad]
    """

    t: Float
    dq: Float
    interaction_nm: Float
    energy_j: Float
    ends_s: Float
    ends_j: Float
    coulomb_nm: Float
    viscous_nms_per_rad: Float
    damping_nms_per_rad: Float


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


def draw_adaptation(course: Course, viscous_nms_per_rad: Float) -> "Figure":
    """Draw the net energy and the coefficient beside the true one, shape (n,). [N m s/rad]"""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 3.0)
        above, below = figure.subplots(2, 1, sharex=True)
        handles = draw_energy(above, course, "(a)")
        label = "Viscous\n[N m s/rad]"
        true = below.plot(
            *thin_extremes(course.t, viscous_nms_per_rad, DRAWN), color=FITTED, ls=(0, (4, 1.5)), label="true friction"
        )
        (curve,) = draw_steps(below, course, ("viscous_nms_per_rad", label, FILTERED), "(b)")
        curve.set_label("compensated")
        below.set_xlabel("Time [s]")
        add_legend(figure, [*handles, *true, curve])
        figure.align_ylabels()
        return figure


def draw_exchange(course: Course, kinetic_j: Float, dissipated_j: Float) -> "Figure":
    """Draw the net energy input and the two parts that it consists of.

    Args:
        course: The joint.
        kinetic_j: Its kinetic energy E_s, shape (n,). [J]
        dissipated_j: What friction dissipated, shape (n,). [J]
    """
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.4)
        axes = figure.subplots()
        handles = draw_energy(axes, course, "")
        parts = (
            (kinetic_j, FITTED, (0, (4, 1.5)), "kinetic $E_s$"),
            (dissipated_j, DISSIPATED, "-.", "dissipated $E_{dissp}$"),
        )
        for energy, colour, dashes, label in parts:
            handles += axes.plot(*thin_extremes(course.t, energy, DRAWN), color=colour, ls=dashes, label=label)
        for number, (end_s, end_j) in enumerate(zip(course.ends_s, course.ends_j, strict=True), start=1):
            axes.annotate(
                rf"$E^{number}_{{cyclic}}$",
                (end_s, end_j),
                (3, -10),
                textcoords="offset points",
                fontsize=6.5,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
            )
        axes.set_xlabel("Time [s]")
        add_legend(figure, handles)
        return figure


def draw_overcompensation(bare: Course, guarded: Course) -> "Figure":
    """Draw the net energy without and with the passivity controller, and its damping."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 3.9)
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        handles = draw_energy(top, bare, "(a) without passivity controller")
        draw_energy(middle, guarded, "(b) with it")
        damping = ("damping_nms_per_rad", "Damping\n[N m s/rad]", FITTED)
        draw_steps(bottom, guarded, damping, "(c) adaptive damping")
        bottom.set_xlabel("Time [s]")
        add_legend(figure, handles)
        figure.align_ylabels()
        return figure


def draw_plateaus(raw: Course, aided: Course) -> "Figure":
    """Draw both curves, dashed and solid as in the paper."""
    with figure_style(mathematics=True):
        figure = new_figure(COLUMN_IN, 2.5)
        axes = figure.subplots()
        axes.axhline(0.0, color=MUTED, lw=0.4)
        axes.axvline(0.0, color=MUTED, lw=0.4)
        dashed = axes.plot(
            raw.dq, raw.interaction_nm, color=FITTED, ls=(0, (4, 1.5)), lw=1.0, label="combined friction"
        )
        solid = axes.plot(aided.dq, aided.interaction_nm, color=FILTERED, lw=1.0, label="compensated")
        label_panel(axes, "")
        axes.set_xlabel("Velocity [rad/s]")
        axes.set_ylabel("Interaction torque [N m]")
        add_legend(figure, [*dashed, *solid])
        return figure
