"""Courses of simulated joints -> figures in the layout of the paper's Figs 3 and 6 to 12."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures import style as theme
from friction_audit.reporting.figures.series import shade_stretches

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

DRAWN, DRAWN_ON_SHEET = 4000, 1500  # points of a curve: more than a column has pixels
ARROWS_AT = 0.6  # share of a stroke's peak speed at which an arrow stands
ARROW_SAMPLES = 40  # samples from the middle of an arrow to its ends


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Course:
    """One joint over time; n samples, m ends of cycles.

    Attributes:
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        interaction_nm: Interaction torque F_m, shape (n,). [N m]
        energy_j: Net energy E_m, shape (n,). [J]
        coulomb_nm: Coulomb friction compensated, shape (n,). [N m]
        viscous_nms_per_rad: Viscous friction compensated, shape (n,). [N m s/rad]
        damping_nms_per_rad: Damping of the passivity controller, shape (n,). [N m s/rad]
        ends_s: When cycles end, shape (m,). [s]
        ends_j: Net energy then, shape (m,). [J]
    """

    t: Float
    dq: Float
    interaction_nm: Float
    energy_j: Float
    coulomb_nm: Float
    viscous_nms_per_rad: Float
    damping_nms_per_rad: Float
    ends_s: Float
    ends_j: Float

    def part(self, kept: "NDArray[np.bool_]") -> "Course":
        """Return the samples of a mask of shape (n,), and the ends of cycles from the first of them on."""
        later = self.ends_s > self.t[kept][0]
        samples = {one.name: getattr(self, one.name)[kept] for one in fields(self) if not one.name.startswith("ends")}
        return replace(self, **samples, ends_s=self.ends_s[later], ends_j=self.ends_j[later])


def _shade(axes: "Axes", course: Course) -> None:
    shade_stretches(axes, [course.t[0], *course.ends_s], [*course.ends_s, course.t[-1]], course.t)


def _draw_energy(axes: "Axes", course: Course, title: str = "") -> None:
    """Draw the net energy with the ends of its cycles marked."""
    _shade(axes, course)
    parts.mark_zero(axes)
    parts.draw_curve(axes, course.t, course.energy_j, DRAWN, color=theme.FILTERED, label="net energy $E_m$")
    look: theme.Look = {"color": theme.BORDER, "ms": 2.4, "mew": 0, "zorder": 5, "label": "end of a cycle"}
    axes.plot(course.ends_s, course.ends_j, "o", **look)
    parts.label_panel(axes, title, y="Energy [J]")


def _draw_steps(axes: "Axes", course: Course, signal: Float, y: str, colour: str, title: str = "") -> None:
    """Draw a coefficient or a damping of shape (n,)."""
    _shade(axes, course)
    parts.draw_curve(axes, course.t, signal, DRAWN, color=colour)
    parts.label_panel(axes, title, y=y)


def _draw_loop(axes: "Axes", course: Course, title: str) -> None:
    """Draw interaction torque over velocity, as measured and filtered, with arrows in the direction of time."""
    parts.draw_dots(axes, course.dq, course.interaction_nm, theme.RAW, "raw", zorder=1)
    dq, torque = parts.smooth(course.t, course.dq), parts.smooth(course.t, course.interaction_nm)
    thin = parts.every_nth(len(course.t), DRAWN)
    axes.plot(dq[thin], torque[thin], color=theme.FILTERED, lw=0.6, label="filtered, 10 Hz", zorder=2)
    for fastest in (int(np.argmax(dq)), int(np.argmin(dq))):
        slow = np.sign(dq[fastest]) * dq < ARROWS_AT * abs(dq[fastest])
        for place in (fastest - int(np.argmax(slow[fastest::-1])), fastest + int(np.argmax(slow[fastest:]))):
            tail, head = max(place - ARROW_SAMPLES, 0), min(place + ARROW_SAMPLES, len(dq) - 1)
            parts.draw_arrow(axes, (dq[tail], torque[tail]), (dq[head], torque[head]), theme.FITTED, 0.9)
    parts.label_panel(axes, title, y="Interaction torque [N m]")
    axes.set_xlabel("Velocity [rad/s]")


def _finish(figure: "Figure", last: "Axes") -> "Figure":
    last.set_xlabel("Time [s]")
    parts.add_legend(figure)
    figure.align_ylabels()
    return figure


@theme.figure_style(mathematics=True)
def draw_exchange(course: Course, kinetic_j: Float, dissipated_j: Float) -> "Figure":
    """Draw the net energy input and its two parts, kinetic and dissipated energy, shape (n,) each (Fig. 3). [J]"""
    figure = parts.new_figure(theme.COLUMN_IN, 2.4)
    axes = figure.subplots()
    _draw_energy(axes, course)
    parts.draw_curve(axes, course.t, kinetic_j, DRAWN, color=theme.FITTED, ls=theme.DASHED, label="kinetic $E_s$")
    parts.draw_curve(
        axes, course.t, dissipated_j, DRAWN, color=theme.DISSIPATED, ls="-.", label="dissipated $E_{dissp}$"
    )
    box: theme.Look = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8}
    for number, end in enumerate(zip(course.ends_s, course.ends_j, strict=True), start=1):
        name = rf"$E^{number}_{{cyclic}}$"
        axes.annotate(name, end, (3, -10), textcoords="offset points", fontsize=6.5, bbox=box)
    return _finish(figure, axes)


@theme.figure_style(mathematics=True)
def draw_adaptation(course: Course, viscous_nms_per_rad: Float) -> "Figure":
    """Draw the net energy, and the coefficient with the true one of shape (n,) (Fig. 6). [N m s/rad]"""
    figure = parts.new_figure(theme.COLUMN_IN, 3.0)
    above, below = figure.subplots(2, 1, sharex=True)
    _draw_energy(above, course, "(a)")
    parts.draw_curve(
        below, course.t, viscous_nms_per_rad, DRAWN, color=theme.FITTED, ls=theme.DASHED, label="true friction"
    )
    _draw_steps(below, course, course.viscous_nms_per_rad, "Viscous\n[N m s/rad]", theme.FILTERED, "(b)")
    below.lines[-1].set_label("compensated")
    return _finish(figure, below)


@theme.figure_style(mathematics=True)
def draw_overcompensation(bare: Course, guarded: Course) -> "Figure":
    """Draw the net energy without and with the passivity controller, and its damping (Fig. 7)."""
    figure = parts.new_figure(theme.COLUMN_IN, 3.9)
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    _draw_energy(top, bare, "(a) without passivity controller")
    _draw_energy(middle, guarded, "(b) with it")
    label = "Damping\n[N m s/rad]"
    _draw_steps(bottom, guarded, guarded.damping_nms_per_rad, label, theme.FITTED, "(c) adaptive damping")
    return _finish(figure, bottom)


def _draw_signals(above: "Axes", below: "Axes", course: Course) -> None:
    """Draw velocity above interaction torque."""
    for axes, signal, label in (
        (above, course.dq, "Velocity\n[rad/s]"),
        (below, course.interaction_nm, "Torque\n[N m]"),
    ):
        _shade(axes, course)
        parts.draw_raw_and_filtered(axes, course.t, signal, DRAWN, lw=0.8)
        parts.label_panel(axes, "(a)" if axes is above else "", y=label)


def _share_time(panels: "Sequence[Axes]") -> "Axes":
    """Write the time below the last panel only; return it."""
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    return panels[-1]


@theme.figure_style(mathematics=True)
def draw_uncompensated(course: Course) -> "Figure":
    """Draw velocity and torque, the net energy, and the torque over the velocity (Fig. 8)."""
    figure = parts.new_figure(theme.COLUMN_IN, 5.6)
    panels = figure.subplots(4, 1, height_ratios=(1, 1, 1.2, 2))
    _draw_signals(panels[0], panels[1], course)
    _draw_energy(panels[2], course, "(b)")
    _draw_loop(panels[3], course, "(c)")
    return _finish(figure, _share_time(panels[:3]))


@theme.figure_style(mathematics=True)
def draw_plateaus(raw: Course, aided: Course) -> "Figure":
    """Draw torque over velocity without and with compensation, dashed and solid as in the paper (Fig. 9)."""
    figure = parts.new_figure(theme.COLUMN_IN, 2.5)
    axes = figure.subplots()
    parts.mark_zero(axes, x=True)
    axes.plot(raw.dq, raw.interaction_nm, color=theme.FITTED, ls=theme.DASHED, lw=1.0, label="combined friction")
    axes.plot(aided.dq, aided.interaction_nm, color=theme.FILTERED, lw=1.0, label="compensated")
    parts.label_panel(axes, y="Interaction torque [N m]")
    _finish(figure, axes)
    axes.set_xlabel("Velocity [rad/s]")
    return figure


@theme.figure_style(mathematics=True)
def draw_compensated(course: Course) -> "Figure":
    """Draw velocity and torque, the net energy, and both coefficients (Fig. 10)."""
    figure = parts.new_figure(theme.COLUMN_IN, 5.2)
    panels = figure.subplots(5, 1)
    _draw_signals(panels[0], panels[1], course)
    _draw_energy(panels[2], course, "(b)")
    panels[2].axhline(course.ends_j[1], color=theme.FITTED, lw=0.7, ls=theme.DASHED, label="$E^2_{cyclic}$")
    _draw_steps(panels[3], course, course.viscous_nms_per_rad, "Viscous\n[N m s/rad]", theme.FILTERED, "(c)")
    _draw_steps(panels[4], course, course.coulomb_nm, "Coulomb\n[N m]", theme.DISSIPATED)
    return _finish(figure, _share_time(panels))


@theme.figure_style(mathematics=True)
def draw_compensated_loop(course: Course, without: Course) -> "Figure":
    """Draw torque over velocity on the axes of the uncompensated joint (Fig. 11)."""
    figure = parts.new_figure(theme.COLUMN_IN, 2.5)
    axes = figure.subplots()
    _draw_loop(axes, course, "")
    reach = 1.05 * float(abs(without.interaction_nm).max())
    axes.set_ylim(-reach, reach)
    parts.add_legend(figure)
    return figure


@theme.figure_style(mathematics=True)
def draw_whole_arm(courses: Sequence[Course]) -> "Figure":
    """Draw a row for every joint: velocity and torque, net energy, both coefficients (Fig. 12)."""
    figure = parts.new_figure(theme.SHEET_IN, 0.9 + 0.92 * len(courses))
    rows = figure.subplots(len(courses), 3, squeeze=False, sharex=True)
    for number, (row, course) in enumerate(zip(rows, courses, strict=True), start=1):
        t, (left, middle, right) = course.t, row
        torque = course.interaction_nm
        curves = (
            (left, torque, {"color": theme.RAW, "lw": 0.4, "label": "torque", "rasterized": True}),
            (left, parts.smooth(t, torque), {"color": theme.FILTERED, "lw": 0.6, "label": "filtered, 10 Hz"}),
            (left, course.dq, {"color": theme.FITTED, "lw": 0.7, "label": "velocity"}),
            (middle, course.energy_j, {"color": theme.FILTERED}),
            (right, course.coulomb_nm, {"color": theme.DISSIPATED, "label": "Coulomb"}),
            (right, course.viscous_nms_per_rad, {"color": theme.FILTERED, "ls": theme.DASHED, "label": "viscous"}),
        )
        for axes in row:
            _shade(axes, course)
            parts.mark_zero(axes)
            parts.label_panel(axes, across=6)
        for axes, signal, look in curves:
            parts.draw_curve(axes, t, signal, DRAWN_ON_SHEET, **look)
        dots: theme.Look = {"color": theme.BORDER, "ms": 2.0, "mew": 0, "zorder": 5, "label": "end of a cycle"}
        middle.plot(course.ends_s, course.ends_j, "o", **dots)
        left.set_ylabel(f"joint {number}")
    titles = ("(a) velocity [rad/s], torque [N m]", "(b) net energy [J]", "(c) coefficients [N m], [N m s/rad]")
    for axes, title in zip(rows[0], titles, strict=True):
        axes.set_title(title, loc="left")
    figure.supxlabel("Time [s]")
    parts.add_legend(figure)
    figure.align_ylabels()
    return figure
