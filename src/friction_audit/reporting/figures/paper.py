"""Courses of simulated joints -> figures in the layout of the paper's Figs 3 and 6 to 12."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts, style as theme

DRAWN, DRAWN_ON_SHEET = 4000, 1500  # points of a curve: more than a column has pixels
VISCOUS = "Viscous\n[N m s/rad]"


class Course(NamedTuple):
    """One joint over time; n samples, m ends of cycles."""

    t: Float  # shape (n,) [s]
    dq: Float  # velocity, shape (n,) [rad/s]
    interaction_nm: Float  # interaction torque F_m, shape (n,) [N m]
    energy_j: Float  # net energy E_m, shape (n,) [J]
    coulomb_nm: Float  # Coulomb friction compensated, shape (n,) [N m]
    viscous_nms_per_rad: Float  # viscous friction compensated, shape (n,) [N m s/rad]
    damping_nms_per_rad: Float  # damping of the passivity controller, shape (n,) [N m s/rad]
    ends_s: Float  # when cycles end, shape (m,) [s]
    ends_j: Float  # net energy then, shape (m,) [J]

    def part(self, kept: NDArray[np.bool_]) -> "Course":
        """Return the samples of a mask of shape (n,), and the ends of cycles from the first of them on."""
        later = self.ends_s > self.t[kept][0]
        samples = {name: array[kept] for name, array in self._asdict().items() if not name.startswith("ends")}
        return self._replace(**samples, ends_s=self.ends_s[later], ends_j=self.ends_j[later])


def _shade(axes: Axes, course: Course) -> None:
    parts.shade_stretches(axes, [course.t[0], *course.ends_s], [*course.ends_s, course.t[-1]])
    axes.set_xlim(course.t[0], course.t[-1])


def _draw_energy(course: Course, title: str, axes: Axes, plateau: float | None = None) -> None:
    _shade(axes, course)
    parts.mark_zero(axes)
    parts.draw_curve(axes, course.t, course.energy_j, DRAWN, color=theme.FILTERED, label="net energy $E_m$")
    axes.plot(course.ends_s, course.ends_j, "o", color=theme.BORDER, ms=2.4, mew=0, zorder=5, label="end of a cycle")
    if plateau is not None:
        axes.axhline(plateau, color=theme.FITTED, lw=0.7, ls=theme.DASHED, label="$E^2_{cyclic}$")
    parts.label_panel(axes, title, y="Energy [J]")


def _draw_steps(course: Course, signal: Float, y: str, colour: str, title: str, axes: Axes) -> None:
    _shade(axes, course)
    parts.draw_curve(axes, course.t, signal, DRAWN, color=colour)
    parts.label_panel(axes, title, y=y)


def _draw_loop(course: Course, title: str, axes: Axes) -> None:
    parts.draw_dots(axes, course.dq, course.interaction_nm, theme.RAW, "raw", zorder=1)
    dq, torque = parts.smooth(course.t, course.dq), parts.smooth(course.t, course.interaction_nm)
    thin = parts.every_nth(len(course.t), DRAWN)
    axes.plot(dq[thin], torque[thin], color=theme.FILTERED, lw=0.6, label="filtered, 10 Hz", zorder=2)
    parts.draw_arrows(axes, dq[thin], torque[thin])
    parts.label_panel(axes, title, y="Interaction torque [N m]")
    axes.set_xlabel("Velocity [rad/s]")


@theme.figure_style(mathematics=True)
def _column(height_in: float, *draws: Callable[[Axes], None], ratios: Sequence[float] = ()) -> Figure:
    """Return panels over time below each other, the time below the last one."""
    shares = np.array(ratios or [1.0] * len(draws))
    figure, panels = parts.grid((height_in * shares / shares.sum()).tolist(), 1, theme.COLUMN_IN, 0.0)
    for axes, draw in zip(panels, draws, strict=True):
        draw(axes)
    over_time = [axes for axes in panels if not axes.get_xlabel()]
    for axes in over_time[:-1]:
        axes.tick_params(labelbottom=False)
    for axes in over_time[-1:]:
        axes.set_xlabel("Time [s]")
    parts.add_legend(figure)
    figure.align_ylabels()
    return figure


def draw_exchange(course: Course, kinetic_j: Float, dissipated_j: Float) -> Figure:
    """Draw the net energy input and its two parts, kinetic and dissipated energy, shape (n,) each (Fig. 3). [J]"""
    box: theme.Look = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8}

    def draw(axes: Axes) -> None:
        _draw_energy(course, "", axes)
        for energy_j, colour, dashes, label in (
            (kinetic_j, theme.FITTED, theme.DASHED, "kinetic $E_s$"),
            (dissipated_j, theme.DISSIPATED, "-.", "dissipated $E_{dissp}$"),
        ):
            parts.draw_curve(axes, course.t, energy_j, DRAWN, color=colour, ls=dashes, label=label)
        for number, end in enumerate(zip(course.ends_s, course.ends_j, strict=True), start=1):
            name = rf"$E^{number}_{{cyclic}}$"
            axes.annotate(name, end, (3, -10), textcoords="offset points", fontsize=6.5, bbox=box)

    return _column(2.4, draw)


def draw_adaptation(course: Course, viscous_nms_per_rad: Float) -> Figure:
    """Draw the net energy, and the coefficient with the true one of shape (n,) (Fig. 6). [N m s/rad]"""
    truth: theme.Look = {"color": theme.FITTED, "ls": theme.DASHED, "label": "true friction"}

    def below(axes: Axes) -> None:
        parts.draw_curve(axes, course.t, viscous_nms_per_rad, DRAWN, **truth)
        _draw_steps(course, course.viscous_nms_per_rad, VISCOUS, theme.FILTERED, "(b)", axes)
        axes.lines[-1].set_label("compensated")

    return _column(3.0, partial(_draw_energy, course, "(a)"), below)


def draw_overcompensation(bare: Course, guarded: Course) -> Figure:
    """Draw the net energy without and with the passivity controller, and its damping (Fig. 7)."""
    damping = guarded.damping_nms_per_rad
    return _column(
        3.9,
        partial(_draw_energy, bare, "(a) without passivity controller"),
        partial(_draw_energy, guarded, "(b) with it"),
        partial(_draw_steps, guarded, damping, "Damping\n[N m s/rad]", theme.FITTED, "(c) adaptive damping"),
    )


def _draw_signal(course: Course, signal: Float, label: str, title: str, axes: Axes) -> None:
    _shade(axes, course)
    parts.draw_raw_and_filtered(axes, course.t, signal, DRAWN, lw=0.8)
    parts.label_panel(axes, title, y=label)


def draw_uncompensated(course: Course) -> Figure:
    """Draw velocity and torque, the net energy, and the torque over the velocity (Fig. 8)."""
    return _column(
        5.6,
        partial(_draw_signal, course, course.dq, "Velocity\n[rad/s]", "(a)"),
        partial(_draw_signal, course, course.interaction_nm, "Torque\n[N m]", ""),
        partial(_draw_energy, course, "(b)"),
        partial(_draw_loop, course, "(c)"),
        ratios=(1, 1, 1.2, 2),
    )


def draw_plateaus(raw: Course, aided: Course) -> Figure:
    """Draw torque over velocity without and with compensation, dashed and solid as in the paper (Fig. 9)."""

    def draw(axes: Axes) -> None:
        parts.mark_zero(axes, x=True)
        axes.plot(raw.dq, raw.interaction_nm, color=theme.FITTED, ls=theme.DASHED, lw=1.0, label="combined friction")
        axes.plot(aided.dq, aided.interaction_nm, color=theme.FILTERED, lw=1.0, label="compensated")
        parts.label_panel(axes, y="Interaction torque [N m]")
        axes.set_xlabel("Velocity [rad/s]")

    return _column(2.5, draw)


def draw_compensated(course: Course) -> Figure:
    """Draw velocity and torque, the net energy, and both coefficients (Fig. 10)."""
    return _column(
        5.2,
        partial(_draw_signal, course, course.dq, "Velocity\n[rad/s]", "(a)"),
        partial(_draw_signal, course, course.interaction_nm, "Torque\n[N m]", ""),
        partial(_draw_energy, course, "(b)", plateau=course.ends_j[1]),
        partial(_draw_steps, course, course.viscous_nms_per_rad, VISCOUS, theme.FILTERED, "(c)"),
        partial(_draw_steps, course, course.coulomb_nm, "Coulomb\n[N m]", theme.DISSIPATED, ""),
    )


def draw_compensated_loop(course: Course, without: Course) -> Figure:
    """Draw torque over velocity on the axes of the uncompensated joint (Fig. 11)."""
    figure = _column(2.5, partial(_draw_loop, course, ""))
    reach = 1.05 * float(abs(without.interaction_nm).max())
    figure.axes[0].set_ylim(-reach, reach)
    return figure


@theme.figure_style(mathematics=True)
def draw_whole_arm(courses: Sequence[Course]) -> Figure:
    """Draw a row for every joint: velocity and torque, net energy, both coefficients (Fig. 12)."""
    figure = Figure(figsize=(theme.SHEET_IN, 0.9 + 0.92 * len(courses)), layout="constrained")
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
        middle.plot(course.ends_s, course.ends_j, "o", c=theme.BORDER, ms=2.0, mew=0, zorder=5, label="end of a cycle")
        left.set_ylabel(f"joint {number}")
    titles = ("(a) velocity [rad/s], torque [N m]", "(b) net energy [J]", "(c) coefficients [N m], [N m s/rad]")
    for axes, title in zip(rows[0], titles, strict=True):
        axes.set_title(title, loc="left")
    figure.supxlabel("Time [s]")
    parts.add_legend(figure)
    figure.align_ylabels()
    return figure
